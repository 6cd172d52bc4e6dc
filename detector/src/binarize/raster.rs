//! The grid on which quads are looked for: the frame itself, or a decimated view of it that is never stored.

use crate::settings::Decimation;
use crate::simd::{self, Level};
use crate::view::LumaView;

/// Grey values on the search grid, and where a point of the grid lies in the frame.
pub(crate) trait Raster: Copy + Send + Sync {
    /// Whether values are averages of pixels that neighbouring values share.
    const ARE_AVERAGES: bool;
    /// Columns of the grid.
    fn width(&self) -> usize;
    /// Rows of the grid.
    fn height(&self) -> usize;
    /// One value.
    fn at(&self, x: usize, y: usize) -> u8;
    /// Makes row `y` contiguous in `slot`, which takes a row, unless it is so in the frame.
    fn fetch(&self, level: Level, y: usize, slot: &mut [u8]);
    /// A row that was fetched into `slot`: there, or where it lies in the frame.
    fn fetched<'s>(&'s self, y: usize, slot: &'s [u8]) -> &'s [u8];
    /// A point of the grid (corner of its first value at 0, 0) in pixels of the frame.
    fn to_frame(&self, point: [f64; 2]) -> [f64; 2];
}

/// Every `factor`-th pixel of every `factor`-th row (point sampling, paper III-C). With factor 1 the frame as it is.
#[derive(Clone, Copy)]
pub(crate) struct Sampled<'a> {
    bytes: &'a [u8],
    width: usize,
    height: usize,
    row_stride: usize,
    step: usize,
    factor: f64,
}

impl<'a> Sampled<'a> {
    pub(crate) fn new(view: &LumaView<'a>, factor: usize) -> Self {
        let geometry = view.geometry();
        Self {
            bytes: &view.bytes()[geometry.offset..],
            width: geometry.width.div_ceil(factor),
            height: geometry.height.div_ceil(factor),
            row_stride: geometry.row_stride * factor,
            step: geometry.pixel_step * factor,
            factor: factor as f64,
        }
    }

    /// The bytes from the first value of a row to its last.
    #[inline(always)]
    fn span(&self, y: usize) -> &[u8] {
        &self.bytes[y * self.row_stride..][..(self.width - 1) * self.step + 1]
    }

    /// A value and the one on its right.
    #[inline(always)]
    pub(crate) fn pair(&self, x: usize, y: usize) -> [u8; 2] {
        let pair = &self.bytes[y * self.row_stride + x * self.step..][..self.step + 1];
        [pair[0], pair[self.step]]
    }
}

impl Sampled<'_> {
    /// A value, the one on its right, and the two below these.
    #[inline(always)]
    pub(crate) fn square(&self, x: usize, y: usize) -> [u8; 4] {
        let (right, below) = (self.step, self.row_stride);
        let square = &self.bytes[y * self.row_stride + x * self.step..][..below + right + 1];
        [square[0], square[right], square[below], square[below + right]]
    }
}

impl Raster for Sampled<'_> {
    const ARE_AVERAGES: bool = false;

    fn width(&self) -> usize {
        self.width
    }

    fn height(&self) -> usize {
        self.height
    }

    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> u8 {
        self.bytes[y * self.row_stride + x * self.step]
    }

    #[inline(always)]
    fn fetch(&self, level: Level, y: usize, slot: &mut [u8]) {
        if self.step != 1 {
            simd::every(level, self.span(y), self.step, slot);
        }
    }

    #[inline(always)]
    fn fetched<'s>(&'s self, y: usize, slot: &'s [u8]) -> &'s [u8] {
        if self.step == 1 { self.span(y) } else { slot }
    }

    /// The value at column x is the pixel `factor * x`, whose centre lies half a pixel further, whatever the factor.
    fn to_frame(&self, point: [f64; 2]) -> [f64; 2] {
        point.map(|v| (v - 0.5) * self.factor + 0.5)
    }
}

/// Three pixels become two: each value averages the 1.5 x 1.5 pixels that it covers.
#[derive(Clone, Copy)]
pub(crate) struct ThreeToTwo<'a> {
    full: Sampled<'a>,
}

impl<'a> ThreeToTwo<'a> {
    pub(crate) fn new(view: &LumaView<'a>) -> Self {
        Self { full: Sampled::new(view, 1) }
    }

