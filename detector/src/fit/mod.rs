//! Phase 3: from the outline of a component to the four corners of a quad.
//!
//! Everything that can be refused is refused on the row profile, before a pixel is read: a ragged outline, one whose
//! four extreme points do not hold its area, one that strays from the sides of these four. Then each side's line is
//! fitted to the places where the grey values cross the threshold, which are edges to a fraction of a pixel; corners are
//! where the lines meet (paper III-C fits lines to boundary points; here the crossings take their place).

mod contour;
mod corners;
mod edge;
mod line;
mod outline;
mod rules;
mod shape;
mod sides;

use crate::binarize::Cuts;
use crate::binarize::raster::Raster;
use crate::cluster::{Clusters, Component};
use crate::simd::{Kernel, Level};
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
#[derive(Default)]
pub(crate) struct Fit {
    outline: Outline,
    contour: Contour,
}

/// What the components are and where their pixels lie.
pub(crate) struct Source<'a, R> {
    pub(crate) raster: R,
    pub(crate) cuts: &'a Cuts,
    pub(crate) clusters: &'a Clusters,
    pub(crate) border: Border,
    /// The least length of a side, in pixels of the search grid.
    pub(crate) shortest_side: f64,
}

/// Appends the quads of all components to `quads`.
pub(crate) fn fit_quads<R: Raster>(level: Level, source: &Source<R>, fit: &mut Fit, quads: &mut Vec<Quad>) {
    level.run(FitAll { source, fit, quads });
}

struct FitAll<'a, 's, R> {
    source: &'a Source<'s, R>,
    fit: &'a mut Fit,
    quads: &'a mut Vec<Quad>,
}

impl<R: Raster> Kernel for FitAll<'_, '_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { source, fit, quads } = self;
        for component in source.clusters.components() {
            if let Some(corners) = fit_component(source, component, fit) {
                let corners = corners.map(|corner| source.raster.to_frame(corner));
                quads.push(Quad { corners, border: source.border });
            }
        }
    }
}

/// The corners of one component on the search grid.
#[inline(always)]
fn fit_component<R: Raster>(
    source: &Source<R>,
    component: &Component,
    fit: &mut Fit,
) -> Option<[[f64; 2]; 4]> {
    let profile = source.clusters.profile(component);
    if outline::is_ragged(&profile, component) {
        return None;
    }
    fit.outline.fill(&profile, component);
    let four = corners::extreme_points(&fit.outline)?;
    let start = fit.outline.clockwise(four);
    if fit.outline.mean_distance(&start) > rules::outline_distance(fit.outline.area) {
        return None;
    }
    let edges = Edges {
        raster: source.raster,
        cuts: source.cuts,
        dark_inside: source.border == Border::Normal,
        centre: fit.outline.centre(),
    };
    let corners = if component.width() + component.height() < rules::CONTOUR_BELOW {
        fit.contour.fill(&edges, &profile);
        fit.contour.corners(four, profile.spans.len())
    } else {
        sides::corners(&edges, &profile, start)
    }?;
    let size = [component.width() as f64, component.height() as f64];
    shape::is_tag_like(&corners, size, source.shortest_side)
        .then(|| corners.map(|[x, y]| [x + f64::from(edges.centre[0]), y + f64::from(edges.centre[1])]))
}
