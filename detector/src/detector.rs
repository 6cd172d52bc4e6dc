//! The phases in their order, and the buffers that they share.

use tagbus_family::{Border, Family};

use crate::binarize::raster::{OnRaster, Raster, with_raster};
use crate::binarize::{Colours, Contrast, Planes, Scale, binarize};
use crate::cluster::{Clusters, Connectivity, Limits, Plane};
use crate::detection::Detection;
use crate::fit::{Fit, Quad, Source, fit_quads};
use crate::identify::{Identify, Reader, Scene, identify};
use crate::settings::{Decimation, Sampling, Search, Settings, SettingsError};
use crate::simd::Level;
use crate::threads::Threads;
use crate::view::{Geometry, LumaView};

/// A phase of detection, for observers that measure time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Grey values to dark and bright pixels.
    Binarize,
    /// Pixels to outlines of components.
    Cluster,
    /// Outlines to quads.
    Fit,
    /// Quads to tags.
    Identify,
}

/// Finds tags. Owns every buffer it needs and reuses them: after the first frames nothing is allocated.
pub struct Detector {
    readers: Vec<Reader>,
    settings: Settings,
    /// See [`least_values`].
    least_values: usize,
    level: Level,
    threads: Threads,
    buffers: Buffers,
    detections: Vec<Detection>,
}

struct Buffers {
    planes: Planes,
    clusters: Clusters,
    fit: Fit,
    quads: Vec<Quad>,
    identify: Identify,
}

impl Buffers {
    fn new(readers: &[Reader], settings: &Settings) -> Self {
        let threads = settings.threads;
        Self {
            planes: Planes::default(),
            clusters: Clusters::default(),
            fit: Fit::new(threads),
            quads: Vec::new(),
            identify: Identify::new(threads, readers, settings.refinement),
        }
    }
}

impl Detector {
    /// A detector for these families. Errors name the setting that is out of range.
    pub fn new(families: &[Family], settings: &Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        if families.is_empty() {
            return Err(SettingsError::NoFamily);
        }
        let threads =
            Threads::start(settings.threads).map_err(|error| SettingsError::NoThread(error.kind()))?;
        let reader = |(place, family)| Reader::new(place, family, settings.hamming, &settings.ids);
        let readers: Vec<Reader> = families.iter().enumerate().map(reader).collect();
        Ok(Self {
            buffers: Buffers::new(&readers, settings),
            least_values: least_values(&readers, settings.decimation.factor()),
            readers,
            settings: settings.clone(),
            level: Level::best(),
            threads,
            detections: Vec::new(),
        })
    }

    /// Uses the instructions of `level` from now on. Results do not change.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// The settings in force.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The corrected bits in force for each family: what was asked for, capped at what the family's distance bears.
    pub fn hamming(&self) -> impl Iterator<Item = u32> + '_ {
        self.readers.iter().map(|reader| reader.index.hamming())
    }

    /// Finds the tags in one frame, surest first. Cannot fail: a bad frame is refused when its [`LumaView`] is made.
    pub fn detect(&mut self, view: &LumaView) -> &[Detection] {
        self.detect_observed(view, |_| {})
    }

    /// As [`Self::detect`]; `done` is called as each phase ends (two of them once for each border colour, and all but
    /// the last once for each size of thresholds that [`Settings::search`] asks for). Only the last where so few values are left of a
    /// frame that they hold no tag.
    pub fn detect_observed(&mut self, view: &LumaView, mut done: impl FnMut(Phase)) -> &[Detection] {
        self.detections.clear();
        if may_hold_a_quad(view, self.settings.decimation, self.least_values) {
            self.search(view, &mut done);
        }
        done(Phase::Identify);
        &self.detections
    }

    /// Not inlined: what it takes to call it need not be near for a frame that holds nothing.
    #[inline(never)]
    fn search(&mut self, view: &LumaView, done: &mut impl FnMut(Phase)) {
        self.buffers.quads.clear();
        let search = GridSearch {
            scales: scales(self.settings.search),
            readers: &self.readers,
            level: self.level,
            threads: &mut self.threads,
            factor: self.settings.decimation.factor(),
            least_values: self.least_values,
            bright_connectivity: bright_connectivity(&self.settings),
            buffers: &mut self.buffers,
            done,
        };
        with_raster(view, self.settings.decimation, self.settings.sampling, search);
        let scene = Scene { view, readers: &self.readers, settings: &self.settings };
        let Buffers { quads, identify: buffers, .. } = &mut self.buffers;
        identify(self.level, &mut self.threads, &scene, quads, buffers, &mut self.detections);
    }
}

