//! Specks: pixels without a neighbour at a side. No tag is made of them, and noise and fine patterns are full of them, so that from
//! crowded rows they are dropped, 64 columns at a time, before anything is spent on each. Only where pixels connect at their sides:
//! few have no neighbour at a corner either.

use super::band::Rows;

/// With more than one run for so many columns a row is crowded: rows of pictures have half as many.
const COLUMNS_A_RUN: usize = 8;
/// Every how many rows one is left as it is, and says whether the next ones are crowded.
const LOOKED_AT: usize = 16;

/// Rows without their specks.
#[derive(Default)]
pub(super) struct Specks {
    are_many: bool,
    /// The last two rows, by turns, and whether specks were dropped from them; stale where they were not.
    left: [Vec<u64>; 2],
    were_dropped: [bool; 2],
}

impl Specks {
    /// Learns from a row with so many runs in so many words, if it is one that is looked at.
    #[inline(always)]
    pub(super) fn look_at(&mut self, row: usize, runs: usize, words: usize) {
        if row.is_multiple_of(LOOKED_AT) {
            self.are_many = runs * COLUMNS_A_RUN > words * 64;
        }
    }

    /// Drops the specks from a row if there are many. The first and the last row are left alone: their neighbours are not here.
    #[inline(always)]
    pub(super) fn drop_from(&mut self, rows: &Rows, row: usize) {
        let is_inside = !row.is_multiple_of(LOOKED_AT) && row + 1 < rows.count();
        let drops = self.are_many && is_inside && rows.may_drop_specks;
        self.were_dropped[row % 2] = drops;
        if drops {
            drop_specks(
                [-1, 0, 1].map(|step| rows.row(row.wrapping_add_signed(step))),
                &mut self.left[row % 2],
            );
        }
    }

    /// One of the last two rows.
    #[inline(always)]
    pub(super) fn row<'a>(&'a self, rows: &Rows<'a>, row: usize) -> &'a [u64] {
        if self.were_dropped[row % 2] { &self.left[row % 2] } else { rows.row(row) }
    }
}

/// What is left of a row (the second of three) without the pixels that have no neighbour beside, above or below.
#[inline(always)]
fn drop_specks([above, row, below]: [&[u64]; 3], left: &mut Vec<u64>) {
    left.resize(row.len(), 0);
    let last = row.len() - 1;
    for word in 0..row.len() {
        let before = if word == 0 { 0 } else { row[word - 1] >> 63 };
        let behind = if word == last { 0 } else { row[word + 1] << 63 };
        let beside = row[word] << 1 | before | row[word] >> 1 | behind;
        left[word] = row[word] & (beside | above[word] | below[word]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_touches_something_at_a_side_is_left() {
        let (first, last) = (1, 1 << 63);
        let row = [first | 0b110_1000 | last, first | 0b1000, last];
        let mut left = vec![7; 9];
        // Two that lie in two words, two side by side, one with another above; one with a neighbour at a corner goes.
        drop_specks([&[0b1_0000, 0b1000, 0], &row, &[0; 3]], &mut left);
        assert_eq!(left, [0b110_0000 | last, first | 0b1000, 0]);
        drop_specks([&[0; 3], &row, &[0b1000, 0, last]], &mut left);
        assert_eq!(left, [0b110_1000 | last, first, last]);
    }
}
