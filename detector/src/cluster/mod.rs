//! Phase 2: connected components of one bit plane and their outlines.
//!
//! The paper clusters the boundary points between pairs of components. The outer border of a component touches exactly
//! one component of the other colour, so the outline of one component (black inside for a normal border, white for a
//! reversed one) says the same, without points, pairs, hashing or sorting. An outline is kept as a row profile: where
//! the component's first run starts and its last run ends in each row. Pixels are 4-connected, so that a border does not run across
//! a corner into what lies outside; bright ones of the darkest values of a decimated frame 8-connected, since these make borders thin.

mod band;
mod components;
mod contacts;
mod cut;
mod labels;
mod profiles;
mod runs;
mod seams;
mod specks;

pub(crate) use components::{Component, Limits};
pub(crate) use labels::Connectivity;
pub(crate) use profiles::Profile;

use crate::simd::Level;
use crate::threads::Threads;
use band::Band;
use components::{Keeping, Place};
use cut::{Cut, LEAST_ROWS};
use profiles::Profiles;
use seams::Seams;

/// The components of one bit plane. Both colours take turns in the same buffers.
#[derive(Default)]
pub(crate) struct Clusters {
    bands: Vec<Band>,
    cut: Cut,
    seams: Seams,
    /// Of the components that cross from band to band.
    crossing: Profiles,
    components: Vec<Component>,
}

/// Bands that a thread is dealt: a large one and a small one.
const BANDS_A_THREAD: usize = 2;
/// A plane of fewer pixels is searched before another thread is awake.
const LEAST_TO_DEAL: usize = 250_000;

impl Clusters {
    /// Finds the components of `plane` (`words` words a row) that `limits` allow, in the order of their first runs.
    pub(crate) fn fill(&mut self, level: Level, threads: &mut Threads, plane: &Plane, limits: &Limits) {
        let before = &self.bands[..self.cut.bands()];
        self.cut.by_runs(plane.height, bands(plane, threads), before);
        self.fill_cut(level, threads, plane, limits);
    }

    fn fill_cut(&mut self, level: Level, threads: &mut Threads, plane: &Plane, limits: &Limits) {
        if self.bands.len() < self.cut.bands() {
            self.bands.resize_with(self.cut.bands(), Band::default);
        }
        let Self { bands, cut, seams, crossing, components } = self;
        let bands = &mut bands[..cut.bands()];
        threads.each(bands.iter_mut().enumerate(), |(number, band)| {
            band.label(level, cut.rows_of(plane, limits, number), plane.connectivity);
        });
        seams.join(level, plane, cut, bands, limits);
        threads.each(bands.iter_mut().enumerate(), |(number, band)| {
            let keeping = Keeping {
                plane,
                limits,
                band: number,
                first_row: cut.rows(number).start,
                crossing: seams.of_band(number),
                offset: seams.offset(number),
            };
            band.outline(level, keeping);
        });
        seams.gather(bands, crossing);
        gather_components(bands, components);
    }

    /// The components that were kept.
    pub(crate) fn components(&self) -> &[Component] {
        &self.components
    }

    /// The outline of a kept component.
    #[inline(always)]
    pub(crate) fn profile(&self, component: &Component) -> Profile<'_> {
        let profiles = match component.place {
            Place::Band(band) => &self.bands[usize::from(band)].profiles,
            Place::Crossing => &self.crossing,
        };
        profiles.of(component)
    }
}

/// Puts the components of all bands one after the other.
fn gather_components(bands: &mut [Band], components: &mut Vec<Component>) {
    if let [band] = bands {
        // Hostile frames have so many that copying them would be felt.
        return std::mem::swap(&mut band.components, components);
    }
    components.clear();
    bands.iter().for_each(|band| components.extend_from_slice(&band.components));
}

/// Bands for as many threads as there are, where there is enough to do for them.
fn bands(plane: &Plane, threads: &Threads) -> usize {
    let is_worth_it = threads.count() > 1 && plane.width * plane.height >= LEAST_TO_DEAL;
    let most = (plane.height / LEAST_ROWS).max(1);
    if is_worth_it { (BANDS_A_THREAD * threads.count()).min(most) } else { 1 }
}

/// One bit plane and how its pixels connect.
pub(crate) struct Plane<'a> {
    /// Rows of `words` words; the last bit of each row is clear.
    pub(crate) bits: &'a [u64],
    /// For each row whether it is known to have no set bit.
    pub(crate) blank: &'a [bool],
    /// Words a row.
    pub(crate) words: usize,
    /// Columns of the raster.
    pub(crate) width: usize,
    /// Rows of the raster.
    pub(crate) height: usize,
    /// Whether diagonal neighbours belong together.
    pub(crate) connectivity: Connectivity,
}

#[cfg(test)]
mod tests;