/// Phases 1 to 3: everything that looks at the search grid.
struct GridSearch<'a, F> {
    scales: &'static [Scale],
    readers: &'a [Reader],
    level: Level,
    threads: &'a mut Threads,
    factor: f64,
    least_values: usize,
    bright_connectivity: Connectivity,
    buffers: &'a mut Buffers,
    done: &'a mut F,
}

impl<F: FnMut(Phase)> OnRaster for GridSearch<'_, F> {
    type Output = ();

    fn on<R: Raster>(mut self, raster: R) {
        if raster.width().min(raster.height()) < self.least_values {
            return;
        }
        for scale in self.scales {
            self.binarize(raster, *scale);
            (self.done)(Phase::Binarize);
            for border in [Border::Normal, Border::Reversed] {
                self.find_quads(raster, border, scale.contrast());
            }
        }
    }
}

impl<F: FnMut(Phase)> GridSearch<'_, F> {
    fn binarize<R: Raster>(&mut self, raster: R, scale: Scale) {
        let has = |border| self.readers.iter().any(|reader| reader.border == border);
        let colours = Colours { dark: has(Border::Normal), bright: has(Border::Reversed) };
        binarize(self.level, self.threads, raster, colours, scale, &mut self.buffers.planes);
    }

    /// Adds the quads that have this border, if any family has.
    fn find_quads<R: Raster>(&mut self, raster: R, border: Border, contrast: Contrast) {
        let readers = || self.readers.iter().filter(|reader| reader.border == border);
        let Some(narrowest) = readers().map(|reader| reader.width).min_by(f64::total_cmp) else { return };
        let may_be_full = readers().any(|reader| reader.may_be_full);
        let Buffers { planes, clusters, fit, quads, .. } = &mut *self.buffers;
        let (bits, connectivity) = match border {
            Border::Normal => (&planes.dark, Connectivity::Four),
            Border::Reversed => (&planes.bright, self.bright_connectivity),
        };
        let (width, height) = (raster.width(), raster.height());
        let plane = Plane { bits, blank: &planes.blank, words: planes.words, width, height, connectivity };
        let shortest_side = shortest_side(narrowest, self.factor);
        clusters.fill(self.level, self.threads, &plane, &limits(shortest_side));
        (self.done)(Phase::Cluster);
        let source =
            Source { raster, cuts: &planes.cuts, clusters, border, shortest_side, contrast, may_be_full };
        fit_quads(self.level, self.threads, &source, fit, quads);
        (self.done)(Phase::Fit);
    }
}

/// Fewer values of the search grid along a side hold no quad.
const LEAST_SIDE: usize = 4;

/// How many values the search grid must have along its shorter side for a tag of the narrowest family: one more than its border takes,
/// since a component that reaches from rim to rim of the frame is dropped.
fn least_values(readers: &[Reader], factor: f64) -> usize {
    let sides = readers.iter().map(|reader| limits(shortest_side(reader.width, factor)).side);
    sides.min().map_or(LEAST_SIDE, usize::from) + 1
}

