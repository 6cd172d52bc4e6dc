//! The pixels that the model is compared with, side by side so that several are computed at once.

use super::super::homography::Homography;
use super::super::sample::Frame;
use super::edges::{self, Place, Sieve, Stretch};
use super::model::Model;
use super::patch::Patch;
use super::pattern::{MOST_CELLS, Pattern};

/// Pixels of a block. All loops over a block have this length, which no vector length fails to divide.
pub(super) const BLOCK: usize = 32;
/// One number for each pixel of a block.
pub(super) type Lanes = [f32; BLOCK];
pub(super) const ZERO: Lanes = [0.0; BLOCK];

/// A pixel this near to a cell of unknown colour is not modelled.
const UNKNOWN_REACH: f64 = 1.5;
/// Some pixels: places in units of the patch, grey values, and the cells around each.
pub(super) struct Block {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) grey: Lanes,
    /// 1, or 0 behind the last pixel of the last block.
    pub(super) weight: Lanes,
    /// The first cell of each pixel's window, counted as the pattern does.
    pub(super) first_u: Lanes,
    pub(super) first_v: Lanes,
    /// The window's rows, as [`Pattern::word`] gives them.
    pub(super) rows: [[u32; BLOCK]; MOST_CELLS],
}

impl Block {
    pub(super) const EMPTY: Self = Self {
        x: ZERO,
        y: ZERO,
        grey: ZERO,
        weight: ZERO,
        first_u: ZERO,
        first_v: ZERO,
        rows: [[0; BLOCK]; MOST_CELLS],
    };
}

/// A tag, where it is thought to lie.
pub(super) struct Laid<'a> {
    pub(super) pattern: &'a Pattern,
    pub(super) patch: &'a Patch,
    pub(super) to_frame: &'a Homography,
    /// As it starts.
    pub(super) model: &'a Model,
    /// Cells of a window along an axis.
    pub(super) window: usize,
}

/// Buffers of the choice.
#[derive(Default)]
pub(super) struct Pixels {
    stretches: Vec<Stretch>,
    sieve: Sieve,
    places: Vec<Place>,
    blocks: Vec<Block>,
    count: usize,
}

impl Pixels {
    /// Makes room for any tag whose pattern has so many cells a row.
    pub(super) fn reserve(&mut self, width: usize) {
        let Self { stretches, sieve, places, blocks, .. } = self;
        // Two lines for each column and row at most; every second place on a line begins a stretch.
        stretches.reserve((width * (width + 1)).saturating_sub(stretches.len()));
        sieve.clear();
        places.reserve(edges::MOST_PLACES.saturating_sub(places.len()));
        while blocks.len() * BLOCK < edges::MOST_PLACES {
            blocks.push(Block::EMPTY);
        }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whole blocks; the last one is filled up with pixels of no weight.
    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count.div_ceil(BLOCK)]
    }

    /// Collects the pixels of a tag.
    #[inline(always)]
    pub(super) fn choose(&mut self, frame: &Frame, laid: &Laid) {
        let Self { stretches, sieve, places, blocks, count } = self;
        *count = 0;
        edges::find(laid.pattern, laid.to_frame, stretches);
        edges::collect(frame, stretches, sieve, places);
        for chunk in places.chunks(BLOCK) {
            let near = laid.surroundings(chunk);
            for (i, [column, row]) in chunk.iter().enumerate() {
                let Some(first) = laid.window_at(&near, i) else { continue };
                if *count % BLOCK == 0 {
                    if blocks.len() == *count / BLOCK {
                        blocks.push(Block::EMPTY);
                    }
                    blocks[*count / BLOCK].clear();
                }
                let grey = frame.pixel(*column as usize, *row as usize);
                blocks[*count / BLOCK].set(*count % BLOCK, [near.x[i], near.y[i]], grey, laid, first);
                *count += 1;
            }
        }
    }
}

impl Block {
    /// Pixels in the middle of the patch, where every model is finite, and of no weight.
    #[inline(always)]
    fn clear(&mut self) {
        self.x = ZERO;
        self.y = ZERO;
        self.weight = ZERO;
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, [x, y]: [f32; 2], grey: u8, laid: &Laid, [u, v]: [usize; 2]) {
        self.x[lane] = x;
        self.y[lane] = y;
        self.grey[lane] = f32::from(grey);
        self.weight[lane] = 1.0;
        self.first_u[lane] = u as f32;
        self.first_v[lane] = v as f32;
        for (j, row) in self.rows.iter_mut().enumerate().take(laid.window) {
            row[lane] = laid.pattern.word(u, v + j);
        }
    }
}

/// Some pixels, where they lie among the cells, and how far around a cell of unknown colour would matter.
struct Surroundings {
    x: Lanes,
    y: Lanes,
    u: Lanes,
    v: Lanes,
    reach_u: Lanes,
    reach_v: Lanes,
}

impl Laid<'_> {
    #[inline(always)]
    fn surroundings(&self, places: &[Place]) -> Surroundings {
        let (mut x, mut y) = (ZERO, ZERO);
        for (i, place) in places.iter().enumerate() {
            [x[i], y[i]] = self.patch.place_of([f64::from(place[0]) + 0.5, f64::from(place[1]) + 0.5]);
        }
        let at = self.model.places(&x, &y);
        let reach = (UNKNOWN_REACH / self.patch.scale) as f32;
        let (mut reach_u, mut reach_v) = (ZERO, ZERO);
        for l in 0..BLOCK {
            reach_u[l] = reach * at.u.speed[l];
            reach_v[l] = reach * at.v.speed[l];
        }
        Surroundings { x, y, u: at.u.place, v: at.v.place, reach_u, reach_v }
    }

    /// The first cell of the window around a pixel; `None` when a cell of unknown colour is too near.
    #[inline(always)]
    fn window_at(&self, near: &Surroundings, i: usize) -> Option<[usize; 2]> {
        let (u, v, reach_u, reach_v) = (near.u[i], near.v[i], near.reach_u[i], near.reach_v[i]);
        let before = self.window as f32 * 0.5 - 0.5;
        // Nothing known lies this near to the rim.
        let (low, high) = (before, self.pattern.width() as f32 - before - 1.0);
        let inside = u >= low && v >= low && u < high && v < high;
        if !inside || reach_u.max(reach_v) >= before.max(1.0) {
            return None;
        }
        let from = [(u - reach_u) as usize, (v - reach_v) as usize];
        let to = [(u + reach_u) as usize, (v + reach_v) as usize];
        self.pattern.is_known(from, to).then_some([(u - before) as usize, (v - before) as usize])
    }
}
