//! Some rows of a plane, which one thread works on.

use super::components::{Component, Keeping};
use super::labels::{Connectivity, Labels, label};
use super::profiles::{Profiles, fill_profiles};
use super::runs::Runs;
use crate::simd::{Kernel, Level};

/// What is known of some rows: their runs, labels of their own, and the outlines as far as they lie in them.
#[derive(Default)]
// In cache lines of its own: its neighbours in a list belong to other threads.
#[repr(align(128))]
pub(super) struct Band {
    pub(super) runs: Runs,
    pub(super) labels: Labels,
    pub(super) profiles: Profiles,
    pub(super) components: Vec<Component>,
}

/// Rows of a plane, from `first` on.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) bits: &'a [u64],
    /// For each whether it is known to have no set bit.
    pub(super) blank: &'a [bool],
    pub(super) words: usize,
    pub(super) first: usize,
    /// Whether pixels without a neighbour at a side may be left out: they are components of their own, and nobody wants such.
    pub(super) may_drop_specks: bool,
}

impl<'a> Rows<'a> {
    pub(super) fn count(&self) -> usize {
        self.blank.len()
    }

    /// The bits of a row, counted from the first of these.
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &'a [u64] {
        &self.bits[row * self.words..][..self.words]
    }
}

impl Band {
    /// Finds the components of these rows.
    pub(super) fn label(&mut self, level: Level, rows: Rows, connectivity: Connectivity) {
        let Self { runs, labels, .. } = self;
        level.run(LabelRuns { level, rows, connectivity, runs, labels });
    }

    /// Keeps the components that may be borders, and fills their profiles as far as they lie here.
    pub(super) fn outline(&mut self, level: Level, keeping: Keeping) {
        let Self { runs, labels, profiles, components } = self;
        level.run(Outline { keeping, runs, labels, profiles, components });
    }
}

struct LabelRuns<'a> {
    level: Level,
    rows: Rows<'a>,
    connectivity: Connectivity,
    runs: &'a mut Runs,
    labels: &'a mut Labels,
}

impl Kernel for LabelRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { level, rows, connectivity, runs, labels } = self;
        match connectivity {
            Connectivity::Four => label::<false>(level, &rows, runs, labels),
            Connectivity::Eight => label::<true>(level, &rows, runs, labels),
        }
        labels.merge();
    }
}

struct Outline<'a> {
    keeping: Keeping<'a>,
    runs: &'a Runs,
    labels: &'a mut Labels,
    profiles: &'a mut Profiles,
    components: &'a mut Vec<Component>,
}

impl Kernel for Outline<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { keeping, runs, labels, profiles, components } = self;
        let first = Profiles::first_offset(runs.rows());
        if keeping.keep(labels, components, profiles) > first {
            fill_profiles(runs, labels, profiles);
        }
    }
}
