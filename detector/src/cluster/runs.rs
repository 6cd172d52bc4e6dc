//! Runs: maximal stretches of set bits in a row.

use crate::simd::{self, Level};

/// The words of a row in which its runs start and end.
pub(super) type Filled = std::ops::Range<usize>;

/// Where the runs of a row are: nowhere in most rows of a plain wall, in a few words of those with a tag.
#[inline(always)]
pub(super) fn filled(bits: &[u64]) -> Filled {
    let is_filled = |word: &u64| *word != 0;
    let Some(first) = bits.iter().position(is_filled) else { return 0..0 };
    if bits.len() <= SHORT {
        return 0..bits.len();
    }
    let behind = bits.iter().rposition(is_filled).map_or(first, |last| last + 1);
    // A run may reach to the last bit of its word; in a row's last word it does not.
    first..(behind + 1).min(bits.len())
}

/// Rows of so few words are taken as a whole, which is quicker than to look for their ends.
const SHORT: usize = 4;

/// All runs of a plane, row after row.
#[derive(Default)]
pub(super) struct Runs {
    /// For each run its first column and one past its last. Both in one list: one search for bits finds them.
    edges: Columns,
    /// For each row the number of runs before it; one entry more than rows.
    first_of_row: Vec<u32>,
}

impl Runs {
    pub(super) fn clear(&mut self) {
        self.edges.clear();
        self.first_of_row.clear();
        self.first_of_row.push(0);
    }

    /// First column and one past the last of all runs so far.
    #[inline(always)]
    pub(super) fn spans(&self) -> &[[u16; 2]] {
        self.edges.all().as_chunks().0
    }

    /// The runs of a row, as a range of run numbers.
    #[inline(always)]
    pub(super) fn of_row(&self, row: usize) -> std::ops::Range<usize> {
        self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize
    }

    /// The number of runs before a row.
    pub(super) fn before(&self, row: usize) -> usize {
        self.first_of_row.get(row).map_or(0, |runs| *runs as usize)
    }

    /// The first row for which `is_above`, of a row and the number of runs before it, is no longer true.
    pub(super) fn row_at(&self, is_above: impl Fn(usize, usize) -> bool) -> usize {
        let (mut low, mut high) = (0, self.rows());
        while low < high {
            let middle = low.midpoint(high);
            match is_above(middle, self.before(middle)) {
                true => low = middle + 1,
                false => high = middle,
            }
        }
        low
    }

    /// Number of rows that have been pushed.
    pub(super) fn rows(&self) -> usize {
        self.first_of_row.len().saturating_sub(1)
    }

    /// Ends a row: one that has no runs but those appended since the row before.
    #[inline(always)]
    pub(super) fn end_row(&mut self) {
        self.first_of_row.push(self.spans().len() as u32);
    }

    /// Appends the runs of a row, whose edges lie in the words `filled`, and fills `ranks`, the row's index.
    #[inline(always)]
    pub(super) fn push_row(&mut self, level: Level, bits: &[u64], filled: &Filled, ranks: &mut Ranks) {
        ranks.fill(bits, filled, self.spans().len() as u32);
        self.edges.push(level, &ranks.edges[filled.clone()], filled.start);
        self.end_row();
    }
}

/// A growing list of columns.
#[derive(Default)]
pub(super) struct Columns {
    /// Longer than the list: entries from `count` on are free.
    room: Vec<u16>,
    count: usize,
}

impl Columns {
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// What is in the list.
    #[inline(always)]
    pub(super) fn all(&self) -> &[u16] {
        &self.room[..self.count]
    }

    /// Appends the columns of the set bits of some words of a row, from the word `first` on.
    #[inline(always)]
    pub(super) fn push(&mut self, level: Level, words: &[u64], first: usize) {
        let wanted = self.count + words.len() * 64 + simd::COLUMNS_SLACK;
        if self.room.len() < wanted {
            self.room.resize(wanted.next_power_of_two(), 0);
        }
        self.count += simd::columns(level, words, (first * 64) as u16, &mut self.room[self.count..]);
    }
}

/// Finds the run that a column of a row lies in or right behind, by counting the bits where runs start or end.
#[derive(Default)]
pub(super) struct Ranks {
    /// Set where a run starts and where one has ended. Only the words in which the row's runs are; others are stale.
    edges: Vec<u64>,
    /// How many starts and ends there are before each word, less one.
    before: Vec<u32>,
}

impl Ranks {
    /// Takes a row whose runs are in the words `filled`, with so many runs before it.
    #[inline(always)]
    pub(super) fn fill(&mut self, bits: &[u64], filled: &Filled, runs_before: u32) {
        self.edges.resize(bits.len(), 0);
        self.before.resize(bits.len(), 0);
        let (mut carry, mut before) = (0, (2 * runs_before).wrapping_sub(1));
        let (edges, counts) = (&mut self.edges[filled.clone()], &mut self.before[filled.clone()]);
        for ((word, edges), count) in bits[filled.clone()].iter().zip(edges).zip(counts) {
            *edges = word ^ (word << 1 | carry);
            carry = word >> 63;
            *count = before;
            before = before.wrapping_add(edges.count_ones());
        }
    }

    /// The number of the run that holds `column` or ends right before it; there must be one.
    #[inline(always)]
    pub(super) fn run_at(&self, column: usize) -> usize {
        let up_to = self.edges[column / 64] << (63 - column % 64);
        // Two for each run before, and the start of this one less one, and its end if that is there.
        self.before[column / 64].wrapping_add(up_to.count_ones()) as usize / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cross_words_and_are_found_again_by_column() {
        let (mut runs, mut ranks) = (Runs::default(), Ranks::default());
        runs.clear();
        let bits = [0, 0b0110 | 1 << 63, 0b11, 0, 0];
        assert_eq!(filled(&bits), 1..4);
        assert_eq!([filled(&bits[..4]), filled(&[0; 5])], [0..4, 0..0]);
        runs.push_row(Level::best(), &bits, &filled(&bits), &mut ranks);
        assert_eq!(runs.spans(), [[65, 67], [127, 130]]);
        assert_eq!(runs.of_row(0), 0..2);
        assert_eq!(
            [65, 66, 67, 127, 128, 129, 130].map(|column| ranks.run_at(column)),
            [0, 0, 0, 1, 1, 1, 1]
        );
    }
}
