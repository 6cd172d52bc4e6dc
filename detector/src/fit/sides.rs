//! Lines straight from the row profile: a steep side takes one edge point a row, a flat one one a column. No contour, no
//! order, no prefix sums; the first bad side ends the candidate.

use super::edge::Edges;
use super::line::{Line, Moments};
use super::rules;
use crate::binarize::raster::Raster;
use crate::cluster::Profile;

/// What one side's edge points say.
struct Side {
    line: Line,
    /// Edge points that were found, and places that were looked at.
    found: usize,
    looked: usize,
    /// The line's error over the largest allowed one.
    strain: f32,
}

/// Moves `corners` (pixels from the centre, clockwise) to where the lines of the sides meet. `None` if a side is no
/// straight edge.
#[inline(always)]
pub(super) fn corners<R: Raster>(
    edges: &Edges<R>,
    profile: &Profile,
    mut corners: [[f32; 2]; 4],
) -> Option<[[f64; 2]; 4]> {
    for round in 1..=rules::ROUNDS {
        let mut lines = [Line::default(); 4];
        let (mut found, mut looked, mut strain) = (0, 0, 0.0f32);
        for k in 0..4 {
            let side = fit_side(edges, profile, corners[k], corners[(k + 1) % 4], round == 1)?;
            lines[k] = side.line;
            found += side.found;
            looked += side.looked;
            strain = strain.max(side.strain);
        }
        if (found as f32) < rules::EDGE_SHARE_OF_ALL * looked as f32 {
            return None;
        }
        let mut met = [[0.0; 2]; 4];
        let mut moved = 0.0f32;
        for k in 0..4 {
            met[k] = lines[(k + 3) % 4].meet(&lines[k])?;
            let now = met[k].map(|v| v as f32);
            moved = moved.max((now[0] - corners[k][0]).abs()).max((now[1] - corners[k][1]).abs());
            corners[k] = now;
        }
        if (moved < rules::SETTLED && strain <= 1.0) || round == rules::ROUNDS {
            return (strain <= 1.0).then_some(met);
        }
        let reach = 2.0 * (profile.spans.len() + edges.raster.width()) as f32;
        if corners.as_flattened().iter().any(|v| v.abs() > reach) {
            return None;
        }
    }
    None
}

/// The line of the side between two corners.
#[inline(always)]
fn fit_side<R: Raster>(
    edges: &Edges<R>,
    profile: &Profile,
    from: [f32; 2],
    to: [f32; 2],
    first: bool,
) -> Option<Side> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = (dx * dx + dy * dy).sqrt();
    let reach = rules::search_width(first, length);
    let mut points = Points { edges, reach, moments: Moments::default(), found: 0, looked: 0 };
    if dy.abs() >= dx.abs() {
        steep_side(&mut points, profile, from, to);
    } else {
        flat_side(&mut points, profile, from, to);
    }
    let Points { moments, found, looked, .. } = points;
    if found < 3 || (found as f32) < rules::EDGE_SHARE_OF_SIDE * looked as f32 {
        return None;
    }
    let line = moments.line();
    let strain = line.error as f32 / rules::side_error(length);
    // While corners still move, twice the error is borne.
    (strain <= 2.0).then_some(Side { line, found, looked, strain })
}

/// Collects the edge points of a side.
struct Points<'e, 'c, R> {
    edges: &'e Edges<'c, R>,
    reach: f32,
    moments: Moments,
    found: usize,
    looked: usize,
}

impl<R: Raster> Points<'_, '_, R> {
    /// Looks between two pixels; `off` is how far that lies from where the side is expected.
    #[inline(always)]
    fn look(&mut self, inner: [usize; 2], outer: [usize; 2], off: f32) {
        self.looked += 1;
        if off.abs() >= self.reach {
            return;
        }
        if let Some(point) = self.edges.between(inner, outer) {
            self.found += 1;
            self.moments.add(f64::from(point.x), f64::from(point.y), f64::from(point.weight));
        }
    }
}

