//! Motion blur: what moves while the shutter is open.

use crate::canvas::Canvas;
use crate::elementary::sine_cosine;

/// How far the picture moves during the exposure, at constant speed. Truth is where things are half-way.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Motion {
    /// Length of the path in pixels; 0 for none.
    pub length_px: f64,
    /// Direction of the path in radians from right (0) towards down.
    pub direction_rad: f64,
}

/// A filter of few taps: where each lies relative to the pixel, and its weight. The weights add up to 1.
struct Kernel {
    taps: Vec<([isize; 2], f32)>,
}

impl Motion {
    /// A longer path than this leaves nothing to be seen; larger values are taken as this one.
    const LONGEST_PX: f64 = 64.0;
    /// Moments of the exposure for every pixel of the path: steps of a sixteenth are far below what can be seen.
    const MOMENTS_PER_PX: f64 = 16.0;

    /// Moves the whole canvas along the path; what lies outside repeats the border.
    pub(crate) fn apply(&self, canvas: &mut Canvas) {
        if self.length_px.is_nan() || self.length_px <= 0.0 || canvas.window.is_empty() {
            return;
        }
        self.kernel().apply(canvas);
    }

    /// The mean of the picture at many moments, each moved by its part of the path with bilinear interpolation.
    fn kernel(&self) -> Kernel {
        let length = self.length_px.min(Motion::LONGEST_PX);
        let (sine, cosine) = sine_cosine(self.direction_rad);
        let moments = (length * Motion::MOMENTS_PER_PX).ceil().max(1.0);
        let reach = (length / 2.0).ceil() as isize + 1;
        let side = 2 * reach + 1;
        let mut weights = vec![0.0; (side * side) as usize];
        for moment in 0..moments as usize {
            let along = length * ((moment as f64 + 0.5) / moments - 0.5);
            for ([x, y], weight) in around([along * cosine, along * sine]) {
                weights[((y + reach) * side + x + reach) as usize] += weight / moments;
            }
        }
        let place = |index: usize| [index as isize % side - reach, index as isize / side - reach];
        let taps = weights.into_iter().enumerate().filter(|(_, weight)| *weight > 0.0);
        Kernel { taps: taps.map(|(index, weight)| (place(index), weight as f32)).collect() }
    }
}

/// The four whole places around a point and their bilinear weights.
fn around([x, y]: [f64; 2]) -> [([isize; 2], f64); 4] {
    let (left, top) = (x.floor(), y.floor());
    let (right, low) = (x - left, y - top);
    let (column, row) = (left as isize, top as isize);
    [
        ([column, row], (1.0 - right) * (1.0 - low)),
        ([column + 1, row], right * (1.0 - low)),
        ([column, row + 1], (1.0 - right) * low),
        ([column + 1, row + 1], right * low),
    ]
}

impl Kernel {
    fn apply(&self, canvas: &mut Canvas) {
        let (width, height) = (canvas.window.width, canvas.window.height);
        let source = std::mem::take(&mut canvas.pixels);
        let inside = |at: isize, length: usize| at.clamp(0, length as isize - 1) as usize;
        let mut moved = vec![0.0_f32; source.len()];
        for (y, row) in moved.chunks_exact_mut(width).enumerate() {
            for &([dx, dy], weight) in &self.taps {
                let from = &source[inside(y as isize + dy, height) * width..][..width];
                for (x, pixel) in row.iter_mut().enumerate() {
                    *pixel += weight * from[inside(x as isize + dx, width)];
                }
            }
        }
        canvas.pixels = moved;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;
    use crate::random::Stream;

    fn moved(canvas: &Canvas, motion: Motion) -> Canvas {
        let mut canvas = canvas.clone();
        motion.apply(&mut canvas);
        canvas
    }

    fn bright_point() -> Canvas {
        let mut canvas = Canvas::plain(Window::whole(41, 41), 0.0);
        canvas.row_mut(20, 20..21)[0] = 1.0;
        canvas
    }

    #[test]
    fn a_point_stays_in_the_middle_of_its_trace_and_keeps_its_light() {
        const ROUNDING: f64 = 1e-4;
        let mut stream = Stream::new(61);
        for _ in 0..50 {
            let motion =
                Motion { length_px: stream.between(0.1, 12.0), direction_rad: stream.between(-4.0, 4.0) };
            let trace = moved(&bright_point(), motion);
            let (mut light, mut right, mut down) = (0.0, 0.0, 0.0);
            for (index, pixel) in trace.pixels.iter().enumerate() {
                light += f64::from(*pixel);
                right += f64::from(*pixel) * (index as f64 % 41.0 - 20.0).floor();
                down += f64::from(*pixel) * ((index / 41) as f64 - 20.0);
            }
            assert!((light - 1.0).abs() < ROUNDING, "{motion:?}: {light}");
            assert!(right.abs() < ROUNDING && down.abs() < ROUNDING, "{motion:?}: {right}, {down}");
        }
    }

    #[test]
    fn a_horizontal_trace_is_as_long_as_the_path() {
        let trace = moved(&bright_point(), Motion { length_px: 6.0, direction_rad: 0.0 });
        let row = trace.row(20, 0..41);
        assert!(row[18..23].iter().all(|pixel| (pixel - 1.0 / 6.0).abs() < 1e-3), "{row:?}");
        assert!(row[..16].iter().chain(&row[25..]).all(|&pixel| pixel == 0.0));
    }

    #[test]
    fn no_path_changes_nothing_and_a_plain_canvas_stays_plain() {
        assert_eq!(moved(&bright_point(), Motion::default()).pixels, bright_point().pixels);
        assert_eq!(
            moved(&bright_point(), Motion { length_px: f64::NAN, direction_rad: 0.0 }).pixels,
            bright_point().pixels
        );
        let plain = Canvas::plain(Window::whole(9, 7), 80.0);
        let trace = moved(&plain, Motion { length_px: 5.0, direction_rad: 0.7 });
        assert!(trace.pixels.iter().all(|pixel| (pixel - 80.0).abs() < 1e-3));
    }
}
