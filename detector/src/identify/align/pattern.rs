//! The colours of a decoded tag's cells, ready to be looked up a window at a time.

use super::super::reader::Reader;

/// Most cells of a window along an axis.
pub(super) const MOST_CELLS: usize = 5;
/// Unknown cells around the grid, so that windows may reach beyond it.
const RIM: usize = MOST_CELLS;

/// Codes of a cell's colour, four times its brightness. The bit of unknown cells is theirs alone.
const BLACK: u8 = 0;
const UNKNOWN: u8 = 2;
const WHITE: u8 = 4;
/// Bits of a cell in a word, and the lowest bit of each cell.
pub(super) const CELL_BITS: usize = 4;
const LOWEST: u32 = 0x1_1111;

/// The code of the cell that lies `k` further right than the first one of a word: 0 is black and 4 is white. Between lie
/// unknown cells (2) and, in joined rows, the mean of such a cell and another one.
#[inline(always)]
pub(super) fn colour(word: u32, k: usize) -> i32 {
    (word >> (CELL_BITS * k) & 7) as i32
}

/// For each cell of two words 1 where one is black and the other white, else 0.
#[inline(always)]
pub(super) fn opposite(a: u32, b: u32) -> u32 {
    let differ = a ^ b;
    differ >> 2 & !(differ >> 1) & LOWEST
}

/// For each cell of two words white where either is (`lighter`), or only where both are; the mean of the two where one of
/// them is unknown.
#[inline(always)]
pub(super) fn joined(a: u32, b: u32, lighter: bool) -> u32 {
    let opposite = opposite(a, b);
    let mean = (a + b) >> 1;
    if lighter { mean + 2 * opposite } else { mean - 2 * opposite }
}

/// The cells of the scratch grid with a rim around them.
#[derive(Default)]
pub(super) struct Pattern {
    cells: Vec<u8>,
    /// For each cell, it and those to its right: four bits each, the cell itself lowest.
    words: Vec<u32>,
    /// Cells a row.
    width: usize,
    /// Cells before the border edge.
    margin: f64,
}

impl Pattern {
    /// Makes room for a grid of so many cells a row; returns how many cells a row then has.
    pub(super) fn reserve(&mut self, grid_width: usize) -> usize {
        let width = grid_width + 2 * RIM;
        self.cells.reserve((width * width).saturating_sub(self.cells.len()));
        self.words.reserve((width * width).saturating_sub(self.words.len()));
        width
    }

    /// Takes the colours of a tag with this code, as read.
    #[inline(always)]
    pub(super) fn paint(&mut self, reader: &Reader, code: u64) {
        self.width = reader.grid_width + 2 * RIM;
        self.margin = reader.grid_margin() + RIM as f64;
        self.cells.clear();
        self.cells.resize(self.width * self.width, UNKNOWN);
        let place =
            |place: usize| (place / reader.grid_width + RIM) * self.width + place % reader.grid_width + RIM;
        for cell in &reader.known {
            self.cells[place(cell.place)] = if cell.white { WHITE } else { BLACK };
        }
        for (i, cell) in reader.data.iter().enumerate() {
            let bit = code >> (reader.data.len() - 1 - i) & 1;
            self.cells[place(cell.place)] = if bit == 1 { WHITE } else { BLACK };
        }
        self.pack();
    }

    /// Fills `words`. Each row goes on into the next one, which only cells of the rim see.
    #[inline(always)]
    fn pack(&mut self) {
        self.words.clear();
        self.words.resize(self.cells.len(), 0);
        let mut word = 0;
        for (cell, slot) in self.cells.iter().zip(&mut self.words).rev() {
            word = (word << CELL_BITS | u32::from(*cell)) & ((1 << (CELL_BITS * MOST_CELLS)) - 1);
            *slot = word;
        }
    }

    /// Cells a row and a column.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// What has to be added to a coordinate counted from the border edge.
    pub(super) fn margin(&self) -> f64 {
        self.margin
    }

    /// A cell and those to its right.
    #[inline(always)]
    pub(super) fn word(&self, x: usize, y: usize) -> u32 {
        self.words[y * self.width + x]
    }

    /// 1 where the first of two cells is black and the second white, -1 the other way round, else 0.
    #[inline(always)]
    pub(super) fn step(&self, a: [usize; 2], b: [usize; 2]) -> i8 {
        let at = |[x, y]: [usize; 2]| self.cells[y * self.width + x];
        match (at(a), at(b)) {
            (BLACK, WHITE) => 1,
            (WHITE, BLACK) => -1,
            _ => 0,
        }
    }

    /// The first words of `WINDOW` rows from a cell on, and whether some cell in them is of unknown colour.
    #[inline(always)]
    pub(super) fn window<const WINDOW: usize>(&self, [x, y]: [u32; 2]) -> ([u32; WINDOW], bool) {
        let from = &self.words[y as usize * self.width + x as usize..][..(WINDOW - 1) * self.width + 1];
        let mut words = [0; WINDOW];
        let mut seen = 0;
        for (j, word) in words.iter_mut().enumerate() {
            *word = from[j * self.width];
            seen |= *word;
        }
        let unknown = ((1u32 << (CELL_BITS * WINDOW)) - 1) & (LOWEST * u32::from(UNKNOWN));
        (words, seen & unknown != 0)
    }

    /// Whether the colours of all cells from one to another, at most `MOST_CELLS` further right, are known.
    #[inline(always)]
    pub(super) fn is_known(&self, [x0, y0]: [usize; 2], [x1, y1]: [usize; 2]) -> bool {
        let unknown = (LOWEST & ((1u32 << (CELL_BITS * (x1 - x0 + 1))) - 1)) * u32::from(UNKNOWN);
        let mut seen = 0;
        for y in y0..=y1 {
            seen |= self.word(x0, y);
        }
        seen & unknown == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_cells_are_the_lighter_or_darker_of_known_ones_and_the_mean_with_unknown_ones() {
        let colours = [BLACK, UNKNOWN, WHITE].map(i32::from);
        for (a, b) in colours.into_iter().flat_map(|a| colours.map(|b| (a, b))) {
            let known = a != i32::from(UNKNOWN) && b != i32::from(UNKNOWN);
            for lighter in [true, false] {
                let chosen = if lighter { a.max(b) } else { a.min(b) };
                let expected = if known { chosen } else { (a + b) / 2 };
                // Beside other cells, which must not leak into it.
                let word = |cell: i32| 0x4_0204 | (cell as u32) << (3 * CELL_BITS);
                let both = joined(word(a), word(b), lighter);
                assert_eq!(colour(both, 3), expected, "{a} and {b}");
                assert_eq!([0, 1, 2, 4].map(|k| colour(both, k)), [4, 0, 2, 4]);
            }
        }
    }
}
