//! Phase 3: from the outline of a component to the four corners of a quad.
//!
//! Everything that can be refused is refused on the row profile, before a pixel is read: a ragged outline, one whose
//! four extreme points do not hold its area, one that strays from the sides of these four. Then each side's line is
//! fitted to the places where the grey values cross the threshold, which are edges to a fraction of a pixel; corners are
//! where the lines meet (paper III-C fits lines to boundary points; here the crossings take their place).

mod blank;
mod contour;
mod corners;
mod edge;
mod line;
mod outline;
mod rules;
mod shape;
mod sides;

use crate::binarize::raster::Raster;
use crate::binarize::{Contrast, Cuts};
use crate::cluster::{Clusters, Component};
use crate::numbered::Numbered;
use crate::simd::{Kernel, Level};
use crate::threads::Threads;
use contour::Contour;
use edge::Edges;
use outline::Outline;
use tagbus_family::Border;

/// A quadrilateral whose edge goes from one colour to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quad {
    /// Corners in frame pixels, clockwise as seen, beginning anywhere.
    pub(crate) corners: [[f64; 2]; 4],
    /// Normal: dark inside. Reversed: bright inside.
    pub(crate) border: Border,
}

/// Buffers of the fit.
pub(crate) struct Fit {
    /// One for each thread.
    scratches: Vec<Scratch>,
    found: Numbered<Quad>,
}

/// What a thread needs for one component after the other.
#[derive(Default)]
// In cache lines of its own: its neighbours in a list belong to other threads.
#[repr(align(128))]
struct Scratch {
    outline: Outline,
    contour: Contour,
}

impl Fit {
    /// Buffers for so many threads.
    pub(crate) fn new(threads: usize) -> Self {
        Self { scratches: (0..threads).map(|_| Scratch::default()).collect(), found: Numbered::default() }
    }
}

/// Fewer components than this are fitted before another thread is awake.
const LEAST_TO_DEAL: usize = 128;

/// What the components are and where their pixels lie.
pub(crate) struct Source<'a, R> {
    pub(crate) raster: R,
    pub(crate) cuts: &'a Cuts,
    pub(crate) clusters: &'a Clusters,
    pub(crate) border: Border,
    /// The least length of a side, in pixels of the search grid.
    pub(crate) shortest_side: f64,
    /// How much contrast there had to be for a pixel to be dark or bright.
    pub(crate) contrast: Contrast,
    /// Whether a tag may show nothing but its border's colour inside of it.
    pub(crate) may_be_full: bool,
}

impl<R: Raster> Source<'_, R> {
    /// Whether there are more components than a picture has. Hostile frames are to cost little more than others.
    #[inline(always)]
    fn is_crowded(&self) -> bool {
        let pixels = self.raster.width() * self.raster.height();
        self.clusters.components().len() > pixels / rules::PIXELS_A_COMPONENT
    }

    /// How rough an outline may be.
    #[inline(always)]
    fn rough(&self) -> &'static rules::Rough {
        match (self.is_crowded(), self.contrast) {
            (false, _) => &rules::IN_PICTURES,
            (true, Contrast::Measured) => &rules::IN_CROWDS,
            (true, Contrast::Least(_)) => &rules::IN_NOISE,
        }
    }
}

/// Appends the quads of all components to `quads`.
pub(crate) fn fit_quads<R: Raster>(
    level: Level,
    threads: &mut Threads,
    source: &Source<R>,
    fit: &mut Fit,
    quads: &mut Vec<Quad>,
) {
    let components = source.clusters.components();
    if threads.count() == 1 || components.len() < LEAST_TO_DEAL {
        let found = |_, quad| quads.push(quad);
        return level.run(FitAll { source, components, first: 0, scratch: &mut fit.scratches[0], found });
    }
    // Who fits the largest component is chance, and nobody is to allocate for it later.
    fit.scratches.iter_mut().for_each(|scratch| scratch.reserve(source.raster.height()));
    let length = threads.part_length(components.len());
    let Fit { scratches, found } = fit;
    threads.deal(scratches, components.chunks(length).enumerate(), |scratch, (part, components)| {
        let found = |number, quad| found.add(number, quad);
        level.run(FitAll { source, components, first: part * length, scratch, found });
    });
    found.move_to(quads);
}

