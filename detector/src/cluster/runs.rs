//! Runs: maximal stretches of set bits in a row.

use crate::simd::{self, Level};

/// All runs of a plane, row after row.
#[derive(Default)]
pub(super) struct Runs {
    /// First column of each run.
    start: Columns,
    /// One past the last column of each run.
    end: Columns,
    /// For each row the number of runs before it; one entry more than rows.
    first_of_row: Vec<u32>,
    start_bits: Vec<u64>,
    end_bits: Vec<u64>,
}

impl Runs {
    pub(super) fn clear(&mut self) {
        self.start.clear();
        self.end.clear();
        self.first_of_row.clear();
        self.first_of_row.push(0);
    }

    /// First columns of all runs so far.
    #[inline(always)]
    pub(super) fn starts(&self) -> &[u16] {
        self.start.all()
    }

    /// One past the last column of all runs so far.
    #[inline(always)]
    pub(super) fn ends(&self) -> &[u16] {
        self.end.all()
    }

    /// The runs of a row, as a range of run numbers.
    #[inline(always)]
    pub(super) fn of_row(&self, row: usize) -> std::ops::Range<usize> {
        self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize
    }

    /// Number of rows that have been pushed.
    pub(super) fn rows(&self) -> usize {
        self.first_of_row.len().saturating_sub(1)
    }

    /// Appends the runs of a row and fills `ranks`, the row's index, unless there are none.
    #[inline(always)]
    pub(super) fn push_row(&mut self, level: Level, bits: &[u64], ranks: &mut Ranks) {
        // Most rows of a plain wall.
        if bits.iter().all(|word| *word == 0) {
            return self.first_of_row.push(self.start.count as u32);
        }
        ranks.resize(bits.len());
        self.start_bits.resize(bits.len(), 0);
        self.end_bits.resize(bits.len(), 0);
        let (mut carry, mut before) = (0, self.start.count as u32);
        let words = bits.iter().zip(&mut self.start_bits).zip(&mut self.end_bits).zip(&mut ranks.words);
        for (((word, start), end), rank) in words {
            let shifted = word << 1 | carry;
            carry = word >> 63;
            (*start, *end) = (word & !shifted, shifted & !word);
            *rank = Rank { starts: *start, before };
            before += start.count_ones();
        }
        self.start.push(level, &self.start_bits);
        self.end.push(level, &self.end_bits);
        self.first_of_row.push(self.start.count as u32);
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

    /// Appends the columns of the set bits of a row's words.
    #[inline(always)]
    pub(super) fn push(&mut self, level: Level, words: &[u64]) {
        let wanted = self.count + words.len() * 64 + simd::COLUMNS_SLACK;
        if self.room.len() < wanted {
            self.room.resize(wanted.next_power_of_two(), 0);
        }
        self.count += simd::columns(level, words, &mut self.room[self.count..]);
    }
}

/// Finds the run that a column of a row lies in: its rank among the row's starts, by counting bits.
#[derive(Default)]
pub(super) struct Ranks {
    words: Vec<Rank>,
}

/// A word's starts of runs, and how many runs there are before them.
#[derive(Clone, Copy, Default)]
struct Rank {
    starts: u64,
    before: u32,
}

impl Ranks {
    /// Takes a row with so many runs before it.
    pub(super) fn fill(&mut self, bits: &[u64], mut before: u32) {
        self.words.clear();
        let mut carry = 0;
        for word in bits {
            let starts = word & !(word << 1 | carry);
            carry = word >> 63;
            self.words.push(Rank { starts, before });
            before += starts.count_ones();
        }
    }

    fn resize(&mut self, words: usize) {
        self.words.resize(words, Rank::default());
    }

    /// The number of the run that holds `column`, which must be set.
    #[inline(always)]
    pub(super) fn run_at(&self, column: usize) -> usize {
        let Rank { starts, before } = self.words[column / 64];
        let up_to = starts << (63 - column % 64);
        before as usize + up_to.count_ones() as usize - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cross_words_and_are_found_again_by_column() {
        let (mut runs, mut ranks) = (Runs::default(), Ranks::default());
        runs.clear();
        runs.push_row(Level::best(), &[0b0110 | 1 << 63, 0b11], &mut ranks);
        assert_eq!(runs.starts(), [1, 63]);
        assert_eq!(runs.ends(), [3, 66]);
        assert_eq!(runs.of_row(0), 0..2);
        assert_eq!([1, 2, 63, 64, 65].map(|column| ranks.run_at(column)), [0, 0, 1, 1, 1]);
    }
}
