//! Where the runs of two rows touch, found 64 columns at a time in the bit planes.

use super::runs::{Columns, Filled};
use crate::simd::Level;

/// What is done where two runs touch.
pub(super) trait Join {
    /// The run that holds a column of the upper row, or ends right before it, touches the one of the lower row that does.
    fn join(&mut self, column: usize);
}

/// Buffers of the search.
#[derive(Default)]
pub(super) struct Contacts {
    bits: Vec<u64>,
    columns: Columns,
}

/// A row and the words of it in which its runs are.
pub(super) struct Row<'a> {
    pub(super) bits: &'a [u64],
    pub(super) filled: Filled,
}

impl Row<'_> {
    /// The last bit of the word before this one.
    fn carry_into(&self, word: usize) -> u64 {
        if word == 0 { 0 } else { self.bits[word - 1] >> 63 }
    }
}

/// Calls `join` for every two runs of two rows that touch: once, at the first column of the one that starts later. There the other
/// one is, or, if corners count, has just ended.
#[inline(always)]
pub(super) fn join_rows<const EIGHT: bool, J: Join>(
    level: Level,
    above: &Row,
    below: &Row,
    contacts: &mut Contacts,
    join: &mut J,
) {
    let words = above.filled.start.max(below.filled.start)..above.filled.end.min(below.filled.end);
    if words.is_empty() {
        return;
    }
    contacts.bits.resize(above.bits.len(), 0);
    let carries = [above.carry_into(words.start), below.carry_into(words.start)];
    let rows = above.bits[words.clone()].iter().zip(&below.bits[words.clone()]);
    let found = &mut contacts.bits[words.clone()];
    if EIGHT {
        find_eight(rows.zip(found), carries);
    } else {
        find_four(rows.zip(found));
    }
    let mut columns = std::mem::take(&mut contacts.columns);
    columns.clear();
    columns.push(level, &contacts.bits[words.clone()], words.start);
    for column in columns.all() {
        join.join(usize::from(*column));
    }
    contacts.columns = columns;
}

/// The first column of each stretch of columns that both rows have: there a run begins, in one of them or in both.
#[inline(always)]
fn find_four<'b>(rows: impl Iterator<Item = ((&'b u64, &'b u64), &'b mut u64)>) {
    let mut carry = 0;
    for ((a, b), contact) in rows {
        let overlap = a & b;
        *contact = overlap & !(overlap << 1 | carry);
        carry = overlap >> 63;
    }
}

/// The columns where a run begins in one row, and in the other one is or has just ended. `carries`: the columns before.
#[inline(always)]
fn find_eight<'b>(rows: impl Iterator<Item = ((&'b u64, &'b u64), &'b mut u64)>, carries: [u64; 2]) {
    let [mut carry_a, mut carry_b] = carries;
    for ((a, b), contact) in rows {
        let (before_a, before_b) = (a << 1 | carry_a, b << 1 | carry_b);
        *contact = a & !before_a & (b | before_b) | b & !before_b & (a | before_a);
        (carry_a, carry_b) = (a >> 63, b >> 63);
    }
}
