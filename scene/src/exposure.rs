//! From grey levels to the bytes of a camera: light, noise, rounding.

use crate::canvas::Window;
use crate::random::{Normals, number_at};

/// How bright the light is and how it falls off over the picture: grey levels are multiplied by
/// `gain * (1 + slope_x * (x / width - 1/2) + slope_y * (y / height - 1/2))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Factor in the middle of the picture.
    pub gain: f32,
    /// Relative change from the left border to the right one.
    pub slope_x: f32,
    /// Relative change from the top border to the bottom one.
    pub slope_y: f32,
}

impl Default for Light {
    /// Even light that leaves grey levels as they are.
    fn default() -> Light {
        Light { gain: 1.0, slope_x: 0.0, slope_y: 0.0 }
    }
}

/// Everything that happens between a grey level and its byte.
pub(crate) struct Exposure<'a> {
    pub light: Light,
    pub noise_sigma: f32,
    /// The key of this picture's noise; every pixel's noise depends on the key and the pixel's place only.
    pub noise_key: u64,
    pub normals: &'a Normals,
    /// The whole picture.
    pub frame: Window,
}

impl Exposure<'_> {
    /// Develops the pixels of row `y` from column `left` on.
    pub(crate) fn develop(&self, y: usize, left: usize, levels: impl Iterator<Item = f32>, bytes: &mut [u8]) {
        let width = self.frame.width as f32;
        let height = self.frame.height as f32;
        let fall_off = self.light.slope_y * ((y as f32 + 0.5) / height - 0.5) - 0.5 * self.light.slope_x;
        let step = self.light.gain * self.light.slope_x / width;
        let start = self.light.gain * (1.0 + fall_off) + 0.5 * step;
        let place = (y * self.frame.width) as u64;
        for (x, (level, byte)) in (left..).zip(levels.zip(bytes)) {
            let noise = self.normals.draw(number_at(self.noise_key, place + x as u64));
            // Adding a half and cutting off rounds; the conversion stops at 0 and 255.
            *byte = (level * (start + step * x as f32) + self.noise_sigma * noise + 0.5) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 200;
    const HEIGHT: usize = 150;

    fn developed(light: Light, noise_sigma: f32, noise_key: u64, level: f32) -> Vec<u8> {
        let (normals, frame) = (Normals::new(), Window::whole(WIDTH, HEIGHT));
        let exposure = Exposure { light, noise_sigma, noise_key, normals: &normals, frame };
        let mut bytes = vec![0; WIDTH * HEIGHT];
        for (y, row) in bytes.chunks_exact_mut(WIDTH).enumerate() {
            exposure.develop(y, 0, std::iter::repeat(level), row);
        }
        bytes
    }

    fn mean_and_deviation(bytes: &[u8]) -> (f64, f64) {
        let count = bytes.len() as f64;
        let mean = bytes.iter().map(|&byte| f64::from(byte)).sum::<f64>() / count;
        let variance = bytes.iter().map(|&byte| (f64::from(byte) - mean).powi(2)).sum::<f64>() / count;
        (mean, variance.sqrt())
    }

    #[test]
    fn the_noise_has_the_deviation_asked_for_within_3_percent() {
        for sigma in [1.0_f32, 2.0, 5.0, 12.0] {
            let (mean, deviation) = mean_and_deviation(&developed(Light::default(), sigma, 9, 128.0));
            // Rounding to whole grey levels adds a variance of 1/12.
            let expected = (f64::from(sigma).powi(2) + 1.0 / 12.0).sqrt();
            assert!((deviation / expected - 1.0).abs() < 0.03, "sigma {sigma}: {deviation}");
            assert!((mean - 128.0).abs() < 0.03 * f64::from(sigma), "sigma {sigma}: mean {mean}");
        }
    }

    #[test]
    fn noise_of_neighbours_and_of_other_keys_is_independent() {
        let [one, other] = [1, 2].map(|key| developed(Light::default(), 10.0, key, 128.0));
        let correlation = |a: &[u8], b: &[u8]| {
            let products = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - 128.0) * (f64::from(b) - 128.0));
            products.sum::<f64>() / a.len() as f64 / 100.0
        };
        assert!(correlation(&one, &other).abs() < 0.03);
        assert!(correlation(&one[1..], &one[..one.len() - 1]).abs() < 0.03);
        assert!(correlation(&one[WIDTH..], &one[..one.len() - WIDTH]).abs() < 0.03);
    }

    #[test]
    fn a_part_of_a_row_is_developed_as_in_the_whole_row() {
        let (normals, frame) = (Normals::new(), Window::whole(WIDTH, HEIGHT));
        let light = Light { gain: 1.1, slope_x: 0.2, slope_y: -0.1 };
        let exposure = Exposure { light, noise_sigma: 4.0, noise_key: 5, normals: &normals, frame };
        let (mut whole, mut part) = ([0; WIDTH], [0; 30]);
        exposure.develop(7, 0, std::iter::repeat(99.0), &mut whole);
        exposure.develop(7, 100, std::iter::repeat(99.0), &mut part);
        assert_eq!(part, whole[100..130]);
    }

    #[test]
    fn light_falls_off_as_asked_and_never_wraps_round() {
        let light = Light { gain: 1.5, slope_x: 0.4, slope_y: 0.2 };
        let bytes = developed(light, 0.0, 0, 100.0);
        let row = &bytes[75 * WIDTH..][..WIDTH];
        assert!((f32::from(row[0]) - 120.0).abs() <= 1.0 && (f32::from(row[199]) - 180.0).abs() <= 1.0);
        assert!(developed(light, 0.0, 0, 250.0).iter().all(|&byte| byte > 200));
        assert!(developed(light, 0.0, 0, -50.0).iter().all(|&byte| byte == 0));
    }
}
