//! Which runs belong together: one pass over the rows with union by smaller label.

use super::Plane;
use super::runs::{Columns, Ranks, Runs};
use crate::simd::Level;

/// How pixels of a plane connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Connectivity {
    /// Side by side only.
    Four,
    /// Diagonally too.
    Eight,
}

/// What is known of a label while rows are read, and of a whole component once labels are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Extent {
    /// Pixels.
    pub(super) area: u32,
    /// First column.
    pub(super) left: u16,
    /// One past the last column.
    pub(super) right: u16,
    /// First row.
    pub(super) top: u16,
    /// Last row.
    pub(super) bottom: u16,
}

impl Extent {
    /// What is known before the first run.
    fn none_yet(row: u16) -> Self {
        Self { area: 0, left: u16::MAX, right: 0, top: row, bottom: row }
    }

    #[inline(always)]
    fn add_run(&mut self, start: u16, end: u16, row: u16) {
        self.area += u32::from(end - start);
        self.left = self.left.min(start);
        self.right = self.right.max(end);
        self.bottom = row;
    }

    pub(super) fn add(&mut self, other: &Extent) {
        self.area += other.area;
        self.left = self.left.min(other.left);
        self.right = self.right.max(other.right);
        self.top = self.top.min(other.top);
        self.bottom = self.bottom.max(other.bottom);
    }
}

/// A label for each run, and for each label its parent and extent.
#[derive(Default)]
pub(super) struct Labels {
    /// The label of each run.
    pub(super) of_run: Vec<u32>,
    /// Labels that were found to be one component point at a smaller one of it.
    pub(super) parent: Vec<u32>,
    pub(super) extent: Vec<Extent>,
    /// Where the profile of each label's component begins; filled by `keep_components`.
    pub(super) slot: Vec<u32>,
    count: usize,
    ranks: [Ranks; 2],
    contacts: Columns,
    contact_bits: Vec<u64>,
}

const NO_LABEL: u32 = u32::MAX;

impl Labels {
    fn clear(&mut self) {
        self.of_run.clear();
        self.count = 0;
    }

    /// How many labels there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The smallest label of the component, halving the path on the way.
    #[inline(always)]
    fn root(&mut self, mut label: u32) -> u32 {
        loop {
            let parent = self.parent[label as usize];
            if parent == label {
                return label;
            }
            let grandparent = self.parent[parent as usize];
            self.parent[label as usize] = grandparent;
            label = grandparent;
        }
    }

    /// The run `below` touches the run `above`, which already has a label.
    #[inline(always)]
    fn link(&mut self, above: usize, below: usize) {
        let (upper, lower) = (self.of_run[above], self.of_run[below]);
        self.of_run[below] = upper.min(lower);
        if lower != upper && lower != NO_LABEL {
            let (a, b) = (self.root(upper), self.root(lower));
            self.parent[a.max(b) as usize] = a.min(b);
        }
    }

    /// Gives labels to the runs of a row that touch nothing above, and counts every run in. The next free label is
    /// made ready for every run, and taken by those that need one: a branch would be mispredicted too often.
    #[inline(always)]
    fn finish_row(&mut self, runs: &Runs, row: usize) {
        let of_row = runs.of_row(row);
        let room = self.count + of_row.len() + 1;
        if self.parent.len() < room {
            self.parent.resize(room.next_power_of_two(), 0);
            self.extent.resize(room.next_power_of_two(), Extent::default());
        }
        let labels = &mut self.of_run[of_row.clone()];
        let spans = runs.starts()[of_row.clone()].iter().zip(&runs.ends()[of_row]);
        for (label, (start, end)) in labels.iter_mut().zip(spans) {
            self.parent[self.count] = self.count as u32;
            self.extent[self.count] = Extent::none_yet(row as u16);
            let is_new = *label == NO_LABEL;
            *label = if is_new { self.count as u32 } else { *label };
            self.count += usize::from(is_new);
            self.extent[*label as usize].add_run(*start, *end, row as u16);
        }
    }
}

/// Finds the runs of all rows and labels them.
#[inline(always)]
pub(super) fn label<const EIGHT: bool>(level: Level, plane: &Plane, runs: &mut Runs, labels: &mut Labels) {
    runs.clear();
    labels.clear();
    let mut ranks = std::mem::take(&mut labels.ranks);
    let mut above: &[u64] = &[];
    for (row, bits) in plane.bits.chunks_exact(plane.words).enumerate() {
        ranks.swap(0, 1);
        let [current, previous] = &mut ranks;
        runs.push_row(level, bits, current);
        labels.of_run.resize(runs.starts().len(), NO_LABEL);
        if row > 0 && !runs.of_row(row).is_empty() && !runs.of_row(row - 1).is_empty() {
            link_rows::<EIGHT>(level, above, bits, previous, current, labels);
        }
        labels.finish_row(runs, row);
        above = bits;
    }
    labels.ranks = ranks;
}

/// Links the runs of two rows that touch. Contacts are found 64 columns at a time in the bit planes.
#[inline(always)]
fn link_rows<const EIGHT: bool>(
    level: Level,
    above: &[u64],
    below: &[u64],
    upper: &Ranks,
    lower: &Ranks,
    labels: &mut Labels,
) {
    let mut contacts = std::mem::take(&mut labels.contacts);
    labels.contact_bits.resize(above.len(), 0);
    let mut carry = 0;
    for ((a, b), contact) in above.iter().zip(below).zip(&mut labels.contact_bits) {
        let overlap = a & b;
        *contact = overlap & !(overlap << 1 | carry);
        carry = overlap >> 63;
    }
    contacts.clear();
    contacts.push(level, &labels.contact_bits);
    for column in contacts.all() {
        labels.link(upper.run_at(usize::from(*column)), lower.run_at(usize::from(*column)));
    }
    labels.contacts = contacts;
    if EIGHT {
        link_diagonals(above, below, upper, lower, labels);
    }
}

/// Links runs that touch at a corner only.
#[inline(always)]
fn link_diagonals(above: &[u64], below: &[u64], upper: &Ranks, lower: &Ranks, labels: &mut Labels) {
    for i in 0..above.len() {
        let next = |row: &[u64]| row[i] >> 1 | row.get(i + 1).copied().unwrap_or(0) << 63;
        let (a, b, a_next, b_next) = (above[i], below[i], next(above), next(below));
        // The upper run ends at a column and the lower one starts at the next.
        let mut falling = a & !b & b_next & !a_next;
        while falling != 0 {
            let column = i * 64 + falling.trailing_zeros() as usize;
            labels.link(upper.run_at(column), lower.run_at(column + 1));
            falling &= falling - 1;
        }
        let mut rising = b & !a & a_next & !b_next;
        while rising != 0 {
            let column = i * 64 + rising.trailing_zeros() as usize;
            labels.link(upper.run_at(column + 1), lower.run_at(column));
            rising &= rising - 1;
        }
    }
}
