//! Grey values between pixels, at full resolution.

use crate::binarize::raster::{Raster, Sampled};
use crate::view::LumaView;

/// The full-resolution frame.
pub(crate) struct Frame<'a> {
    pixels: Sampled<'a>,
    last: [f32; 2],
}

impl<'a> Frame<'a> {
    pub(crate) fn new(view: &LumaView<'a>) -> Self {
        let last = [view.width() as f32 - 1.0, view.height() as f32 - 1.0];
        Self { pixels: Sampled::new(view, 1), last }
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.pixels.width(), self.pixels.height()]
    }

    /// The grey value of a pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, column: usize, row: usize) -> u8 {
        self.pixels.at(column, row)
    }

    /// Whether a point lies between the outermost pixel centres, so that it has a grey value.
    #[inline(always)]
    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        let (x, y) = (point[0] as f32 - 0.5, point[1] as f32 - 0.5);
        x >= 0.0 && y >= 0.0 && x < self.last[0] && y < self.last[1]
    }

    /// The grey value at a point, bilinear between the four pixel centres around it (paper III-D). `None` outside of the
    /// outermost pixel centres.
    #[inline(always)]
    pub(crate) fn at(&self, point: [f64; 2]) -> Option<f32> {
        self.contains(point).then(|| self.inside(point[0] as f32, point[1] as f32))
    }

    /// As [`Self::contains`], for many points: 1 or 0.
    #[inline(always)]
    pub(crate) fn contains_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        let mut inside = [0.0; LANES];
        for i in 0..LANES {
            let (x, y) = (x[i] - 0.5, y[i] - 0.5);
            let is_inside = (x >= 0.0) & (y >= 0.0) & (x < self.last[0]) & (y < self.last[1]);
            inside[i] = if is_inside { 1.0 } else { 0.0 };
        }
        inside
    }

    /// The grey value at a point that the frame contains.
    #[inline(always)]
    pub(crate) fn inside(&self, x: f32, y: f32) -> f32 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x - column as f32, y - row as f32);
        let upper = between(self.pixels.pair(column, row), right);
        let lower = between(self.pixels.pair(column, row + 1), right);
        upper + (lower - upper) * down
    }
}

/// Points that are sampled together: arithmetic on all of them is done in vectors.
pub(crate) const LANES: usize = 8;

/// How near points may come to the last pixel's centre: more than f32 rounds a coordinate of the largest frames.
const RIM: f32 = 0.01;

impl Frame<'_> {
    /// As [`Self::inside`], for many points. Those outside of the frame have the value of a place at its rim.
    #[inline(always)]
    pub(crate) fn near_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        let (mut columns, mut rows) = ([0i32; LANES], [0i32; LANES]);
        let (mut right, mut down) = ([0.0f32; LANES], [0.0f32; LANES]);
        for i in 0..LANES {
            let x = (x[i] - 0.5).max(0.0).min(self.last[0] - RIM);
            let y = (y[i] - 0.5).max(0.0).min(self.last[1] - RIM);
            (columns[i], rows[i]) = (x as i32, y as i32);
            right[i] = x - columns[i] as f32;
            down[i] = y - rows[i] as f32;
        }
        let mut corners = [[0u8; LANES]; 4];
        for i in 0..LANES {
            let square = self.pixels.square(columns[i] as usize, rows[i] as usize);
            for (corners, corner) in corners.iter_mut().zip(square) {
                corners[i] = corner;
            }
        }
        let mut values = [0.0f32; LANES];
        for i in 0..LANES {
            let upper = between([corners[0][i], corners[1][i]], right[i]);
            let lower = between([corners[2][i], corners[3][i]], right[i]);
            values[i] = upper + (lower - upper) * down[i];
        }
        values
    }
}

/// The value `share` of the way from one pixel to the next.
#[inline(always)]
fn between([left, right]: [u8; 2], share: f32) -> f32 {
    let (left, right) = (f32::from(left), f32::from(right));
    left + (right - left) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_centres_have_their_pixels_value_and_between_them_it_is_linear() {
        let bytes = [0, 40, 80, 120, 10, 50, 90, 130, 20, 60, 100, 140, 30, 70, 110, 150];
        let view = LumaView::grey(&bytes, 4, 4).unwrap();
        let frame = Frame::new(&view);
        assert_eq!(frame.at([1.5, 2.5]), Some(60.0));
        assert_eq!(frame.at([2.0, 1.0]), Some(65.0));
        assert_eq!(frame.at([0.4, 2.0]), None);
        assert_eq!(frame.at([2.0, 3.6]), None);
        assert_eq!(frame.at([f64::NAN, 2.0]), None);
    }

    #[test]
    fn many_points_have_the_values_that_each_has_alone() {
        let bytes: Vec<u8> = (0..400).map(|i| (i * 89 % 251) as u8).collect();
        let view = LumaView::grey(&bytes, 20, 20).unwrap();
        let frame = Frame::new(&view);
        let x: [f32; LANES] = std::array::from_fn(|i| 0.5 + i as f32 * 2.37);
        let y: [f32; LANES] = std::array::from_fn(|i| 19.0 - i as f32 * 1.61);
        let alone: [f32; LANES] = std::array::from_fn(|i| frame.inside(x[i], y[i]));
        assert_eq!(frame.near_all(&x, &y), alone);
        let outside = frame.near_all(&[-5.0; LANES], &[f32::NAN; LANES]);
        assert_eq!(outside, [f32::from(bytes[0]); LANES]);
        let beyond = frame.near_all(&[19.5; LANES], &[1e9; LANES]);
        assert!((beyond[0] - f32::from(bytes[399])).abs() < 5.0, "{}", beyond[0]);
    }
}
