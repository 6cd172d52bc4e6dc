//! Runs: maximal stretches of set bits in a row.

/// All runs of a plane, row after row.
#[derive(Default)]
pub(super) struct Runs {
    /// First column of each run.
    start: Columns,
    /// One past the last column of each run.
    end: Columns,
    /// For each row the number of runs before it; one entry more than rows.
    first_of_row: Vec<u32>,
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

    /// Appends the runs of a row and fills `ranks`, the row's index.
    #[inline(always)]
    pub(super) fn push_row(&mut self, bits: &[u64], ranks: &mut Ranks) {
        ranks.resize(bits.len());
        self.start.reserve(bits.len());
        self.end.reserve(bits.len());
        let mut carry = 0;
        for ((i, word), rank) in bits.iter().enumerate().zip(&mut ranks.words) {
            let shifted = word << 1 | carry;
            carry = word >> 63;
            let starts = word & !shifted;
            *rank = Rank { starts, before: self.start.count as u32 };
            self.start.push_bits(starts, i);
            self.end.push_bits(shifted & !word, i);
        }
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
    /// Entries that are written at once.
    const BLOCK: usize = 8;

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// What is in the list.
    #[inline(always)]
    pub(super) fn all(&self) -> &[u16] {
        &self.room[..self.count]
    }

    /// Makes room for the bits of so many words.
    #[inline(always)]
    pub(super) fn reserve(&mut self, words: usize) {
        let wanted = self.count + words * 64 + Self::BLOCK;
        if self.room.len() < wanted {
            self.room.resize(wanted.next_power_of_two(), 0);
        }
    }

    /// Appends the columns of the set bits of a word. Eight are written at a time, whether there are so many or not: a loop
    /// that ends with the last bit is mispredicted nearly every time, and few words have more than eight.
    #[inline(always)]
    pub(super) fn push_bits(&mut self, mut bits: u64, word: usize) {
        if bits == 0 {
            return;
        }
        let after = self.count + bits.count_ones() as usize;
        let base = (word * 64) as u16;
        for block in self.room[self.count..].chunks_exact_mut(Self::BLOCK) {
            for column in block {
                *column = base + bits.trailing_zeros() as u16;
                bits &= bits.wrapping_sub(1);
            }
            if bits == 0 {
                break;
            }
        }
        self.count = after;
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
        runs.push_row(&[0b0110 | 1 << 63, 0b11], &mut ranks);
        assert_eq!(runs.starts(), [1, 63]);
        assert_eq!(runs.ends(), [3, 66]);
        assert_eq!(runs.of_row(0), 0..2);
        assert_eq!([1, 2, 63, 64, 65].map(|column| ranks.run_at(column)), [0, 0, 1, 1, 1]);
    }

    #[test]
    fn the_columns_of_any_word_come_in_order() {
        for bits in [1, 1 << 63, u64::MAX, 0xff, 0x1ff, 0x5555_5555_5555_5555, 0x8000_0001_0001_0003] {
            let mut columns = Columns::default();
            columns.reserve(1);
            columns.push_bits(bits, 2);
            let expected: Vec<u16> = (0..64).filter(|i| bits >> i & 1 == 1).map(|i| 128 + i).collect();
            assert_eq!(columns.all(), expected, "{bits:#x}");
        }
    }
}
