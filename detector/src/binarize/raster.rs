//! The grid on which quads are looked for: the frame itself, or a decimated view of it that is never stored.

use crate::settings::{Decimation, Sampling};
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
    /// Whether rows are contiguous only once they are fetched.
    fn must_be_fetched(&self) -> bool {
        true
    }
    /// Makes row `y` contiguous in `slot`, which takes a row, unless it is so in the frame.
    fn fetch(&self, level: Level, y: usize, slot: &mut [u8]);
    /// A row that was fetched into `slot`: there, or where it lies in the frame.
    fn fetched<'s>(&'s self, y: usize, slot: &'s [u8]) -> &'s [u8];
    /// Brings the pixels of some rows near, which may lie far apart.
    fn touch<const ROWS: usize>(&self, ys: [usize; ROWS]);
    /// A point of the grid (corner of its first value at 0, 0) in pixels of the frame.
    fn to_frame(&self, point: [f64; 2]) -> [f64; 2];
    /// Pixels of the frame from a value to the next.
    #[inline(always)]
    fn pitch(&self) -> f64 {
        self.to_frame([1.0, 0.0])[0] - self.to_frame([0.0, 0.0])[0]
    }
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

    fn must_be_fetched(&self) -> bool {
        self.step != 1
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

    #[inline(always)]
    fn touch<const ROWS: usize>(&self, ys: [usize; ROWS]) {
        simd::touch(ys.map(|y| self.span(y)));
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

    #[inline(always)]
    fn touch<const ROWS: usize>(&self, ys: [usize; ROWS]) {
        self.full.touch(ys.map(|y| Self::covered(y).0));
        self.full.touch(ys.map(|y| Self::covered(y).1));
    }

    fn to_frame(&self, point: [f64; 2]) -> [f64; 2] {
        point.map(|v| v * 1.5)
    }
}

/// One value for all pixels of a square block.
#[derive(Clone, Copy)]
pub(crate) struct Merged<'a, K> {
    full: Sampled<'a>,
    factor: usize,
    kind: K,
}

/// What becomes of the pixels of a block.
pub(crate) trait OfBlock: Copy + Send + Sync {
    /// What is known of no pixel.
    const NOTHING: u16;
    /// One pixel taken into what is known of others, at most 64 of them.
    fn add(self, known: u16, pixel: u8) -> u16;
    /// What is known of some pixels taken into what is known of others.
    fn join(self, known: u32, others: u16) -> u32;
    /// The block's value, from what is known of so many pixels.
    fn value(self, known: u32, pixels: u32) -> u8;
    /// Values of two rows, two pixels wide each; how many are done, the others being left to single reads.
    fn pairs(self, level: Level, rows: [&[u8]; 2], out: &mut [u8]) -> usize;
}

/// The mean.
#[derive(Clone, Copy)]
pub(crate) struct Mean;

/// The least.
#[derive(Clone, Copy)]
pub(crate) struct Darkest;

impl OfBlock for Mean {
    const NOTHING: u16 = 0;

    #[inline(always)]
    fn add(self, known: u16, pixel: u8) -> u16 {
        known + u16::from(pixel)
    }

    #[inline(always)]
    fn join(self, known: u32, others: u16) -> u32 {
        known + u32::from(others)
    }

    #[inline(always)]
    fn value(self, known: u32, pixels: u32) -> u8 {
        ((known + pixels / 2) / pixels) as u8
    }

    #[inline(always)]
    fn pairs(self, level: Level, rows: [&[u8]; 2], out: &mut [u8]) -> usize {
        simd::pair_means(level, rows, out)
    }
}

impl OfBlock for Darkest {
    const NOTHING: u16 = 255;

    #[inline(always)]
    fn add(self, known: u16, pixel: u8) -> u16 {
        known.min(u16::from(pixel))
    }

    #[inline(always)]
    fn join(self, known: u32, others: u16) -> u32 {
        known.min(u32::from(others))
    }

    #[inline(always)]
    fn value(self, known: u32, _pixels: u32) -> u8 {
        known as u8
    }

    #[inline(always)]
    fn pairs(self, level: Level, rows: [&[u8]; 2], out: &mut [u8]) -> usize {
        simd::pair_minima(level, rows, out)
    }
}

