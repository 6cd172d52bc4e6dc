//! Components with nothing of the other colour inside, such as the squares of a chessboard: no tag looks like that.

use super::edge::Edges;
use crate::binarize::raster::Raster;
use crate::cluster::Profile;

/// Samples a row and a column at most: four for each cell of a tag of eight.
const SAMPLES: usize = 32;

/// Whether no sample inside of the outline is of the other colour. Where a tile has no contrast of its own, a sample is judged by the
/// cuts at `corners`, pixels of the component: by the one that it passes most easily, as light may differ across a tag.
#[inline(always)]
pub(super) fn is_blank<R: Raster>(edges: &Edges<R>, profile: &Profile, corners: [[usize; 2]; 4]) -> bool {
    let cuts = corners.map(|[x, y]| edges.cuts.at(x, y));
    let of_corners =
        cuts.into_iter().reduce(|a, b| if edges.dark_inside { a.min(b) } else { a.max(b) }).unwrap_or(0);
    let step = profile.spans.len().div_ceil(SAMPLES);
    profile.spans.iter().enumerate().step_by(step).all(|(row, [start, end])| {
        let (y, step) = (profile.top + row, usize::from(end - start).div_ceil(SAMPLES));
        (usize::from(*start)..usize::from(*end)).step_by(step).all(|x| {
            let cut = match edges.cuts.at(x, y) {
                0 => of_corners,
                cut => cut,
            };
            (edges.raster.at(x, y) < cut) == edges.dark_inside
        })
    })
}
