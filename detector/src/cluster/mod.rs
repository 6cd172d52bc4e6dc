//! Phase 2: connected components of one bit plane and their outlines.
//!
//! The paper clusters the boundary points between pairs of components. The outer border of a component touches exactly
//! one component of the other colour, so the outline of one component (black inside for a normal border, white for a
//! reversed one) says the same, without points, pairs, hashing or sorting. An outline is kept as a row profile: where
//! the component's first run starts and its last run ends in each row. Dark components are 4-connected and bright ones
//! 8-connected, as they must be for their borders to match.

mod components;
mod labels;
mod profiles;
mod runs;

pub(crate) use components::{Component, Limits};
pub(crate) use labels::Connectivity;
pub(crate) use profiles::Profile;

use crate::simd::{Kernel, Level};
use components::keep_components;
use labels::Labels;
use profiles::{Profiles, fill_profiles};
use runs::Runs;

/// The components of one bit plane. Both colours take turns in the same buffers.
#[derive(Default)]
pub(crate) struct Clusters {
    runs: Runs,
    labels: Labels,
    profiles: Profiles,
    components: Vec<Component>,
}

impl Clusters {
    /// Finds the components of `plane` (`words` words a row) that `limits` allow.
    pub(crate) fn fill(&mut self, level: Level, plane: &Plane, limits: &Limits) {
        level.run(Label { level, plane, clusters: &mut *self });
        keep_components(&mut self.labels, plane, limits, &mut self.components, &mut self.profiles);
        level.run(Outline { clusters: self });
    }

    /// The components that were kept.
    pub(crate) fn components(&self) -> &[Component] {
        &self.components
    }

    /// The outline of a kept component.
    pub(crate) fn profile(&self, component: &Component) -> Profile<'_> {
        self.profiles.of(component)
    }
}

/// One bit plane and how its pixels connect.
pub(crate) struct Plane<'a> {
    /// Rows of `words` words; the last bit of each row is clear.
    pub(crate) bits: &'a [u64],
    /// Words a row.
    pub(crate) words: usize,
    /// Columns of the raster.
    pub(crate) width: usize,
    /// Rows of the raster.
    pub(crate) height: usize,
    /// Whether diagonal neighbours belong together.
    pub(crate) connectivity: Connectivity,
}

struct Label<'a> {
    level: Level,
    plane: &'a Plane<'a>,
    clusters: &'a mut Clusters,
}

impl Kernel for Label<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Clusters { runs, labels, .. } = self.clusters;
        match self.plane.connectivity {
            Connectivity::Four => labels::label::<false>(self.level, self.plane, runs, labels),
            Connectivity::Eight => labels::label::<true>(self.level, self.plane, runs, labels),
        }
    }
}

struct Outline<'a> {
    clusters: &'a mut Clusters,
}

impl Kernel for Outline<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Clusters { runs, labels, profiles, components } = self.clusters;
        fill_profiles(runs, labels, components, profiles);
    }
}

#[cfg(test)]
mod tests;
