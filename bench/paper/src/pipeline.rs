//! The steps in their order.

use tagbus_family::{Border, Family, Layout};

use crate::components::components;
use crate::contours::contours;
use crate::decimate::{Scale, decimate};
use crate::decode::{Reader, upright};
use crate::options::{Options, OptionsError};
use crate::outline::{Outline, outline};
use crate::overlap::keep_the_better;
use crate::picture::Picture;
use crate::quad::{Quad, fit_quad};
use crate::refine::{Refinement, refine};
use crate::threshold::threshold;

/// A tag that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Which family, by its place in the list given to [`Pipeline::new`].
    pub family: usize,
    /// The tag's id.
    pub id: u32,
    /// Wrong bits that were corrected.
    pub hamming: u32,
    /// Mean distance of the bits from their threshold in grey levels after sharpening, the worse of black and white.
    pub margin: f64,
    /// Bottom-left, bottom-right, top-right, top-left of the upright tag's border edge, pixels of the frame.
    pub corners: [[f64; 2]; 4],
}

/// What a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Calls of union (III-C 2).
    pub unions: u64,
    /// Pairs of components that touch.
    pub contours: usize,
    /// Boundary points that were sorted.
    pub points: usize,
    /// Quads that were read.
    pub quads: usize,
}

/// What a search found and did.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Fewest wrong bits first, then the largest margin first.
    pub detections: Vec<Detection>,
    /// What it took.
    pub counts: Counts,
}

/// A step, for observers that measure time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The decimated picture is made.
    Decimate,
    /// Its pixels are black, white or unsure.
    Threshold,
    /// Pixels are united to components.
    Components,
    /// Boundary points are collected for each pair of components.
    Contours,
    /// The points of each contour are sorted by their angle.
    Sort,
    /// Quads are fitted to the outlines.
    Fit,
    /// Quads are refined and read.
    Decode,
}

impl Phase {
    /// All of them in their order.
    pub const ALL: [Phase; 7] = [
        Phase::Decimate,
        Phase::Threshold,
        Phase::Components,
        Phase::Contours,
        Phase::Sort,
        Phase::Fit,
        Phase::Decode,
    ];
}

/// Finds tags as the paper does. Every step makes its result anew; nothing is kept from picture to picture.
#[derive(Clone, Debug)]
pub struct Pipeline {
    families: Vec<Family>,
    options: Options,
}

/// No tag is narrower than this in the decimated picture, pixels. AprilTag's value; no paper names it.
const SHORTEST_SIDE: f64 = 3.0;

impl Pipeline {
    /// A pipeline for these families, which may have borders of both kinds.
    ///
    /// # Errors
    /// [`OptionsError`] when there is no family or an option is out of range.
    pub fn new(families: &[Family], options: Options) -> Result<Pipeline, OptionsError> {
        options.check()?;
        match families.is_empty() {
            true => Err(OptionsError::NoFamily),
            false => Ok(Pipeline { families: families.to_vec(), options }),
        }
    }

    /// Finds the tags in a picture.
    pub fn detect(&self, picture: &Picture) -> Outcome {
        self.detect_observed(picture, |_| {})
    }

    /// As [`Pipeline::detect`]; `done` is called as each step ends.
    pub fn detect_observed(&self, picture: &Picture, mut done: impl FnMut(Phase)) -> Outcome {
        let (quads, counts) = self.search(picture, &mut done);
        let detections = self.decode(picture, &quads);
        done(Phase::Decode);
        Outcome { detections, counts }
    }

    /// What every quad shows, before any code is compared with those of a family: for each quad with a border of its
    /// kind the place of the family in the list given to [`Pipeline::new`] and the code, as far as the quad lies in the
    /// picture and is brighter where its border is white.
    pub fn read_codes(&self, picture: &Picture) -> Vec<(usize, u64)> {
        let (quads, _) = self.search(picture, &mut |_| {});
        let reader = self.reader();
        let codes = |quad: Quad| {
            self.with_border(quad.border).filter_map(move |(place, family)| {
                let code = reader.read_code(picture, &quad.corners, family.layout())?;
                Some((place, code))
            })
        };
        quads.iter().map(|quad| self.refined(picture, quad)).flat_map(codes).collect()
    }

