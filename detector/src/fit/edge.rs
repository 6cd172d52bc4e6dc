//! Edges to a fraction of a pixel: where the grey values between two neighbouring pixels cross their threshold.

use super::rules::LEAST_STEP;
use crate::binarize::Cuts;
use crate::binarize::raster::Raster;

/// The pixels around a component.
pub(super) struct Edges<'a, R> {
    pub(super) raster: R,
    pub(super) cuts: &'a Cuts,
    pub(super) dark_inside: bool,
    /// Middle of the component's box; edge points are given relative to it.
    pub(super) centre: [f32; 2],
}

/// A point of an edge, relative to the centre.
#[derive(Clone, Copy)]
pub(super) struct EdgePoint {
    pub(super) x: f32,
    pub(super) y: f32,
    /// The grey-level difference across the edge.
    pub(super) weight: f32,
}

impl<R: Raster> Edges<'_, R> {
    /// The edge between a pixel of the component and its neighbour outside. `None` at the frame's rim, in unsure tiles
    /// and where the outer pixel does not differ the right way. Coordinates left or above of the frame wrap around.
    #[inline(always)]
    pub(super) fn between(&self, inner: [usize; 2], outer: [usize; 2]) -> Option<EdgePoint> {
        if outer[0] >= self.raster.width() || outer[1] >= self.raster.height() {
            return None;
        }
        let cut = self.cuts.at(inner[0], inner[1]);
        if cut == 0 || self.cuts.at(outer[0], outer[1]) == 0 {
            return None;
        }
        let inside = i32::from(self.raster.at(inner[0], inner[1]));
        let outside = i32::from(self.raster.at(outer[0], outer[1]));
        let rise = outside - inside;
        let step = if self.dark_inside { rise } else { -rise };
        if step < LEAST_STEP {
            return None;
        }
        // Pixels below the cut are dark, so the threshold lies half a level below it.
        let share = ((f32::from(cut) - 0.5 - inside as f32) / rise as f32).clamp(0.0, 1.0);
        let place = |inner: usize, outer: usize| inner as f32 + 0.5 + share * (outer as f32 - inner as f32);
        Some(EdgePoint {
            x: place(inner[0], outer[0]) - self.centre[0],
            y: place(inner[1], outer[1]) - self.centre[1],
            weight: step as f32,
        })
    }
}
