//! Bit planes of dark and of bright pixels, made in one pass over the rows of the raster.

use super::cuts::Cuts;
use super::noise;
use super::raster::Raster;
use crate::simd::{self, Kernel, Level};

/// Dark and bright pixels of the search grid, one bit each. Rows have a bit more than they need, which is never set,
/// so that every run of pixels ends inside its row.
#[derive(Default)]
pub(crate) struct Planes {
    /// Words of 64 pixels a row.
    pub(crate) words: usize,
    /// Pixels that black cells may be made of. Stale unless asked for.
    pub(crate) dark: Vec<u64>,
    /// Pixels that white cells may be made of. Stale unless asked for.
    pub(crate) bright: Vec<u64>,
    /// The threshold of every tile.
    pub(crate) cuts: Cuts,
    /// The contrast that the frame's noise asked for, grey levels.
    pub(crate) contrast_limit: u8,
    minima: Vec<u8>,
    maxima: Vec<u8>,
    slots: Slots,
    unwanted: Vec<u64>,
}

/// Which bit planes are asked for: at least one.
#[derive(Clone, Copy)]
pub(crate) struct Colours {
    pub(crate) dark: bool,
    pub(crate) bright: bool,
}

/// Fills `planes` from `raster`.
pub(crate) fn binarize<R: Raster>(level: Level, raster: R, colours: Colours, planes: &mut Planes) {
    level.run(Binarize { level, raster, colours, planes });
}

struct Binarize<'p, R> {
    level: Level,
    raster: R,
    colours: Colours,
    planes: &'p mut Planes,
}

/// Rows a tile.
const TILE: usize = 4;

impl<R: Raster> Kernel for Binarize<'_, R> {
    type Output = ();

    /// The frame's noise from some rows of tiles, then one pass in which thresholds follow a row of tiles behind the extremes,
    /// while its pixels are still in the nearest cache: a frame that comes from memory is read little more than once.
    #[inline(always)]
    fn run(mut self) {
        let (tiles, tile_rows) = self.resize();
        for row in (0..tile_rows).filter(|row| noise::votes(*row)) {
            self.fetch(row);
            self.find_extremes(row, tiles);
        }
        let Planes { minima, maxima, contrast_limit, .. } = &mut *self.planes;
        *contrast_limit = noise::contrast_limit(tiles, minima, maxima, R::ARE_AVERAGES);
        for row in 0..=tile_rows {
            if row < tile_rows {
                self.fetch(row);
                if !noise::votes(row) {
                    self.find_extremes(row, tiles);
                }
            }
            if row > 0 {
                self.cut(row - 1);
            }
        }
    }
}

impl<R: Raster> Binarize<'_, R> {
    /// Makes room; returns how many tiles a row and rows of tiles there are.
    fn resize(&mut self) -> (usize, usize) {
        let (width, height) = (self.raster.width(), self.raster.height());
        let (tiles, tile_rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let planes = &mut *self.planes;
        planes.words = width / 64 + 1;
        planes.minima.resize(tiles * tile_rows, 0);
        planes.maxima.resize(tiles * tile_rows, 0);
        planes.cuts.resize(tiles, tile_rows);
        planes.slots.resize(width);
        planes.unwanted.resize(planes.words, 0);
        let Colours { dark, bright } = self.colours;
        for (plane, is_wanted) in [(&mut planes.dark, dark), (&mut planes.bright, bright)] {
            if is_wanted {
                plane.resize(planes.words * height, 0);
            }
        }
        (tiles, tile_rows)
    }

    /// The last row of tiles repeats the raster's last row where it has fewer than four.
    #[inline(always)]
    fn row_of(&self, tile_row: usize, i: usize) -> usize {
        (tile_row * TILE + i).min(self.raster.height() - 1)
    }

    #[inline(always)]
    fn fetch(&mut self, tile_row: usize) {
        for i in 0..TILE {
            let y = self.row_of(tile_row, i);
            self.raster.fetch(self.level, y, self.planes.slots.of_mut(tile_row, i));
        }
    }

    #[inline(always)]
    fn find_extremes(&mut self, tile_row: usize, tiles: usize) {
        let mut rows: [&[u8]; TILE] = [&[]; TILE];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = self.raster.fetched(self.row_of(tile_row, i), self.planes.slots.of(tile_row, i));
        }
        let low = &mut self.planes.minima[tile_row * tiles..][..tiles];
        let high = &mut self.planes.maxima[tile_row * tiles..][..tiles];
        simd::tile_extrema(self.level, rows, low, high);
    }

    /// The cuts of a row of tiles and the bits of its pixels.
    #[inline(always)]
    fn cut(&mut self, tile_row: usize) {
        let Planes { words, dark, bright, cuts, contrast_limit, minima, maxima, slots, unwanted } =
            &mut *self.planes;
        cuts.fill_row(tile_row, minima, maxima, *contrast_limit);
        let first = tile_row * TILE;
        for y in first..(first + TILE).min(self.raster.height()) {
            let row = self.raster.fetched(y, slots.of(tile_row, y - first));
            let bits = y * *words..(y + 1) * *words;
            let (dark, bright) = match self.colours {
                Colours { dark: true, bright: true } => (&mut dark[bits.clone()], &mut bright[bits]),
                Colours { dark: true, bright: false } => (&mut dark[bits], &mut unwanted[..]),
                Colours { dark: false, .. } => (&mut unwanted[..], &mut bright[bits]),
            };
            simd::threshold_row(self.level, row, cuts.row(tile_row), dark, bright);
        }
    }
}

/// Rows of the raster that are contiguous nowhere else: those of two rows of tiles.
#[derive(Default)]
struct Slots {
    width: usize,
    bytes: Vec<u8>,
}

impl Slots {
    fn resize(&mut self, width: usize) {
        self.width = width;
        self.bytes.resize(2 * TILE * width, 0);
    }

    #[inline(always)]
    fn start(&self, tile_row: usize, i: usize) -> usize {
        (tile_row % 2 * TILE + i) * self.width
    }

    #[inline(always)]
    fn of(&self, tile_row: usize, i: usize) -> &[u8] {
        &self.bytes[self.start(tile_row, i)..][..self.width]
    }

    #[inline(always)]
    fn of_mut(&mut self, tile_row: usize, i: usize) -> &mut [u8] {
        let start = self.start(tile_row, i);
        &mut self.bytes[start..][..self.width]
    }
}
