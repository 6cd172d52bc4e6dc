//! Runs: maximal stretches of set bits in a row.

/// All runs of a plane, row after row.
#[derive(Default)]
pub(super) struct Runs {
    /// First column of each run.
    pub(super) start: Vec<u16>,
    /// One past the last column of each run.
    pub(super) end: Vec<u16>,
    /// For each row the number of runs before it; one entry more than rows.
    pub(super) first_of_row: Vec<u32>,
}

impl Runs {
    pub(super) fn clear(&mut self) {
        self.start.clear();
        self.end.clear();
        self.first_of_row.clear();
        self.first_of_row.push(0);
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
        let mut carry = 0;
        for (i, word) in bits.iter().enumerate() {
            let shifted = word << 1 | carry;
            carry = word >> 63;
            let starts = word & !shifted;
            ranks.starts[i] = starts;
            ranks.before[i] = self.start.len() as u32;
            push_bits(starts, i, &mut self.start);
            push_bits(shifted & !word, i, &mut self.end);
        }
        self.first_of_row.push(self.start.len() as u32);
    }
}

#[inline(always)]
fn push_bits(mut bits: u64, word: usize, columns: &mut Vec<u16>) {
    while bits != 0 {
        columns.push((word * 64) as u16 + bits.trailing_zeros() as u16);
        bits &= bits - 1;
    }
}

/// Finds the run that a column of a row lies in: its rank among the row's starts, by counting bits.
#[derive(Default)]
pub(super) struct Ranks {
    starts: Vec<u64>,
    before: Vec<u32>,
}

impl Ranks {
    fn resize(&mut self, words: usize) {
        self.starts.resize(words, 0);
        self.before.resize(words, 0);
    }

    /// The number of the run that holds `column`, which must be set.
    #[inline(always)]
    pub(super) fn run_at(&self, column: usize) -> usize {
        let word = column / 64;
        let up_to = self.starts[word] << (63 - column % 64);
        self.before[word] as usize + up_to.count_ones() as usize - 1
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
        assert_eq!(runs.start, [1, 63]);
        assert_eq!(runs.end, [3, 66]);
        assert_eq!(runs.of_row(0), 0..2);
        assert_eq!([1, 2, 63, 64, 65].map(|column| ranks.run_at(column)), [0, 0, 1, 1, 1]);
    }
}
