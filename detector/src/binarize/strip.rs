//! Some rows of tiles, which one thread works on.

use std::ops::Range;

use super::cuts::{Columns, Extremes, LANES, NO_MAXIMUM, NO_MINIMUM, fill_row, filled, spread};
use super::light::{self, clear_uneven_light};
use super::noise::{self, Ranges};
use super::raster::Raster;
use crate::simd::{self, Kernel, Level};

/// Rows of tiles of `TILE` pixels of a raster.
#[derive(Clone, Copy)]
pub(super) struct Strip<R, const TILE: usize> {
    level: Level,
    raster: R,
    /// The first row of tiles, and the one behind the last.
    first: usize,
    end: usize,
    /// Rows of tiles that the raster has.
    all: usize,
    /// Whether the rows of tiles that have a vote are measured, and their extremes kept, before thresholds are looked for.
    is_measured: bool,
    /// Whether all rows are fetched for that, and kept.
    keeps_rows: bool,
}

/// Pixels of a raster whose rows are all kept once they are fetched: as many as the nearest cache holds.
const KEPT: usize = 32 * 1024;

/// Parts of a strip that are read by turns: processors that foresee one line or two in each place fetch a sixth more of a frame
/// in the same time.
const PARTS: usize = 4;

/// Rows of tiles a part of those that are brought near at once: together as much of a frame as a second cache holds. Whole
/// [`noise::ROW_STEP`], so that rows that are read by turns have a vote all or none.
const PART: usize = 8;

/// Rows of tiles whose extremes are kept in turn: more than a threshold looks at.
const TURNS: usize = 4;

/// What a thread needs for a strip.
#[derive(Default)]
// In cache lines of its own: its neighbours in a list belong to other threads.
#[repr(align(128))]
pub(super) struct Scratch {
    /// Extremes of some rows of tiles in turn, and behind them those that were measured: few enough to stay in the nearest caches.
    minima: Vec<u8>,
    maxima: Vec<u8>,
    /// Tiles a row, and places for them: whole [`LANES`].
    tiles: usize,
    room: usize,
    slots: Slots,
    columns: Columns,
    cut_of_tile: Vec<u8>,
    cut_of_pixel: Vec<u8>,
    unwanted: Vec<u64>,
    pub(super) ranges: Ranges,
}

impl Scratch {
    /// Makes room for strips of so many rows of tiles, and for the pixels of `fetched` of these.
    pub(super) fn resize(&mut self, tile: usize, width: usize, length: usize, fetched: usize) {
        let tiles = width.div_ceil(tile);
        if self.tiles != tiles {
            // What is a tile's place now may have been behind the last one.
            (self.tiles, self.room) = (tiles, tiles.next_multiple_of(LANES));
            self.minima.clear();
            self.maxima.clear();
        }
        let kept = TURNS + length / noise::ROW_STEP + 2;
        self.minima.resize(self.room * kept, NO_MINIMUM);
        self.maxima.resize(self.room * kept, NO_MAXIMUM);
        self.slots.resize(tile, width, fetched);
        self.columns.resize(tiles);
        self.cut_of_tile.resize(self.room, 0);
        self.cut_of_pixel.resize(width, 0);
        self.unwanted.resize(width / 64 + 1, 0);
    }
}

impl<R: Raster, const TILE: usize> Strip<R, TILE> {
    /// `length` rows of tiles from the row `first` on, or as many as there are.
    pub(super) fn new(level: Level, raster: R, first: usize, length: usize, is_measured: bool) -> Self {
        let all = raster.height().div_ceil(TILE);
        let is_small = length >= all && raster.width() * raster.height() <= KEPT;
        let keeps_rows = is_measured && is_small && raster.must_be_fetched();
        Self { level, raster, first, end: (first + length).min(all), all, is_measured, keeps_rows }
    }

    /// Rows of tiles whose pixels are kept at the same time.
    pub(super) fn fetched(&self) -> usize {
        if self.keeps_rows { self.all } else { 2 }
    }

    /// The first row of tiles whose extremes are needed.
    fn before(&self) -> usize {
        self.first.saturating_sub(1)
    }

    /// The last row of tiles repeats the raster's last row where it has fewer than a tile.
    #[inline(always)]
    fn row_of(&self, tile_row: usize, i: usize) -> usize {
        (tile_row * TILE + i).min(self.raster.height() - 1)
    }

    #[inline(always)]
    fn fetch(&self, tile_row: usize, slots: &mut Slots) {
        for i in 0..TILE {
            self.raster.fetch(self.level, self.row_of(tile_row, i), slots.of_mut(tile_row, i));
        }
    }

    /// Brings the pixels of some rows of tiles near. Beyond the strip's end its last row stands in.
    #[inline(always)]
    fn touch<const ROWS: usize>(&self, tile_rows: [usize; ROWS]) {
        for i in 0..TILE {
            self.raster.touch(tile_rows.map(|row| self.row_of(row.min(self.end - 1), i)));
        }
    }

