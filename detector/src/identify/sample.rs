//! Grey values between pixels, at full resolution.

use crate::simd::{self, Level, Pixels};
use crate::view::LumaView;

pub(crate) use crate::simd::LANES;

/// The full-resolution frame.
pub(crate) struct Frame<'a> {
    level: Level,
    pixels: Pixels<'a>,
    size: [usize; 2],
}

impl<'a> Frame<'a> {
    pub(crate) fn new(level: Level, view: &LumaView<'a>) -> Self {
        Self { level, pixels: Pixels::new(view), size: [view.width(), view.height()] }
    }

    /// The level that all work on this frame is done with.
    #[inline(always)]
    pub(crate) fn level(&self) -> Level {
        self.level
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The grey value of a pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, column: usize, row: usize) -> u8 {
        self.pixels.at(column, row)
    }

    /// Whether points lie between the outermost pixel centres, so that they have a grey value: 1 or 0.
    #[inline(always)]
    pub(crate) fn contains_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        simd::contains(self.level, &self.pixels, x, y)
    }

    /// The grey values at points, bilinear between the four pixel centres around each (paper III-D). Those outside of the frame
    /// have the value of a place at its rim.
    #[inline(always)]
    pub(crate) fn near_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        simd::values(self.level, &self.pixels, x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point's grey value, if it has one.
    fn value(frame: &Frame, [x, y]: [f32; 2]) -> Option<f32> {
        let (x, y) = ([x; LANES], [y; LANES]);
        (frame.contains_all(&x, &y) == [1.0; LANES]).then(|| frame.near_all(&x, &y)[0])
    }

    #[test]
    fn pixel_centres_have_their_pixels_value_and_between_them_it_is_linear() {
        let bytes = [0, 40, 80, 120, 10, 50, 90, 130, 20, 60, 100, 140, 30, 70, 110, 150];
        let view = LumaView::grey(&bytes, 4, 4).unwrap();
        let frame = Frame::new(Level::best(), &view);
        assert_eq!(value(&frame, [1.5, 2.5]), Some(60.0));
        assert_eq!(value(&frame, [2.0, 1.0]), Some(65.0));
        assert_eq!(value(&frame, [0.4, 2.0]), None);
        assert_eq!(value(&frame, [2.0, 3.6]), None);
        assert_eq!(value(&frame, [f32::NAN, 2.0]), None);
    }

    #[test]
    fn many_points_have_the_values_of_the_four_pixels_around_each() {
        let bytes: Vec<u8> = (0..400).map(|i| (i * 89 % 251) as u8).collect();
        let view = LumaView::grey(&bytes, 20, 20).unwrap();
        let frame = Frame::new(Level::best(), &view);
        let x: [f32; LANES] = std::array::from_fn(|i| 0.5 + i as f32 * 2.37);
        let y: [f32; LANES] = std::array::from_fn(|i| 19.0 - i as f32 * 1.61);
        let values = frame.near_all(&x, &y);
        for i in 0..LANES {
            let (x, y) = (f64::from(x[i]) - 0.5, f64::from(y[i]) - 0.5);
            let pixel = |dx, dy| {
                let (column, row) = (x as usize + dx, y as usize + dy);
                f64::from(bytes[row * 20 + column])
                    * (1.0 - (x - column as f64).abs())
                    * (1.0 - (y - row as f64).abs())
            };
            let around = pixel(0, 0) + pixel(1, 0) + pixel(0, 1) + pixel(1, 1);
            assert!((f64::from(values[i]) - around).abs() < 1e-3, "{} is not {around}", values[i]);
        }
        let outside = frame.near_all(&[-5.0; LANES], &[f32::NAN; LANES]);
        assert_eq!(outside, [f32::from(bytes[0]); LANES]);
        let beyond = frame.near_all(&[19.5; LANES], &[1e9; LANES]);
        assert!((beyond[0] - f32::from(bytes[399])).abs() < 5.0, "{}", beyond[0]);
    }
}
