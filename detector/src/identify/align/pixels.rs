//! The pixels that the model is compared with, side by side so that several are computed at once.

use super::super::sample::Frame;
use super::edges::{self, Place, Sieve, Stretch};
use super::model::Model;
use super::patch::Patch;
use super::pattern::{MOST_CELLS, Pattern};

/// Pixels of a block. All loops over a block have this length, which no vector length fails to divide.
pub(super) const BLOCK: usize = 32;
/// One number for each pixel of a block. What holds many begins at a line of the caches: the longest vectors are as long as a line,
/// and would else lie across two.
pub(super) type Lanes = [f32; BLOCK];
pub(super) const ZERO: Lanes = [0.0; BLOCK];

/// A pixel this near to a cell of unknown colour is not modelled.
const UNKNOWN_REACH: f64 = 1.5;
/// Some pixels: places in units of the patch, grey values, and the cells around each.
#[repr(align(64))]
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
    /// As it starts.
    pub(super) model: &'a Model,
}

/// Buffers of the choice.
#[derive(Default)]
pub(super) struct Pixels {
    sieve: Sieve,
    places: Vec<Place>,
    blocks: Vec<Block>,
    count: usize,
}

impl Pixels {
    /// Makes room for all pixels of any tag.
    pub(super) fn reserve(&mut self) {
        let Self { sieve, places, blocks, .. } = self;
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

    /// Collects the pixels of a tag, with windows of `WINDOW` cells along an axis.
    #[inline(always)]
    pub(super) fn choose<const WINDOW: usize>(&mut self, frame: &Frame, laid: &Laid, stretches: &[Stretch]) {
        edges::collect(frame, stretches, &mut self.sieve, &mut self.places);
        self.count = 0;
        let places = std::mem::take(&mut self.places);
        for chunk in places.chunks(BLOCK) {
            self.add::<WINDOW>(frame, laid, chunk);
        }
        self.places = places;
    }

    /// Adds those of up to a block of pixels that are not too near to a cell of unknown colour.
    #[inline(always)]
    fn add<const WINDOW: usize>(&mut self, frame: &Frame, laid: &Laid, places: &[Place]) {
        let windows = laid.windows::<WINDOW>(places);
        for (i, [column, row]) in places.iter().enumerate() {
            let (words, may_be_unknown) =
                laid.pattern.window::<WINDOW>([windows.first[0][i], windows.first[1][i]]);
            if !windows.fits[i] || may_be_unknown && !windows.is_known(laid.pattern, i) {
                continue;
            }
            let lane = self.count % BLOCK;
            if lane == 0 {
                if self.blocks.len() == self.count / BLOCK {
                    self.blocks.push(Block::EMPTY);
                }
                self.blocks[self.count / BLOCK].clear();
            }
            let block = &mut self.blocks[self.count / BLOCK];
            (block.x[lane], block.y[lane]) = (windows.x[i], windows.y[i]);
            (block.first_u[lane], block.first_v[lane]) =
                (windows.first[0][i] as i32 as f32, windows.first[1][i] as i32 as f32);
            for (row, word) in block.rows.iter_mut().zip(words) {
                row[lane] = word;
            }
            block.grey[lane] = f32::from(frame.pixel(*column as usize, *row as usize));
            block.weight[lane] = 1.0;
            self.count += 1;
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
}

impl Laid<'_> {
    /// The windows around some pixels.
    #[inline(always)]
    fn windows<const WINDOW: usize>(&self, places: &[Place]) -> Windows {
        let mut w = Windows {
            x: ZERO,
            y: ZERO,
            first: [[0; BLOCK]; 2],
            fits: [false; BLOCK],
            place: [ZERO; 2],
            reach: [ZERO; 2],
        };
        for (i, place) in places.iter().enumerate() {
            [w.x[i], w.y[i]] = self.patch.place_of([f64::from(place[0]) + 0.5, f64::from(place[1]) + 0.5]);
        }
        let at = self.model.places(&w.x, &w.y);
        let reach = (UNKNOWN_REACH / self.patch.scale) as f32;
        let before = WINDOW as f32 * 0.5 - 0.5;
        // Nothing known lies nearer to the rim.
        let last = self.pattern.width() as f32 - 2.0 * before - 2.0;
        for l in 0..BLOCK {
            let (u, v) = (at.u.place[l] - before, at.v.place[l] - before);
            w.reach[0][l] = reach * at.u.speed[l];
            w.reach[1][l] = reach * at.v.speed[l];
            let is_inside = (u >= 0.0) & (v >= 0.0) & (u < last) & (v < last);
            let is_near = (w.reach[0][l] < before.max(1.0)) & (w.reach[1][l] < before.max(1.0));
            w.fits[l] = is_inside & is_near;
            w.first[0][l] = u.max(0.0).min(last) as i32 as u32;
            w.first[1][l] = v.max(0.0).min(last) as i32 as u32;
        }
        w.place = [at.u.place, at.v.place];
        w
    }
}

/// The windows around some pixels.
struct Windows {
    /// The pixels, in units of the patch.
    x: Lanes,
    y: Lanes,
    /// The first cell along either axis, as the pattern counts.
    first: [[u32; BLOCK]; 2],
    /// Whether it lies in the pattern.
    fits: [bool; BLOCK],
    /// Where the pixel lies, and how far from it a cell of unknown colour would matter.
    place: [Lanes; 2],
    reach: [Lanes; 2],
}

impl Windows {
    /// Whether all cells are known that lie so near to a pixel that they would matter.
    fn is_known(&self, pattern: &Pattern, i: usize) -> bool {
        let end = |sign: f32| [0, 1].map(|a| (self.place[a][i] + sign * self.reach[a][i]) as usize);
        pattern.is_known(end(-1.0), end(1.0))
    }
}
