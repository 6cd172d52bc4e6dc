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
    cut_of_pixel: Vec<u8>,
}

/// Which bit planes are asked for: at least one.
#[derive(Clone, Copy)]
pub(crate) struct Colours {
    pub(crate) dark: bool,
    pub(crate) bright: bool,
}

/// How wide and high the tiles are whose extremes give a pixel its threshold, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Scale {
    Four(Contrast),
    /// Sees a white margin of two pixels beside something brighter.
    Two(Contrast),
}

/// How far the extremes around a tile must be apart.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Contrast {
    /// As far as the frame's noise asks for, which tiles of four pixels say; those of two use what was found before.
    Measured,
    /// Grey levels.
    Least(u8),
}

/// Fills `planes` from `raster`.
pub(crate) fn binarize<R: Raster>(
    level: Level,
    raster: R,
    colours: Colours,
    scale: Scale,
    planes: &mut Planes,
) {
    match scale {
        Scale::Four(contrast) => level.run(Binarize::<R, 4> { level, raster, colours, contrast, planes }),
        Scale::Two(contrast) => level.run(Binarize::<R, 2> { level, raster, colours, contrast, planes }),
    }
}

/// `TILE` is the width of a tile in pixels.
struct Binarize<'p, R, const TILE: usize> {
    level: Level,
    raster: R,
    colours: Colours,
    contrast: Contrast,
    planes: &'p mut Planes,
}

impl<R: Raster, const TILE: usize> Kernel for Binarize<'_, R, TILE> {
    type Output = ();

    /// The frame's noise from some rows of tiles, then one pass in which thresholds follow a row of tiles behind the extremes,
    /// while its pixels are still in the nearest cache: a frame that comes from memory is read little more than once.
    #[inline(always)]
    fn run(mut self) {
        let (tiles, tile_rows) = self.resize();
        let measures = TILE == 4 && matches!(self.contrast, Contrast::Measured);
        for row in (0..tile_rows).filter(|row| measures && noise::votes(*row)) {
            self.fetch(row);
            self.find_extremes(row, tiles);
        }
        let Planes { minima, maxima, contrast_limit, .. } = &mut *self.planes;
        if let Contrast::Least(least) = self.contrast {
            *contrast_limit = least;
        } else if measures {
            *contrast_limit = noise::contrast_limit(tiles, minima, maxima, R::ARE_AVERAGES);
        }
        for row in 0..=tile_rows {
            if row < tile_rows {
                self.fetch(row);
                if !(measures && noise::votes(row)) {
                    self.find_extremes(row, tiles);
                }
            }
            if row > 0 {
                self.cut(row - 1);
            }
        }
    }
}

impl<R: Raster, const TILE: usize> Binarize<'_, R, TILE> {
    /// Makes room; returns how many tiles a row and rows of tiles there are.
    fn resize(&mut self) -> (usize, usize) {
        let (width, height) = (self.raster.width(), self.raster.height());
        let (tiles, tile_rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let planes = &mut *self.planes;
        planes.words = width / 64 + 1;
        planes.minima.resize(tiles * tile_rows, 0);
        planes.maxima.resize(tiles * tile_rows, 0);
        planes.cuts.resize(TILE, tiles, tile_rows);
        planes.slots.resize(TILE, width);
        planes.unwanted.resize(planes.words, 0);
        planes.cut_of_pixel.resize(width, 0);
        let Colours { dark, bright } = self.colours;
        for (plane, is_wanted) in [(&mut planes.dark, dark), (&mut planes.bright, bright)] {
            if is_wanted {
                plane.resize(planes.words * height, 0);
            }
        }
        (tiles, tile_rows)
    }

    /// The last row of tiles repeats the raster's last row where it has fewer than a tile.
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
        match rows[..] {
            [a, b, c, d] => simd::tile_extrema(self.level, [a, b, c, d], low, high),
            [a, b] => simd::pair_extrema([a, b], low, high),
            _ => unreachable!("tiles are four or two pixels high"),
        }
    }

    /// The cuts of a row of tiles and the bits of its pixels.
    #[inline(always)]
    fn cut(&mut self, tile_row: usize) {
        let Planes {
            words,
            dark,
            bright,
            cuts,
            contrast_limit,
            minima,
            maxima,
            slots,
            unwanted,
            cut_of_pixel,
        } = &mut *self.planes;
        cuts.fill_row(tile_row, minima, maxima, *contrast_limit);
        cuts.spread::<TILE>(tile_row, cut_of_pixel);
        let first = tile_row * TILE;
        for y in first..(first + TILE).min(self.raster.height()) {
            let row = self.raster.fetched(y, slots.of(tile_row, y - first));
            let bits = y * *words..(y + 1) * *words;
            let (dark, bright) = match self.colours {
                Colours { dark: true, bright: true } => (&mut dark[bits.clone()], &mut bright[bits]),
                Colours { dark: true, bright: false } => (&mut dark[bits], &mut unwanted[..]),
                Colours { dark: false, .. } => (&mut unwanted[..], &mut bright[bits]),
            };
            simd::threshold_row(self.level, row, cut_of_pixel, dark, bright);
        }
    }
}

/// Rows of the raster that are contiguous nowhere else: those of two rows of tiles.
#[derive(Default)]
struct Slots {
    tile: usize,
    width: usize,
    bytes: Vec<u8>,
}

impl Slots {
    fn resize(&mut self, tile: usize, width: usize) {
        (self.tile, self.width) = (tile, width);
        self.bytes.resize(2 * tile * width, 0);
    }

    #[inline(always)]
    fn start(&self, tile_row: usize, i: usize) -> usize {
        (tile_row % 2 * self.tile + i) * self.width
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
