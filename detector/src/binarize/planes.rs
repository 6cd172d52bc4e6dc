//! Bit planes of dark and of bright pixels, made in two passes over the rows of the raster.

use super::cuts::Cuts;
use super::noise::contrast_limit;
use super::raster::Raster;
use crate::simd::{self, Kernel, Level};

/// Dark and bright pixels of the search grid, one bit each. Rows have a bit more than they need, which is never set,
/// so that every run of pixels ends inside its row.
#[derive(Default)]
pub(crate) struct Planes {
    /// Words of 64 pixels a row.
    pub(crate) words: usize,
    /// Pixels that black cells may be made of.
    pub(crate) dark: Vec<u64>,
    /// Pixels that white cells may be made of.
    pub(crate) bright: Vec<u64>,
    /// The threshold of every tile.
    pub(crate) cuts: Cuts,
    /// The contrast that the frame's noise asked for, grey levels.
    pub(crate) contrast_limit: u8,
    minima: Vec<u8>,
    maxima: Vec<u8>,
    scratch: Vec<u8>,
}

/// Fills `planes` from `raster`.
pub(crate) fn binarize<R: Raster>(level: Level, raster: R, planes: &mut Planes) {
    planes.scratch.resize(4 * raster.width(), 0);
    level.run(Extrema { level, raster, planes: &mut *planes });
    let tiles = raster.width().div_ceil(4);
    planes.contrast_limit = contrast_limit(tiles, &planes.minima, &planes.maxima);
    level.run(CutTiles { tiles, planes: &mut *planes });
    level.run(Threshold { level, raster, planes });
}

/// The extremes of every tile.
struct Extrema<'p, R> {
    level: Level,
    raster: R,
    planes: &'p mut Planes,
}

impl<R: Raster> Kernel for Extrema<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { level, raster, planes } = self;
        let (width, height) = (raster.width(), raster.height());
        let (tiles, tile_rows) = (width.div_ceil(4), height.div_ceil(4));
        planes.minima.resize(tiles * tile_rows, 0);
        planes.maxima.resize(tiles * tile_rows, 0);
        let extremes = planes.minima.chunks_exact_mut(tiles).zip(planes.maxima.chunks_exact_mut(tiles));
        for (tile_row, (low, high)) in extremes.enumerate() {
            let mut scratch = planes.scratch.chunks_exact_mut(width);
            // The last tile row repeats the frame's last row where it has fewer than four.
            let rows: [&[u8]; 4] = std::array::from_fn(|i| {
                let scratch = scratch.next().unwrap_or_default();
                raster.row((tile_row * 4 + i).min(height - 1), scratch)
            });
            simd::tile_extrema(level, rows, low, high);
        }
    }
}

/// The cuts of all tiles.
struct CutTiles<'p> {
    tiles: usize,
    planes: &'p mut Planes,
}

impl Kernel for CutTiles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let planes = self.planes;
        planes.cuts.fill(self.tiles, &planes.minima, &planes.maxima, planes.contrast_limit);
    }
}

/// Both bit planes.
struct Threshold<'p, R> {
    level: Level,
    raster: R,
    planes: &'p mut Planes,
}

impl<R: Raster> Kernel for Threshold<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { level, raster, planes } = self;
        let words = raster.width() / 64 + 1;
        planes.words = words;
        planes.dark.resize(words * raster.height(), 0);
        planes.bright.resize(words * raster.height(), 0);
        let rows = planes.dark.chunks_exact_mut(words).zip(planes.bright.chunks_exact_mut(words));
        for (y, (dark, bright)) in rows.enumerate() {
            let row = raster.row(y, &mut planes.scratch);
            simd::threshold_row(level, row, planes.cuts.row(y / 4), dark, bright);
        }
    }
}