    /// The full and the half covered column (or row) of grid column `v`.
    #[inline(always)]
    fn covered(v: usize) -> (usize, usize) {
        let block = v / 2 * 3;
        (block + 2 * (v % 2), block + 1)
    }
}

impl Raster for ThreeToTwo<'_> {
    const ARE_AVERAGES: bool = true;

    fn width(&self) -> usize {
        (self.full.width / 3 * 2).max(1)
    }

    fn height(&self) -> usize {
        (self.full.height / 3 * 2).max(1)
    }

    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> u8 {
        let ((x0, x1), (y0, y1)) = (Self::covered(x), Self::covered(y));
        simd::average(
            [self.full.at(x0, y0), self.full.at(x1, y0)],
            [self.full.at(x0, y1), self.full.at(x1, y1)],
        )
    }

    #[inline(always)]
    fn fetch(&self, level: Level, y: usize, slot: &mut [u8]) {
        if self.full.step != 1 {
            for (x, to) in slot.iter_mut().enumerate() {
                *to = self.at(x, y);
            }
            return;
        }
        let (full, half) = Self::covered(y);
        let line = |y: usize| &self.full.bytes[y * self.full.row_stride..][..slot.len() / 2 * 3];
        let (full, half) = (line(full), line(half));
        simd::three_to_two(level, full, half, slot);
    }

    #[inline(always)]
    fn fetched<'s>(&'s self, _y: usize, slot: &'s [u8]) -> &'s [u8] {
        slot
    }

    fn to_frame(&self, point: [f64; 2]) -> [f64; 2] {
        point.map(|v| v * 1.5)
    }
}

/// Calls `work` with the raster that `decimation` asks for.
pub(crate) fn with_raster<'a, W: OnRaster>(
    view: &LumaView<'a>,
    decimation: Decimation,
    work: W,
) -> W::Output {
    match decimation {
        Decimation::Every(factor) => work.on(Sampled::new(view, factor as usize)),
        Decimation::ThreeToTwo => work.on(ThreeToTwo::new(view)),
    }
}

/// Work that is compiled once for each kind of raster.
pub(crate) trait OnRaster {
    type Output;
    fn on<R: Raster>(self, raster: R) -> Self::Output;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Geometry;

    fn ramp(width: usize, height: usize) -> Vec<u8> {
        (0..width * height).map(|i| (i * 7 % 251) as u8).collect()
    }

    fn rows_agree_with_single_values<R: Raster>(raster: R) {
        let mut slot = vec![0; raster.width()];
        for y in 0..raster.height() {
            for level in Level::available() {
                raster.fetch(level, y, &mut slot);
                let row = raster.fetched(y, &slot);
                assert_eq!(row.len(), raster.width());
                for (x, value) in row.iter().enumerate() {
                    assert_eq!(*value, raster.at(x, y), "at {x}, {y}, {level}");
                }
            }
        }
    }

    #[test]
    fn rows_hold_the_same_values_as_single_reads_for_every_factor_and_step() {
        let bytes = ramp(700, 23);
        for step in [1, 2, 3] {
            let geometry = Geometry { offset: 1, width: 230, height: 23, row_stride: 699, pixel_step: step };
            let view = LumaView::new(&bytes, geometry).unwrap();
            for factor in 1..=8 {
                rows_agree_with_single_values(Sampled::new(&view, factor));
            }
            rows_agree_with_single_values(ThreeToTwo::new(&view));
        }
    }

    #[test]
    fn the_frame_itself_is_handed_out_where_it_lies() {
        let bytes = ramp(40, 10);
        let view = LumaView::grey(&bytes, 40, 10).unwrap();
        let raster = Sampled::new(&view, 1);
        let mut slot = vec![0; 40];
        raster.fetch(Level::best(), 3, &mut slot);
        assert!(std::ptr::eq(raster.fetched(3, &slot).as_ptr(), &raw const bytes[120]), "row 3 was copied");
    }

    #[test]
    fn a_grid_value_maps_to_the_centre_of_what_it_was_taken_from() {
        let bytes = ramp(40, 40);
        let view = LumaView::grey(&bytes, 40, 40).unwrap();
        assert_eq!(Sampled::new(&view, 4).to_frame([2.5, 0.5]), [8.5, 0.5]);
        assert_eq!(ThreeToTwo::new(&view).to_frame([2.0, 4.0]), [3.0, 6.0]);
    }
}