/// The part of a side that is used: its ends lie in the blur of the corners.
#[inline(always)]
fn without_ends(a: f32, b: f32) -> (f32, f32) {
    let (low, high) = (a.min(b), a.max(b));
    let length = high - low;
    let end = if length < 6.0 { 0.5 } else { (0.1 * length).max(1.0) };
    (low + end, high - end)
}

/// Clockwise sides that go down have the component on their left: the right end of each row.
#[inline(always)]
fn steep_side<R: Raster>(points: &mut Points<R>, profile: &Profile, from: [f32; 2], to: [f32; 2]) {
    let [cx, cy] = points.edges.centre;
    let (low, high) = without_ends(from[1], to[1]);
    let last = profile.top + profile.spans.len() - 1;
    let first_row = (low + cy - 0.5).ceil().max(profile.top as f32) as usize;
    let last_row = ((high + cy - 0.5).floor().max(0.0) as usize).min(last);
    let slope = (to[0] - from[0]) / (to[1] - from[1]);
    let goes_down = to[1] > from[1];
    for y in first_row..=last_row {
        let [left, right] = profile.spans[y - profile.top];
        let (left, right) = (usize::from(left), usize::from(right));
        let expected = from[0] + cx + slope * (y as f32 + 0.5 - cy - from[1]);
        if goes_down {
            points.look([right - 1, y], [right, y], right as f32 - expected);
        } else {
            points.look([left, y], [left.wrapping_sub(1), y], left as f32 - expected);
        }
    }
}

/// Clockwise sides that go right have the component below them. The outline's edge in a column is searched from the row
/// where the side is expected.
#[inline(always)]
fn flat_side<R: Raster>(points: &mut Points<R>, profile: &Profile, from: [f32; 2], to: [f32; 2]) {
    let [cx, cy] = points.edges.centre;
    let (low, high) = without_ends(from[0], to[0]);
    let first_column = (low + cx - 0.5).ceil().max(0.0) as usize;
    let last_column = (high + cx - 0.5).floor().max(0.0) as usize;
    let slope = (to[1] - from[1]) / (to[0] - from[0]);
    let goes_right = to[0] > from[0];
    for x in first_column..=last_column {
        let expected = from[1] + cy + slope * (x as f32 + 0.5 - cx - from[0]);
        let near = (expected - profile.top as f32) as isize;
        if goes_right {
            let y = profile.top + first_row_inside(profile.spans, near, x as u16);
            points.look([x, y], [x, y.wrapping_sub(1)], y as f32 - expected);
        } else {
            let y = profile.top + last_row_inside(profile.spans, near, x as u16);
            points.look([x, y], [x, y + 1], y as f32 + 1.0 - expected);
        }
    }
}

#[inline(always)]
fn is_inside(span: [u16; 2], column: u16) -> bool {
    column >= span[0] && column < span[1]
}

/// The row nearest to `near` in which the outline begins to hold `column`, going down.
#[inline(always)]
fn first_row_inside(spans: &[[u16; 2]], near: isize, column: u16) -> usize {
    let mut row = near.clamp(0, spans.len() as isize - 1) as usize;
    while row > 0 && is_inside(spans[row - 1], column) {
        row -= 1;
    }
    while row + 1 < spans.len() && !is_inside(spans[row], column) {
        row += 1;
    }
    row
}

/// The row nearest to `near` in which the outline ceases to hold `column`, going down.
#[inline(always)]
fn last_row_inside(spans: &[[u16; 2]], near: isize, column: u16) -> usize {
    let mut row = near.clamp(0, spans.len() as isize - 1) as usize;
    while row + 1 < spans.len() && is_inside(spans[row + 1], column) {
        row += 1;
    }
    while row > 0 && !is_inside(spans[row], column) {
        row -= 1;
    }
    row
}
