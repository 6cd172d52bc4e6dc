//! Which runs belong together: one pass over the rows with union by smaller label.

use super::band::Rows;
use super::contacts::{Contacts, Join, Row, join_rows};
use super::runs::{Ranks, Runs, filled};
use super::specks::Specks;
use crate::simd::Level;

/// How pixels of a plane connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Connectivity {
    /// Side by side only.
    Four,
    /// Diagonally too.
    Eight,
}

/// What is known of a label while rows are read, and of a whole component once labels are merged. Nothing yet is all zeros.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Extent {
    /// Pixels.
    pub(super) area: u32,
    /// First column, one past the last, first row and last row. What can only become less is kept as its complement: then all
    /// four can only grow, and one instruction does it.
    ends: [u16; 4],
}

impl Extent {
    #[inline(always)]
    fn of_run([start, end]: [u16; 2], row: u16) -> Self {
        Self { area: u32::from(end - start), ends: [!start, end, !row, row] }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Extent) {
        self.area += other.area;
        for (end, other) in self.ends.iter_mut().zip(other.ends) {
            *end = (*end).max(other);
        }
    }

    /// First column.
    #[inline(always)]
    pub(super) fn left(&self) -> u16 {
        !self.ends[0]
    }

    /// One past the last column.
    #[inline(always)]
    pub(super) fn right(&self) -> u16 {
        self.ends[1]
    }

    /// First row.
    #[inline(always)]
    pub(super) fn top(&self) -> u16 {
        !self.ends[2]
    }

    /// Last row.
    #[inline(always)]
    pub(super) fn bottom(&self) -> u16 {
        self.ends[3]
    }
}

/// A label of runs.
#[derive(Clone, Copy, Default)]
pub(super) struct Label {
    /// Labels that were found to be one component point at a smaller one of it.
    pub(super) parent: u32,
    pub(super) extent: Extent,
}

/// A label for each run, and what is known of each label.
#[derive(Default)]
pub(super) struct Labels {
    /// The label of each run.
    pub(super) of_run: Vec<u32>,
    /// Longer than there are labels: those from `count` on are free.
    labels: Vec<Label>,
    /// Where the profile of each label's component begins; filled by `Keeping::keep`.
    pub(super) slot: Vec<u32>,
    count: usize,
    ranks: [Ranks; 2],
    contacts: Contacts,
    specks: Specks,
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

    /// What is known of all labels.
    pub(super) fn all(&self) -> &[Label] {
        &self.labels[..self.count]
    }

    /// What is known of all labels, and where the profiles of their components begin, which may be changed.
    #[inline(always)]
    pub(super) fn with_slots(&mut self) -> (&[Label], &mut [u32]) {
        (&self.labels[..self.count], &mut self.slot)
    }

    /// Makes every label point at its root and adds its extent there. Parents are smaller, so one pass upwards is enough.
    /// Those that are roots add nothing to themselves: a branch would be mispredicted too often.
    #[inline(always)]
    pub(super) fn merge(&mut self) {
        let labels = &mut self.labels[..self.count];
        for label in 0..labels.len() {
            let Label { parent, mut extent } = labels[label];
            let root = labels[parent as usize].parent;
            extent.area = if parent as usize == label { 0 } else { extent.area };
            labels[label].parent = root;
            labels[root as usize].extent.add(&extent);
        }
    }

    /// The component of a run: the label of its first run. Once labels are merged.
    pub(super) fn component_of(&self, run: usize) -> u32 {
        self.labels[self.of_run[run] as usize].parent
    }

    /// Gives labels to the runs of a row that touch nothing above, and counts every run in. The next free label is
    /// made ready for every run, and taken by those that need one: a branch would be mispredicted too often.
    #[inline(always)]
    fn finish_row(&mut self, runs: &Runs, row: usize, row_of_plane: u16) {
        let of_row = runs.of_row(row);
        let room = self.count + of_row.len() + 1;
        if self.labels.len() < room {
            self.labels.resize(room.next_power_of_two(), Label::default());
        }
        // Not by way of `self`: compilers would look up lists and count again for every run.
        let (labels, mut count) = (&mut self.labels[..room], self.count);
        for (label, span) in self.of_run[of_row.clone()].iter_mut().zip(&runs.spans()[of_row]) {
            labels[count] = Label { parent: count as u32, extent: Extent::default() };
            let is_new = *label == NO_LABEL;
            *label = if is_new { count as u32 } else { *label };
            count += usize::from(is_new);
            labels[*label as usize].extent.add(&Extent::of_run(*span, row_of_plane));
        }
        self.count = count;
    }
}

/// The smallest label of the component, halving the path on the way.
#[inline(always)]
fn root(labels: &mut [Label], mut label: u32) -> u32 {
    loop {
        let parent = labels[label as usize].parent;
        if parent == label {
            return label;
        }
        let grandparent = labels[parent as usize].parent;
        labels[label as usize].parent = grandparent;
        label = grandparent;
    }
}

/// Links the runs of a row with those of the row above.
struct WithinBand<'a> {
    upper: &'a Ranks,
    lower: &'a Ranks,
    of_run: &'a mut [u32],
    labels: &'a mut [Label],
}

impl Join for WithinBand<'_> {
    /// The run above has a label already.
    #[inline(always)]
    fn join(&mut self, column: usize) {
        let below = self.lower.run_at(column);
        let (upper, lower) = (self.of_run[self.upper.run_at(column)], self.of_run[below]);
        self.of_run[below] = upper.min(lower);
        if lower != upper && lower != NO_LABEL {
            let (a, b) = (root(self.labels, upper), root(self.labels, lower));
            self.labels[a.max(b) as usize].parent = a.min(b);
        }
    }
}

/// Finds the runs of all rows and labels them.
#[inline(always)]
pub(super) fn label<const EIGHT: bool>(level: Level, rows: &Rows, runs: &mut Runs, labels: &mut Labels) {
    runs.clear();
    labels.clear();
    let mut ranks = std::mem::take(&mut labels.ranks);
    let mut contacts = std::mem::take(&mut labels.contacts);
    let mut specks = std::mem::take(&mut labels.specks);
    let mut filled_above = 0..0;
    for row in 0..rows.count() {
        specks.drop_from(rows, row);
        let bits = specks.row(rows, row);
        let below = Row { bits, filled: if rows.blank[row] { 0..0 } else { filled(bits) } };
        if below.filled.is_empty() {
            runs.end_row();
            continue;
        }
        ranks.swap(0, 1);
        let [current, previous] = &mut ranks;
        runs.push_row(level, bits, &below.filled, current);
        labels.of_run.resize(runs.spans().len(), NO_LABEL);
        if row > 0 && !runs.of_row(row - 1).is_empty() {
            let Labels { of_run, labels, .. } = &mut *labels;
            let mut within = WithinBand { upper: previous, lower: current, of_run, labels };
            let above = Row { bits: specks.row(rows, row - 1), filled: filled_above };
            join_rows::<EIGHT, _>(level, &above, &below, &mut contacts, &mut within);
        }
        labels.finish_row(runs, row, (rows.first + row) as u16);
        filled_above = below.filled;
        specks.look_at(row, runs.of_row(row).len(), rows.words);
    }
    labels.ranks = ranks;
    labels.contacts = contacts;
    labels.specks = specks;
}