    /// Whether light that falls off is told from content.
    #[inline(always)]
    fn knows_light(&self) -> bool {
        self.is_measured && self.raster.pitch() >= light::LEAST_PITCH
    }

    /// Whether a row of tiles is measured, and its extremes kept.
    #[inline(always)]
    fn measures(&self, tile_row: usize) -> bool {
        self.is_measured && noise::votes(tile_row) && (self.first..self.end).contains(&tile_row)
    }

    /// The places of a row of tiles among the extremes.
    #[inline(always)]
    fn places(&self, tile_row: usize, scratch: &Scratch) -> Range<usize> {
        let row = if self.measures(tile_row) {
            TURNS + tile_row / noise::ROW_STEP - self.first / noise::ROW_STEP
        } else {
            tile_row % TURNS
        };
        row * scratch.room..(row + 1) * scratch.room
    }

    /// Counts a row of tiles whose pixels are fetched, if it has a vote.
    #[inline(always)]
    fn measure(&self, tile_row: usize, scratch: &mut Scratch) {
        if self.measures(tile_row) {
            self.find_extremes(tile_row, scratch);
            let places = self.places(tile_row, scratch);
            scratch.ranges.add(Extremes::new(&scratch.minima[places.clone()], &scratch.maxima[places]));
        }
    }

    /// Measures rows that are fetched and kept once all are near.
    #[inline(always)]
    fn measure_kept(&self, scratch: &mut Scratch) {
        for row in self.first..self.end {
            self.touch([row]);
        }
        for row in self.first..self.end {
            self.fetch(row, &mut scratch.slots);
        }
        for row in self.first..self.end {
            self.measure(row, scratch);
        }
    }

    /// Measures rows that may come from memory, in the order in which they come.
    #[inline(always)]
    fn measure_from_afar(&self, scratch: &mut Scratch) {
        let part = (self.end - self.first).div_ceil(PARTS).next_multiple_of(noise::ROW_STEP);
        for row in (self.first..self.first + part).filter(|row| noise::votes(*row)) {
            let rows: [usize; PARTS] = std::array::from_fn(|i| row + i * part);
            self.touch(rows);
            for row in rows.into_iter().filter(|row| self.measures(*row)) {
                self.fetch(row, &mut scratch.slots);
                self.measure(row, scratch);
            }
        }
    }

    /// Brings the next rows near where a block of them begins: those without a vote, as the others have been so before.
    #[inline(always)]
    fn touch_block(&self, row: usize) {
        let begins = (row - self.before()).is_multiple_of(PARTS * PART);
        if !self.is_measured || self.keeps_rows || !begins {
            return;
        }
        for row in (row..row + PART).filter(|row| !noise::votes(*row)) {
            let rows: [usize; PARTS] = std::array::from_fn(|i| row + i * PART);
            self.touch(rows);
        }
    }

    #[inline(always)]
    fn find_extremes(&self, tile_row: usize, scratch: &mut Scratch) {
        let first = self.places(tile_row, scratch).start;
        let places = first..first + scratch.tiles;
        let Scratch { minima, maxima, slots, .. } = scratch;
        let mut rows: [&[u8]; TILE] = [&[]; TILE];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = self.raster.fetched(self.row_of(tile_row, i), slots.of(tile_row, i));
        }
        let (low, high) = (&mut minima[places.clone()], &mut maxima[places]);
        match rows[..] {
            [a, b, c, d] => simd::tile_extrema(self.level, [a, b, c, d], low, high),
            [a, b] => simd::pair_extrema([a, b], low, high),
            _ => unreachable!("tiles are four or two pixels high"),
        }
    }
}

/// Measures the noise in the rows of tiles of a strip that have a vote, and keeps their extremes.
pub(super) struct Measure<'p, R, const TILE: usize> {
    pub(super) strip: Strip<R, TILE>,
    pub(super) scratch: &'p mut Scratch,
}

impl<R: Raster, const TILE: usize> Kernel for Measure<'_, R, TILE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { strip, scratch } = self;
        scratch.ranges.clear();
        if strip.keeps_rows {
            strip.measure_kept(scratch);
        } else {
            strip.measure_from_afar(scratch);
        }
    }
}

/// What a strip fills: its part of the wanted planes, of the rows known to be blank and of the cuts.
pub(super) struct Part<'p> {
    pub(super) dark: Option<&'p mut [u64]>,
    pub(super) bright: Option<&'p mut [u64]>,
    pub(super) blank: &'p mut [bool],
    pub(super) cuts: &'p mut [u8],
    pub(super) scratch: &'p mut Scratch,
}

/// Finds the cuts and the bits of a strip.
pub(super) struct Threshold<'p, R, const TILE: usize> {
    pub(super) strip: Strip<R, TILE>,
    /// The contrast that is asked for, grey levels.
    pub(super) limit: u8,
    pub(super) part: Part<'p>,
}

