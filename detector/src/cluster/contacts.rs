//! Where the runs of two rows touch, found 64 columns at a time in the bit planes.

use super::runs::{Columns, Filled};
use crate::simd::Level;

/// What is done where two runs touch.
pub(super) trait Join {
    /// The run that holds a column of the upper row touches the one that holds a column of the lower row.
    fn join(&mut self, above: usize, below: usize);
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

/// Calls `join` for every two runs of two rows that touch.
#[inline(always)]
pub(super) fn join_rows<const EIGHT: bool, J: Join>(
    level: Level,
    above: &Row,
    below: &Row,
    contacts: &mut Contacts,
    join: &mut J,
) {
    let both = above.filled.start.max(below.filled.start)..above.filled.end.min(below.filled.end);
    // Runs that touch at a corner may lie in two words.
    let first = both.start.saturating_sub(usize::from(EIGHT));
    if first >= both.end {
        return;
    }
    let (above, below) = (above.bits, below.bits);
    let mut columns = std::mem::take(&mut contacts.columns);
    contacts.bits.resize(above.len(), 0);
    let mut carry = 0;
    let words = first..both.end;
    let rows = above[words.clone()].iter().zip(&below[words.clone()]);
    for ((a, b), contact) in rows.zip(&mut contacts.bits[words.clone()]) {
        let overlap = a & b;
        *contact = overlap & !(overlap << 1 | carry);
        carry = overlap >> 63;
    }
    columns.clear();
    columns.push(level, &contacts.bits[words.clone()], first);
    for column in columns.all() {
        join.join(usize::from(*column), usize::from(*column));
    }
    contacts.columns = columns;
    if EIGHT {
        join_diagonals(above, below, words, join);
    }
}

/// Joins runs that touch at a corner only.
#[inline(always)]
fn join_diagonals<J: Join>(above: &[u64], below: &[u64], words: Filled, join: &mut J) {
    for i in words {
        let next = |row: &[u64]| row[i] >> 1 | row.get(i + 1).copied().unwrap_or(0) << 63;
        let (a, b, a_next, b_next) = (above[i], below[i], next(above), next(below));
        // The upper run ends at a column and the lower one starts at the next.
        let mut falling = a & !b & b_next & !a_next;
        while falling != 0 {
            let column = i * 64 + falling.trailing_zeros() as usize;
            join.join(column, column + 1);
            falling &= falling - 1;
        }
        let mut rising = b & !a & a_next & !b_next;
        while rising != 0 {
            let column = i * 64 + rising.trailing_zeros() as usize;
            join.join(column + 1, column);
            rising &= rising - 1;
        }
    }
}
