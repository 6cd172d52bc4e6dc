//! Textures without pictures: value noise, and what a tag may lie on.

use crate::canvas::Canvas;
use crate::random::{key_for, number_at, unit_from};

/// What is behind the tags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// One grey level, 0..=255.
    Plain(f32),
    /// A linear gradient from the top-left corner of the picture to the bottom-right one.
    Gradient {
        /// Grey level in the top-left corner.
        top_left: f32,
        /// Grey level in the bottom-right corner.
        bottom_right: f32,
    },
    /// Cloudy structure at many sizes, from a third of the picture's height down to two pixels; it follows the
    /// picture's seed.
    Textured {
        /// Mean grey level.
        level: f32,
        /// Largest deviation from the mean.
        amplitude: f32,
    },
}

impl Background {
    /// Fills the canvas, which is the whole picture.
    pub(crate) fn fill(&self, canvas: &mut Canvas, seed: u64) {
        let (width, height) = (canvas.window.width, canvas.window.height);
        match *self {
            Background::Plain(level) => canvas.pixels.fill(level),
            Background::Gradient { top_left, bottom_right } => fill_pixels(canvas, |x, y| {
                let share = ((x as f32 + 0.5) / width as f32 + (y as f32 + 0.5) / height as f32) / 2.0;
                top_left + share * (bottom_right - top_left)
            }),
            Background::Textured { level, amplitude } => {
                let clouds = Clouds::new(seed, height as f32 / 3.0);
                fill_pixels(canvas, |x, y| level + amplitude * clouds.at(x as f32, y as f32));
            }
        }
    }
}

fn fill_pixels(canvas: &mut Canvas, level_at: impl Fn(usize, usize) -> f32) {
    let window = canvas.window;
    for y in window.rows() {
        for (pixel, x) in canvas.row_mut(y, window.columns()).iter_mut().zip(window.columns()) {
            *pixel = level_at(x, y);
        }
    }
}

/// Value noise: octaves of random heights on square lattices, each half as coarse and weaker than the one before.
pub(crate) struct Clouds {
    /// Key, lattice spacing in pixels and weight of each octave; the weights add up to 1.
    octaves: Vec<(u64, f32, f32)>,
}

impl Clouds {
    /// The finest lattice, in pixels; finer structure would be noise.
    const FINEST_PX: f32 = 2.0;
    /// The weight of an octave against the next coarser one.
    const ROUGHNESS: f32 = 0.6;

    /// Noise whose largest structures are `coarsest_px` wide.
    pub(crate) fn new(seed: u64, coarsest_px: f32) -> Clouds {
        let spacings =
            std::iter::successors(Some(coarsest_px.max(Clouds::FINEST_PX)), |spacing| Some(spacing / 2.0));
        let weights = std::iter::successors(Some(1.0_f32), |weight| Some(weight * Clouds::ROUGHNESS));
        let mut octaves: Vec<(u64, f32, f32)> = spacings
            .take_while(|&spacing| spacing >= Clouds::FINEST_PX)
            .zip(weights)
            .zip(0..)
            .map(|((spacing, weight), octave)| (key_for(seed, octave), spacing, weight))
            .collect();
        let sum: f32 = octaves.iter().map(|octave| octave.2).sum();
        octaves.iter_mut().for_each(|octave| octave.2 /= sum);
        Clouds { octaves }
    }

    /// The value at a place of the picture in pixels (neither coordinate negative), between -1 and 1.
    pub(crate) fn at(&self, x: f32, y: f32) -> f32 {
        self.octaves
            .iter()
            .map(|&(key, spacing, weight)| weight * smooth_noise(key, x / spacing, y / spacing))
            .sum()
    }
}

/// Random heights at whole coordinates, between them a smooth blend of the four neighbours.
fn smooth_noise(key: u64, x: f32, y: f32) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let (across, down) = (smooth_step(x - column), smooth_step(y - row));
    let (column, row) = (column as u64, row as u64);
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    let upper = mix(height_at(key, column, row), height_at(key, column + 1, row), across);
    let lower = mix(height_at(key, column, row + 1), height_at(key, column + 1, row + 1), across);
    mix(upper, lower, down)
}

fn height_at(key: u64, column: u64, row: u64) -> f32 {
    (2.0 * unit_from(number_at(key, row << 32 | column)) - 1.0) as f32
}

fn smooth_step(share: f32) -> f32 {
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;

    fn filled(background: Background, seed: u64) -> Canvas {
        let mut canvas = Canvas::plain(Window::whole(120, 90), 0.0);
        background.fill(&mut canvas, seed);
        canvas
    }

    #[test]
    fn a_textured_background_stays_within_its_amplitude_and_uses_it() {
        let canvas = filled(Background::Textured { level: 100.0, amplitude: 40.0 }, 4);
        let low = canvas.pixels.iter().copied().fold(f32::INFINITY, f32::min);
        let high = canvas.pixels.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!(low >= 60.0 && high <= 140.0, "{low}..{high}");
        assert!(high - low > 30.0, "{low}..{high}");
    }

    #[test]
    fn neighbours_in_a_texture_are_alike_and_other_seeds_differ() {
        let background = Background::Textured { level: 100.0, amplitude: 40.0 };
        let (one, other) = (filled(background, 4), filled(background, 5));
        let change = one.pixels.windows(2).map(|pair| (pair[0] - pair[1]).abs()).sum::<f32>();
        let difference = one.pixels.iter().zip(&other.pixels).map(|(a, b)| (a - b).abs()).sum::<f32>();
        assert!(change < difference / 2.0, "{change} against {difference}");
    }

    #[test]
    fn a_gradient_rises_from_corner_to_corner() {
        let canvas = filled(Background::Gradient { top_left: 20.0, bottom_right: 220.0 }, 0);
        let (first, last) = (canvas.pixels[0], canvas.pixels[120 * 90 - 1]);
        assert!((first - 20.0).abs() < 2.0 && (last - 220.0).abs() < 2.0);
    }
}