impl<R: Raster, const TILE: usize> Kernel for Threshold<'_, R, TILE> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let strip = self.strip;
        for row in strip.before()..=strip.end {
            strip.touch_block(row);
            if row < strip.all {
                if !strip.keeps_rows {
                    strip.fetch(row, &mut self.part.scratch.slots);
                }
                if !strip.measures(row) {
                    strip.find_extremes(row, self.part.scratch);
                }
            }
            if row > strip.first {
                self.cut(row - 1);
            }
        }
    }
}

impl<R: Raster, const TILE: usize> Threshold<'_, R, TILE> {
    /// The cuts of a row of tiles, and with them the bits of its pixels.
    #[inline(always)]
    fn cut(&mut self, tile_row: usize) {
        let Self { strip, limit, part: Part { blank, cuts, scratch, .. } } = self;
        let around = [tile_row.saturating_sub(1), tile_row, (tile_row + 1).min(strip.all - 1)];
        let around = around.map(|row| strip.places(row, scratch));
        let Scratch { minima, maxima, tiles, columns, cut_of_tile, .. } = &mut **scratch;
        let around = around.map(|places| Extremes::new(&minima[places.clone()], &maxima[places]));
        let mut is_blank = !fill_row(around, *limit, columns, cut_of_tile);
        if !is_blank && strip.knows_light() {
            is_blank = !clear_uneven_light(around, *limit, columns, cut_of_tile);
        }
        let top = strip.first * TILE;
        let rows = strip.row_of(tile_row, 0) - top..strip.row_of(tile_row, TILE - 1) + 1 - top;
        let blank = &mut blank[rows];
        if is_blank && blank[0] {
            // So it was in the frame before, and nothing is set that would have to be cleared.
            return;
        }
        blank.fill(is_blank);
        let of_row = (tile_row - strip.first) * *tiles..(tile_row - strip.first + 1) * *tiles;
        cuts[of_row].copy_from_slice(&cut_of_tile[..*tiles]);
        let filled = filled(cut_of_tile);
        if filled.len() < cut_of_tile.len() {
            self.clear(tile_row);
        }
        // Most rows of tiles of a plain wall have no cuts: their pixels need not be read again.
        if !is_blank {
            self.threshold(tile_row, filled);
        }
    }

    /// The bits of a row of tiles, of which those in `filled` have cuts: whole [`LANES`].
    #[inline(always)]
    fn threshold(&mut self, tile_row: usize, filled: Range<usize>) {
        let Self { strip, part: Part { dark, bright, scratch, .. }, .. } = self;
        let Scratch { tiles, slots, cut_of_tile, cut_of_pixel, unwanted, .. } = &mut **scratch;
        spread::<TILE>(&cut_of_tile[..*tiles], cut_of_pixel);
        let pixels = filled.start * TILE..(filled.end * TILE).min(cut_of_pixel.len());
        // Whole words, since LANES of the smallest tiles have 64 pixels, and behind the last tile all that there are.
        let is_whole = filled.end == cut_of_tile.len();
        let (first, end) = (pixels.start / 64, if is_whole { unwanted.len() } else { pixels.end / 64 });
        for y in strip.row_of(tile_row, 0)..strip.row_of(tile_row, TILE - 1) + 1 {
            let row = &strip.raster.fetched(y, slots.of(tile_row, y % TILE))[pixels.clone()];
            let start = (y - strip.first * TILE) * unwanted.len();
            let bits = start + first..start + end;
            let (dark, bright) = match (dark.as_deref_mut(), bright.as_deref_mut()) {
                (Some(dark), Some(bright)) => (&mut dark[bits.clone()], &mut bright[bits]),
                (Some(dark), None) => (&mut dark[bits], &mut unwanted[first..end]),
                (None, Some(bright)) => (&mut unwanted[first..end], &mut bright[bits]),
                (None, None) => return,
            };
            simd::threshold_row(strip.level, row, &cut_of_pixel[pixels.clone()], dark, bright);
        }
    }

    /// No pixel of a row of tiles is dark or bright.
    #[inline(always)]
    fn clear(&mut self, tile_row: usize) {
        let Self { strip, part: Part { dark, bright, scratch, .. }, .. } = self;
        let (words, top) = (scratch.unwanted.len(), strip.first * TILE);
        let (first, last) = (strip.row_of(tile_row, 0) - top, strip.row_of(tile_row, TILE - 1) - top);
        for plane in [dark, bright].into_iter().flatten() {
            plane[first * words..(last + 1) * words].fill(0);
        }
    }
}

/// Rows of the raster that are contiguous nowhere else: those of some rows of tiles in turn.
#[derive(Default)]
struct Slots {
    tile: usize,
    width: usize,
    turns: usize,
    bytes: Vec<u8>,
}

impl Slots {
    /// Makes room for `turns` rows of tiles.
    fn resize(&mut self, tile: usize, width: usize, turns: usize) {
        (self.tile, self.width, self.turns) = (tile, width, turns);
        self.bytes.resize(turns * tile * width, 0);
    }

    #[inline(always)]
    fn start(&self, tile_row: usize, i: usize) -> usize {
        (tile_row % self.turns * self.tile + i) * self.width
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
