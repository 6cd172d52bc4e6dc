//! Where the runs of two rows touch, found 64 columns at a time in the bit planes.

use super::runs::Columns;
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

/// Calls `join` for every two runs of two rows that touch.
#[inline(always)]
pub(super) fn join_rows<const EIGHT: bool, J: Join>(
    level: Level,
    above: &[u64],
    below: &[u64],
    contacts: &mut Contacts,
    join: &mut J,
) {
    let mut columns = std::mem::take(&mut contacts.columns);
    contacts.bits.resize(above.len(), 0);
    let mut carry = 0;
    for ((a, b), contact) in above.iter().zip(below).zip(&mut contacts.bits) {
        let overlap = a & b;
        *contact = overlap & !(overlap << 1 | carry);
        carry = overlap >> 63;
    }
    columns.clear();
    columns.push(level, &contacts.bits);
    for column in columns.all() {
        join.join(usize::from(*column), usize::from(*column));
    }
    contacts.columns = columns;
    if EIGHT {
        join_diagonals(above, below, join);
    }
}

/// Joins runs that touch at a corner only.
#[inline(always)]
fn join_diagonals<J: Join>(above: &[u64], below: &[u64], join: &mut J) {
    for i in 0..above.len() {
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