    /// All steps up to the quads.
    fn search(&self, picture: &Picture, done: &mut impl FnMut(Phase)) -> (Vec<Quad>, Counts) {
        let Options { decimation, filter, unions, sort_key, .. } = self.options;
        let small = decimate(picture, decimation, filter);
        done(Phase::Decimate);
        let shades = threshold(&small);
        done(Phase::Threshold);
        let mut components = components(&shades, unions);
        done(Phase::Components);
        let contours = contours(&shades, &mut components);
        done(Phase::Contours);
        let outlines: Vec<Outline> =
            contours.iter().filter_map(|contour| outline(contour, sort_key)).collect();
        done(Phase::Sort);
        let quads = self.quads(&outlines);
        done(Phase::Fit);
        let counts = Counts {
            unions: components.unions(),
            contours: contours.len(),
            points: outlines.iter().map(|outline| outline.points.len()).sum(),
            quads: quads.len(),
        };
        (quads, counts)
    }

    /// The quads of the outlines whose border is that of some family.
    fn quads(&self, outlines: &[Outline]) -> Vec<Quad> {
        let Options { decimation, filter, line_error, .. } = self.options;
        let scale = Scale::new(decimation, filter);
        let quad = |outline: &Outline| {
            let shortest_side = self.shortest_side(outline.border, scale.factor())?;
            fit_quad(outline, line_error, shortest_side, scale)
        };
        outlines.iter().filter_map(quad).collect()
    }

    /// The side of the narrowest tag with this border when each cell is a pixel of the frame, in decimated pixels.
    fn shortest_side(&self, border: Border, factor: f64) -> Option<f64> {
        let of_border = self.families.iter().map(Family::layout).filter(|layout| layout.border() == border);
        let narrowest = of_border.map(Layout::width_at_border).min()?;
        Some((narrowest as f64 / factor).max(SHORTEST_SIDE))
    }

    fn decode(&self, picture: &Picture, quads: &[Quad]) -> Vec<Detection> {
        let refined = quads.iter().map(|quad| self.refined(picture, quad));
        keep_the_better(refined.flat_map(|quad| self.read(picture, quad)).collect())
    }

    fn refined(&self, picture: &Picture, quad: &Quad) -> Quad {
        match self.options.refinement {
            Refinement::None => *quad,
            Refinement::Gradients => refine(picture, quad, self.options.decimation as f64),
        }
    }

    /// What each family makes of a quad.
    fn read<'a>(&'a self, picture: &'a Picture, quad: Quad) -> impl Iterator<Item = Detection> + 'a {
        let reader = self.reader();
        self.with_border(quad.border).filter_map(move |(place, family)| {
            let read = reader.read(picture, &quad.corners, family)?;
            let corners = upright(&quad.corners, read.turns);
            Some(Detection {
                family: place,
                id: read.id,
                hamming: read.hamming,
                margin: read.margin,
                corners,
            })
        })
    }

    fn reader(&self) -> Reader {
        let Options { sampling, sharpening, hamming, .. } = self.options;
        Reader { sampling, sharpening, hamming }
    }

    /// The families with this border and their places.
    fn with_border(&self, border: Border) -> impl Iterator<Item = (usize, &Family)> {
        self.families.iter().enumerate().filter(move |(_, family)| family.layout().border() == border)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Filter, LineError, Sampling, SortKey, Unions};
    use tagbus_scene::{Scene, SceneConfig};

    fn scene_frame(frame: u64) -> (Picture, Vec<tagbus_scene::TrueTag>) {
        let config = SceneConfig { width: 640, height: 480, ..SceneConfig::default() };
        let scene = Scene::new(config).unwrap();
        let mut luma = vec![0; 640 * 480];
        scene.render(frame, &mut luma);
        (Picture::new(640, 480, luma).unwrap(), scene.truth(frame))
    }

