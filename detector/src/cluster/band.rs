//! Some rows of a plane, which one thread works on.

use super::Plane;
use super::components::{Component, Keeping};
use super::labels::{Connectivity, Labels, label};
use super::profiles::{Profiles, fill_profiles};
use super::runs::Runs;
use crate::simd::{Kernel, Level};

/// What is known of some rows: their runs, labels of their own, and the outlines as far as they lie in them.
#[derive(Default)]
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
}

/// How a plane is cut into bands: all of the same number of rows but for the last.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    pub(super) rows: usize,
    pub(super) bands: usize,
}

impl Cut {
    /// Cuts a plane into about so many bands.
    pub(super) fn new(height: usize, bands: usize) -> Self {
        let rows = height.div_ceil(bands);
        Self { rows, bands: height.div_ceil(rows) }
    }

    /// The rows of a band.
    pub(super) fn rows_of<'a>(&self, plane: &Plane<'a>, band: usize) -> Rows<'a> {
        let (first, words) = (band * self.rows, plane.words);
        let end = (first + self.rows).min(plane.height);
        Rows { bits: &plane.bits[first * words..end * words], blank: &plane.blank[first..end], words, first }
    }
}

impl Band {
    /// Finds the components of these rows.
    pub(super) fn label(&mut self, level: Level, rows: Rows, connectivity: Connectivity) {
        let Self { runs, labels, .. } = self;
        level.run(LabelRuns { level, rows, connectivity, runs, labels });
        labels.merge();
    }

    /// Keeps the components that may be borders, and fills their profiles as far as they lie here.
    pub(super) fn outline(&mut self, level: Level, keeping: Keeping) {
        let Self { runs, labels, profiles, components } = self;
        let first = Profiles::first_offset(runs.rows());
        if keeping.keep(labels, components, profiles) > first {
            level.run(FillProfiles { runs, labels, profiles });
        }
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
    }
}

struct FillProfiles<'a> {
    runs: &'a Runs,
    labels: &'a Labels,
    profiles: &'a mut Profiles,
}

impl Kernel for FillProfiles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        fill_profiles(self.runs, self.labels, self.profiles);
    }
}
