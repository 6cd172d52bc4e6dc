//! The curve between light and grey level that many cameras have: exposure, clipping, gamma.

use crate::canvas::Canvas;
use crate::elementary::{exponential_of_negative, logarithm};

/// How light becomes a grey level: `255 * min(1, exposure * light / 255) ^ (1 / gamma)`. Brightening or clipping after
/// the blur makes white look wider than it is printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Factor on the light; above 1 white is clipped.
    pub exposure: f32,
    /// 1 for a straight line, 2.2 for what screens expect.
    pub gamma: f32,
}

impl Default for Tone {
    /// Grey levels as they are.
    fn default() -> Tone {
        Tone { exposure: 1.0, gamma: 1.0 }
    }
}

impl Tone {
    /// Entries of the table of the curve; between them it is taken as straight.
    const STEPS: usize = 4096;

    /// Applies the curve to the whole canvas.
    pub(crate) fn apply(&self, canvas: &mut Canvas) {
        if *self == Tone::default() {
            return;
        }
        let curve: Vec<f32> = (0..=Tone::STEPS + 1).map(|step| self.level_of_step(step)).collect();
        for pixel in &mut canvas.pixels {
            let place = (self.exposure * *pixel / 255.0).clamp(0.0, 1.0) * Tone::STEPS as f32;
            let step = place as usize;
            *pixel = curve[step] + (curve[step + 1] - curve[step]) * (place - step as f32);
        }
    }

    fn level_of_step(&self, step: usize) -> f32 {
        if step == 0 {
            return 0.0;
        }
        let light = (step as f64 / Tone::STEPS as f64).min(1.0);
        (255.0 * exponential_of_negative(logarithm(light) / f64::from(self.gamma))) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;

    fn toned(level: f32, tone: Tone) -> f32 {
        let mut canvas = Canvas::plain(Window::whole(1, 1), level);
        tone.apply(&mut canvas);
        canvas.pixels[0]
    }

    #[test]
    fn gamma_agrees_with_the_power_function() {
        /// The table's steps are straight lines; its first ones are the coarsest.
        const TABLE: f32 = 0.2;
        for gamma in [0.5_f32, 1.8, 2.2] {
            for level in 1..=255_u8 {
                let expected = 255.0 * (f32::from(level) / 255.0).powf(1.0 / gamma);
                let found = toned(f32::from(level), Tone { exposure: 1.0, gamma });
                assert!((found - expected).abs() < TABLE, "gamma {gamma}, level {level}: {found}");
            }
        }
    }

    #[test]
    fn more_exposure_clips_white_and_nothing_leaves_the_range() {
        let tone = Tone { exposure: 1.5, gamma: 1.0 };
        assert!((toned(100.0, tone) - 150.0).abs() < 0.01);
        assert!((toned(200.0, tone) - 255.0).abs() < 0.01);
        assert_eq!(toned(-20.0, tone), 0.0);
        assert_eq!(toned(137.25, Tone::default()), 137.25);
    }
}