impl<K: OfBlock> Merged<'_, K> {
    /// Values of a row from `first` on: columns of pixels first, many at a time, and these joined to blocks.
    #[inline(always)]
    fn fetch_from(&self, first: usize, y: usize, slot: &mut [u8]) {
        const PIXELS: usize = 192;
        let factor = self.factor;
        let blocks = PIXELS / factor;
        for (part, values) in slot[first..].chunks_mut(blocks).enumerate() {
            let from = (first + part * blocks) * factor;
            let pixels = values.len() * factor;
            let mut columns = [K::NOTHING; PIXELS];
            for row in 0..factor {
                let row = &self.full.span(y * factor + row)[from..from + pixels];
                for (column, pixel) in columns.iter_mut().zip(row) {
                    *column = self.kind.add(*column, *pixel);
                }
            }
            for (value, columns) in values.iter_mut().zip(columns.chunks_exact(factor)) {
                let mut known = u32::from(K::NOTHING);
                for column in columns {
                    known = self.kind.join(known, *column);
                }
                *value = self.kind.value(known, (factor * factor) as u32);
            }
        }
    }
}

impl<K: OfBlock> Raster for Merged<'_, K> {
    // Not of shared pixels, but their noise is as weak.
    const ARE_AVERAGES: bool = true;

    fn width(&self) -> usize {
        self.full.width / self.factor
    }

    fn height(&self) -> usize {
        self.full.height / self.factor
    }

    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> u8 {
        let mut known = u32::from(K::NOTHING);
        for column in 0..self.factor {
            let mut of_column = K::NOTHING;
            for row in 0..self.factor {
                let pixel = self.full.at(x * self.factor + column, y * self.factor + row);
                of_column = self.kind.add(of_column, pixel);
            }
            known = self.kind.join(known, of_column);
        }
        self.kind.value(known, (self.factor * self.factor) as u32)
    }

    #[inline(always)]
    fn fetch(&self, level: Level, y: usize, slot: &mut [u8]) {
        if self.full.step != 1 {
            for (x, to) in slot.iter_mut().enumerate() {
                *to = self.at(x, y);
            }
            return;
        }
        let mut done = 0;
        if self.factor == 2 {
            let rows = [self.full.span(2 * y), self.full.span(2 * y + 1)];
            done = self.kind.pairs(level, rows, slot);
        }
        self.fetch_from(done, y, slot);
    }

    #[inline(always)]
    fn fetched<'s>(&'s self, _y: usize, slot: &'s [u8]) -> &'s [u8] {
        slot
    }

    #[inline(always)]
    fn touch<const ROWS: usize>(&self, ys: [usize; ROWS]) {
        (0..self.factor).for_each(|row| self.full.touch(ys.map(|y| y * self.factor + row)));
    }

    fn to_frame(&self, point: [f64; 2]) -> [f64; 2] {
        point.map(|v| v * self.factor as f64)
    }
}

/// Calls `work` with the raster that `decimation` and `sampling` ask for. A frame that is smaller than a block is sampled.
pub(crate) fn with_raster<'a, W: OnRaster>(
    view: &LumaView<'a>,
    decimation: Decimation,
    sampling: Sampling,
    work: W,
) -> W::Output {
    let full = Sampled::new(view, 1);
    let factor = match decimation {
        Decimation::ThreeToTwo => return work.on(ThreeToTwo::new(view)),
        Decimation::Every(factor) => factor as usize,
    };
    let holds_blocks = factor > 1 && full.width >= factor && full.height >= factor;
    match sampling {
        Sampling::Mean if holds_blocks => work.on(Merged { full, factor, kind: Mean }),
        Sampling::Darkest if holds_blocks => work.on(Merged { full, factor, kind: Darkest }),
        _ => work.on(Sampled::new(view, factor)),
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
                let full = Sampled::new(&view, 1);
                rows_agree_with_single_values(Merged { full, factor, kind: Mean });
                rows_agree_with_single_values(Merged { full, factor, kind: Darkest });
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
        let full = Sampled::new(&view, 1);
        assert_eq!(Merged { full, factor: 3, kind: Mean }.to_frame([0.5, 2.0]), [1.5, 6.0]);
    }

    #[test]
    fn a_block_has_the_mean_or_the_least_of_its_pixels() {
        let mut bytes = vec![0; 16 * 16];
        bytes[..4].copy_from_slice(&[10, 20, 200, 100]);
        bytes[16..20].copy_from_slice(&[30, 41, 90, 255]);
        let view = LumaView::grey(&bytes, 16, 16).unwrap();
        let full = Sampled::new(&view, 1);
        let means = Merged { full, factor: 2, kind: Mean };
        assert_eq!([means.at(0, 0), means.at(1, 0)], [25, 161]);
        let darkest = Merged { full, factor: 2, kind: Darkest };
        assert_eq!([darkest.at(0, 0), darkest.at(1, 0)], [10, 90]);
    }
}
