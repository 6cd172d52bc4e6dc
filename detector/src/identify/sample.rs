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
}
