//! Gaussian blur: what a lens and a sensor do to edges.

use crate::canvas::Canvas;
use crate::elementary::exponential_of_negative;

/// A Gaussian filter, applied along rows and then along columns; what lies outside repeats the border.
#[derive(Clone, Debug)]
pub(crate) struct Blur {
    /// Weights from the outermost left one to the outermost right one; they add up to 1.
    weights: Vec<f32>,
}

/// Memory that a blur needs, kept from one use to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlurScratch {
    padded: Vec<f32>,
    rows: Vec<f32>,
}

impl Blur {
    /// Beyond this many standard deviations the weights are below 1e-4 of the middle one.
    const REACH_IN_SIGMAS: f32 = 4.3;
    /// A wider blur than this leaves nothing to be seen; larger values are taken as this one.
    const LARGEST_SIGMA: f32 = 64.0;

    /// A blur with this standard deviation in pixels; zero, negative or not a number means none.
    pub(crate) fn new(sigma: f32) -> Blur {
        if sigma.is_nan() || sigma <= 0.0 {
            return Blur { weights: vec![1.0] };
        }
        let sigma = sigma.min(Blur::LARGEST_SIGMA);
        let reach = (Blur::REACH_IN_SIGMAS * sigma).ceil() as i32;
        let bell = |x: i32| {
            let deviations = f64::from(x) / f64::from(sigma);
            exponential_of_negative(-0.5 * deviations * deviations)
        };
        let sum: f64 = (-reach..=reach).map(bell).sum();
        Blur { weights: (-reach..=reach).map(|x| (bell(x) / sum) as f32).collect() }
    }

    /// How many pixels away from a pixel others still have an influence on it.
    pub(crate) fn reach(&self) -> usize {
        self.weights.len() / 2
    }

    /// Blurs the whole canvas.
    pub(crate) fn apply(&self, canvas: &mut Canvas, scratch: &mut BlurScratch) {
        if self.reach() == 0 || canvas.window.is_empty() {
            return;
        }
        scratch.rows.resize(canvas.pixels.len(), 0.0);
        self.along_rows(canvas, scratch);
        self.along_columns(&scratch.rows, canvas);
    }

    fn along_rows(&self, canvas: &Canvas, scratch: &mut BlurScratch) {
        let width = canvas.window.width;
        scratch.padded.resize(width + 2 * self.reach(), 0.0);
        for (row, output) in canvas.pixels.chunks_exact(width).zip(scratch.rows.chunks_exact_mut(width)) {
            self.pad(row, &mut scratch.padded);
            let shifted = |tap: usize| &scratch.padded[tap..tap + width];
            self.weighted_sum(shifted, output);
        }
    }

    fn along_columns(&self, rows: &[f32], canvas: &mut Canvas) {
        let (width, last) = (canvas.window.width, canvas.window.height - 1);
        for (y, output) in canvas.pixels.chunks_exact_mut(width).enumerate() {
            let shifted = |tap: usize| {
                let source = (y + tap).saturating_sub(self.reach()).min(last);
                &rows[source * width..][..width]
            };
            self.weighted_sum(shifted, output);
        }
    }

    /// Copies a row between repetitions of its first and its last pixel.
    fn pad(&self, row: &[f32], padded: &mut [f32]) {
        let (before, after) = (self.reach(), self.reach() + row.len());
        padded[..before].fill(row[0]);
        padded[before..after].copy_from_slice(row);
        padded[after..].fill(row[row.len() - 1]);
    }

    /// The sum over all taps of weight times pixels; `shifted` gives the pixels of a tap. Tap by tap over short
    /// pieces of the row, so that the inner loop runs in vector registers and the piece stays in the L1 cache.
    fn weighted_sum<'a>(&self, shifted: impl Fn(usize) -> &'a [f32], output: &mut [f32]) {
        const PIECE: usize = 64;
        for (index, piece) in output.chunks_mut(PIECE).enumerate() {
            piece.fill(0.0);
            for (tap, weight) in self.weights.iter().enumerate() {
                for (sum, pixel) in piece.iter_mut().zip(&shifted(tap)[index * PIECE..]) {
                    *sum += weight * pixel;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;
    use crate::random::Stream;

    fn blurred(mut canvas: Canvas, sigma: f32) -> Canvas {
        Blur::new(sigma).apply(&mut canvas, &mut BlurScratch::default());
        canvas
    }

    #[test]
    fn blurring_keeps_the_mean_of_what_lies_away_from_the_border() {
        let mut canvas = Canvas::plain(Window::whole(97, 83), 50.0);
        let mut stream = Stream::new(41);
        for y in 20..60 {
            canvas.row_mut(y, 20..70).fill_with(|| stream.between(0.0, 255.0) as f32);
        }
        let mean = |canvas: &Canvas| canvas.pixels.iter().map(|&p| f64::from(p)).sum::<f64>() / 97.0 / 83.0;
        let before = mean(&canvas);
        for sigma in [0.0, 0.01, 0.4, 0.8, 2.0] {
            assert!((mean(&blurred(canvas.clone(), sigma)) - before).abs() < 1e-3, "sigma {sigma}");
        }
    }

    #[test]
    fn a_single_bright_pixel_spreads_with_the_variance_asked_for() {
        /// Weights are the bell's height at whole pixels, which below one pixel of sigma is a little too narrow.
        const SAMPLING: f32 = 0.015;
        for sigma in [0.6_f32, 0.8, 1.5, 3.0] {
            let mut canvas = Canvas::plain(Window::whole(41, 41), 0.0);
            canvas.row_mut(20, 20..21)[0] = 1.0;
            let canvas = blurred(canvas, sigma);
            let moment = |row: usize| {
                let weights = canvas.row(row, 0..41).iter().enumerate();
                weights.map(|(x, &value)| (x as f32 - 20.0).powi(2) * value).sum::<f32>()
            };
            let variance: f32 = (0..41).map(moment).sum();
            assert!((variance.sqrt() / sigma - 1.0).abs() < SAMPLING, "sigma {sigma}: {}", variance.sqrt());
        }
    }

    #[test]
    fn a_plain_canvas_stays_plain_up_to_its_border() {
        let canvas = blurred(Canvas::plain(Window::whole(5, 3), 77.0), 1.2);
        assert!(canvas.pixels.iter().all(|pixel| (pixel - 77.0).abs() < 1e-4));
    }

    #[test]
    fn a_blur_of_zero_changes_nothing() {
        let mut canvas = Canvas::plain(Window::whole(8, 1), 0.0);
        canvas.row_mut(0, 0..4).fill(200.0);
        assert_eq!(blurred(canvas.clone(), 0.0).pixels, canvas.pixels);
        assert_eq!(blurred(canvas.clone(), f32::NAN).pixels, canvas.pixels);
    }
}