/// Whether there may be so many values: asked before anything is made ready for them.
fn may_hold_a_quad(view: &LumaView, decimation: Decimation, least_values: usize) -> bool {
    let Geometry { width, height, .. } = view.geometry();
    let (side, most_without) = (width.min(height), least_values - 1);
    match decimation {
        Decimation::Every(factor) => side > most_without * factor as usize,
        Decimation::ThreeToTwo => 2 * side > 3 * most_without,
    }
}

/// Least contrast of a thorough search, grey levels: with less, fitted sides say nothing.
const LEAST_CONTRAST: u8 = 5;

/// The thresholds that are tried one after the other, and whose quads are all read.
fn scales(search: Search) -> &'static [Scale] {
    match search {
        Search::Quick => &[Scale::Four(Contrast::Measured)],
        Search::Fine => &[Scale::Four(Contrast::Measured), Scale::Two(Contrast::Measured)],
        Search::Thorough => {
            &[Scale::Four(Contrast::Least(LEAST_CONTRAST)), Scale::Two(Contrast::Least(LEAST_CONTRAST))]
        }
    }
}

/// The black ring around a white border breaks where it is a value wide, and across corners the border would run into whatever lies
/// outside. With 4-connected bright pixels such a ring still holds. The darkest of pixels keep it whole, and make the white border
/// thin.
fn bright_connectivity(settings: &Settings) -> Connectivity {
    let widens_rings = settings.decimation.factor() >= 2.0 && settings.sampling == Sampling::Darkest;
    if widens_rings { Connectivity::Eight } else { Connectivity::Four }
}

/// The shortest side of a tag in pixels of the search grid: one full-resolution pixel a cell, but enough of them for lines.
fn shortest_side(width_at_border: f64, factor: f64) -> f64 {
    (width_at_border / factor.clamp(1.0, 1.5)).max(LEAST_SIDE as f64)
}

/// The smallest component, from the shortest side: a box may be a pixel smaller than the sides that are fitted to it.
fn limits(shortest_side: f64) -> Limits {
    let side = (shortest_side.floor() as u16).clamp(LEAST_SIDE as u16, 5);
    Limits { side, area: 16 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values along the grid's shorter side.
    struct ShorterSide;

    impl OnRaster for ShorterSide {
        type Output = usize;

        fn on<R: Raster>(self, raster: R) -> usize {
            raster.width().min(raster.height())
        }
    }

    #[test]
    fn a_frame_with_enough_values_is_always_searched() {
        let bytes = [0; 64 * 70];
        for (side, least_values) in (4..=64).flat_map(|side| [(side, 5), (side, 6)]) {
            let view = LumaView::grey(&bytes, side, 70).unwrap();
            let every = (1..=20).map(Decimation::Every);
            for decimation in every.chain([Decimation::ThreeToTwo]) {
                for (sampling, _) in Sampling::NAMES {
                    let has_enough = with_raster(&view, decimation, sampling, ShorterSide) >= least_values;
                    let is_searched = may_hold_a_quad(&view, decimation, least_values);
                    assert!(is_searched || !has_enough, "{side} pixels, {decimation:?}, {sampling:?}");
                }
            }
        }
        assert!(!may_hold_a_quad(&LumaView::grey(&bytes, 60, 70).unwrap(), Decimation::Every(20), 5));
    }

    #[test]
    fn a_border_must_leave_a_rim_of_the_frame_free() {
        let reader = |name: &&str| Reader::new(0, &Family::published(name).unwrap(), None, &[]);
        let least =
            |names: &[&str], factor| least_values(&names.iter().map(reader).collect::<Vec<_>>(), factor);
        // Ten cells from rim to rim of a tag, eight and five from border to border, at two pixels for three cells; never below four values.
        assert_eq!(least(&["tag36h11"], 8.0), 6);
        assert_eq!(least(&["tagStandard41h12"], 8.0), 5);
        assert_eq!(least(&["tag36h11", "tagStandard41h12"], 1.0), 6);
    }
}
