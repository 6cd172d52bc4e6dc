//! Which runs belong together: one pass over the rows with union by smaller label.

use super::band::Rows;
use super::contacts::{Contacts, Join, join_rows};
use super::runs::{Ranks, Runs};
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
    contacts: Contacts,
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

    /// Makes every label point at its root and adds its extent there. Parents are smaller, so one pass upwards is enough.
    pub(super) fn merge(&mut self) {
        for label in 0..self.count {
            let parent = self.parent[label] as usize;
            if parent != label {
                let root = self.parent[parent];
                self.parent[label] = root;
                let extent = self.extent[label];
                self.extent[root as usize].add(&extent);
            }
        }
    }

    /// The component of a run: the label of its first run. Once labels are merged.
    pub(super) fn component_of(&self, run: usize) -> u32 {
        self.parent[self.of_run[run] as usize]
    }

    /// Gives labels to the runs of a row that touch nothing above, and counts every run in. The next free label is
    /// made ready for every run, and taken by those that need one: a branch would be mispredicted too often.
    #[inline(always)]
    fn finish_row(&mut self, runs: &Runs, row: usize, row_of_plane: u16) {
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
            self.extent[self.count] = Extent::none_yet(row_of_plane);
            let is_new = *label == NO_LABEL;
            *label = if is_new { self.count as u32 } else { *label };
            self.count += usize::from(is_new);
            self.extent[*label as usize].add_run(*start, *end, row_of_plane);
        }
    }
}

/// Links the runs of a row with those of the row above.
struct WithinBand<'a> {
    upper: &'a Ranks,
    lower: &'a Ranks,
    labels: &'a mut Labels,
}

impl Join for WithinBand<'_> {
    #[inline(always)]
    fn join(&mut self, above: usize, below: usize) {
        self.labels.link(self.upper.run_at(above), self.lower.run_at(below));
    }
}

/// Finds the runs of all rows and labels them.
#[inline(always)]
pub(super) fn label<const EIGHT: bool>(level: Level, rows: &Rows, runs: &mut Runs, labels: &mut Labels) {
    runs.clear();
    labels.clear();
    let mut ranks = std::mem::take(&mut labels.ranks);
    let mut contacts = std::mem::take(&mut labels.contacts);
    let mut above: &[u64] = &[];
    for (row, bits) in rows.bits.chunks_exact(rows.words).enumerate() {
        ranks.swap(0, 1);
        let [current, previous] = &mut ranks;
        runs.push_row(level, bits, current);
        if runs.of_row(row).is_empty() {
            continue;
        }
        labels.of_run.resize(runs.starts().len(), NO_LABEL);
        if row > 0 && !runs.of_row(row - 1).is_empty() {
            let mut within = WithinBand { upper: previous, lower: current, labels: &mut *labels };
            join_rows::<EIGHT, _>(level, above, bits, &mut contacts, &mut within);
        }
        labels.finish_row(runs, row, (rows.first + row) as u16);
        above = bits;
    }
    labels.ranks = ranks;
    labels.contacts = contacts;
}