impl Scratch {
    /// Makes room for any component of a raster with so many rows.
    fn reserve(&mut self, rows: usize) {
        self.outline.reserve(rows);
        self.contour.reserve();
    }
}

/// Hands the quads of some components to `found`, with the components' numbers.
struct FitAll<'a, 's, R, F> {
    source: &'a Source<'s, R>,
    components: &'a [Component],
    /// The number of the first.
    first: usize,
    scratch: &'a mut Scratch,
    found: F,
}

impl<R: Raster, F: FnMut(usize, Quad)> Kernel for FitAll<'_, '_, R, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { source, components, first, scratch, mut found } = self;
        for (i, component) in components.iter().enumerate() {
            if let Some(corners) = fit_component(source, component, scratch) {
                let corners = corners.map(|corner| source.raster.to_frame(corner));
                found(first + i, Quad { corners, border: source.border });
            }
        }
    }
}

/// The corners of one component on the search grid.
#[inline(always)]
fn fit_component<R: Raster>(
    source: &Source<R>,
    component: &Component,
    scratch: &mut Scratch,
) -> Option<[[f64; 2]; 4]> {
    let rough = source.rough();
    let rough_side = rough.side * source.shortest_side as f32;
    let (width, height) = (component.width(), component.height());
    // Four points of the outline lie in its box: no convex quad is longer than the box around it, and of those that are as narrow
    // as a side is short none can be read.
    if ((width + height) as f32) < 2.0 * rough_side || (width.min(height) as f32) < rough_side {
        return None;
    }
    let profile = source.clusters.profile(component);
    if outline::is_ragged(&profile, component, rough.length) {
        return None;
    }
    scratch.outline.fill(&profile, component);
    if scratch.outline.area < rough.area * (source.shortest_side * source.shortest_side) as f32 {
        return None;
    }
    let shows_cells = shows_cells(source, component);
    if shows_cells && component.area as f32 > rules::FULLEST * scratch.outline.area {
        return None;
    }
    let four = corners::extreme_points(&scratch.outline)?;
    let start = scratch.outline.clockwise(four);
    if shape::shortest_of(&start) < rough_side {
        return None;
    }
    let borne = rough.distance * rules::outline_distance(scratch.outline.area);
    if scratch.outline.mean_distance(&start) > borne {
        return None;
    }
    let edges = Edges {
        raster: source.raster,
        cuts: source.cuts,
        dark_inside: source.border == Border::Normal,
        centre: scratch.outline.centre(),
    };
    if shows_cells && blank::is_blank(&edges, &profile, four.map(|index| scratch.outline.pixel(index))) {
        return None;
    }
    let corners = if component.width() + component.height() < rules::CONTOUR_BELOW {
        scratch.contour.fill(&edges, &profile);
        scratch.contour.corners(four, profile.spans.len())
    } else {
        sides::corners(&edges, &profile, start)
    }?;
    let size = [component.width() as f64, component.height() as f64];
    shape::is_tag_like(&corners, size, source.shortest_side)
        .then(|| corners.map(|[x, y]| [x + f64::from(edges.centre[0]), y + f64::from(edges.centre[1])]))
}

/// Whether something of the other colour must lie inside of a component if it is to be a tag. A black cell in a white border may
/// vanish in blur where cells are small, so that the rule holds for those only when they are large. In crowded frames it holds for
/// white borders whatever the families: noise is full of specks, and few tags are white all over.
#[inline(always)]
fn shows_cells<R: Raster>(source: &Source<R>, component: &Component) -> bool {
    let is_large = component.width() + component.height() >= rules::CELLS_ARE_SEEN_FROM;
    match source.border {
        Border::Normal => !source.may_be_full,
        Border::Reversed => is_large && !source.may_be_full || source.is_crowded(),
    }
}