    fn families() -> Vec<Family> {
        Family::PUBLISHED.iter().map(|name| Family::published(name).unwrap()).collect()
    }

    #[test]
    fn choices_that_compute_the_same_in_another_way_give_the_same_detections() {
        let (picture, _) = scene_frame(3);
        let detect = |options| Pipeline::new(&families(), options).unwrap().detect(&picture);
        let paper = detect(Options::default());
        assert!(paper.detections.len() >= 5);
        let all_unions = detect(Options { unions: Unions::All, ..Options::default() });
        assert_eq!(paper.detections, all_unions.detections);
        assert!(paper.counts.unions < all_unions.counts.unions);
        assert_eq!(paper, detect(Options { sort_key: SortKey::Atan2, ..Options::default() }));
        let normal = detect(Options { line_error: LineError::Normal, ..Options::default() });
        for (a, b) in paper.detections.iter().zip(&normal.detections) {
            assert_eq!((a.family, a.id, a.hamming), (b.family, b.id, b.hamming));
        }
    }

    #[test]
    fn every_option_finds_the_large_tags_of_a_scene() {
        let (picture, truth) = scene_frame(40);
        let paper = Options::default();
        for options in [
            paper,
            Options { decimation: 2, ..paper },
            Options { decimation: 2, filter: Filter::Box, ..paper },
            Options { sampling: Sampling::Nearest, ..paper },
            Options { sharpening: 0.0, ..paper },
            Options { refinement: Refinement::None, ..paper },
        ] {
            let families = families();
            let found = Pipeline::new(&families, options).unwrap().detect(&picture).detections;
            for tag in truth.iter().filter(|tag| tag.visible && tag.cell_px > 5.0) {
                let is_tag = |d: &&Detection| d.id == tag.id && families[d.family].name() == tag.family;
                let best = found
                    .iter()
                    .find(is_tag)
                    .unwrap_or_else(|| panic!("{} {} is missing with {options:?}", tag.family, tag.id));
                let off =
                    best.corners.iter().zip(&tag.corners).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
                let off = off.fold(0.0, f64::max);
                assert!(off < 1.0, "{} {} is {off} px off with {options:?}", tag.family, tag.id);
            }
        }
    }

    #[test]
    fn the_codes_of_all_quads_are_read_and_those_of_the_tags_are_among_them() {
        let (picture, _) = scene_frame(3);
        let families = families();
        let pipeline = Pipeline::new(&families, Options::default()).unwrap();
        let (outcome, codes) = (pipeline.detect(&picture), pipeline.read_codes(&picture));
        assert!(codes.len() > outcome.detections.len());
        for tag in outcome.detections.iter().filter(|tag| tag.hamming == 0) {
            let family = &families[tag.family];
            let mut turned = family.codes()[tag.id as usize];
            let is_there = (0..4).any(|_| {
                turned = family.layout().rotate90(turned);
                codes.contains(&(tag.family, turned))
            });
            assert!(is_there, "{} {} was found but not read", family.name(), tag.id);
        }
    }

    #[test]
    fn phases_end_in_their_order() {
        let (picture, _) = scene_frame(0);
        let mut seen = Vec::new();
        Pipeline::new(&families(), Options::default())
            .unwrap()
            .detect_observed(&picture, |phase| seen.push(phase));
        assert_eq!(seen, Phase::ALL);
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let refused = |options| Pipeline::new(&families(), options).unwrap_err().to_string();
        assert!(refused(Options { decimation: 0, ..Options::default() }).starts_with("decimation 0"));
        assert!(refused(Options { sharpening: -1.0, ..Options::default() }).starts_with("sharpening -1"));
        assert_eq!(Pipeline::new(&[], Options::default()).unwrap_err(), OptionsError::NoFamily);
    }
}
