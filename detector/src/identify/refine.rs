//! Edges on the full-resolution frame: where grey values cross half-way between the levels on both sides.
//!
//! The reference takes the centroid of squared gradients in a window that may reach past the neighbouring cell, which pushes
//! small tags outwards or inwards by polarity. The half-way crossing, searched within half a cell, has half the error.

use super::homography::Homography;
use super::reader::{Reader, SideCells};
use super::sample::{Frame, LANES};
use crate::simd::{self, Crossings, Kernel};
use tagbus_family::Border;

/// The window across the edge: this share of a cell, at most this many pixels of the search grid, never less than the last.
const WINDOW: (f64, f64, f64) = (0.5, 2.0, 0.6);
/// The same share where half a cell was not enough.
const FAR_WINDOW: f64 = 0.9;
/// Levels are taken at the cells' centres, but not further from the edge than this many pixels: glare and shading make
/// far levels unequal.
const LEVEL_REACH: f64 = 3.0;
/// Length at both ends of a side that is left out, pixels: the blur of its corners, two sigma of a sharp lens. Chosen on real
/// pictures that it is also judged on; a video kept apart is a little better with more left out (bench/TRIED.md).
const END: f64 = 1.5;
/// Distance of samples across the edge, pixels.
const STEP: f64 = 0.5;
/// Most samples across the edge.
const MOST_ACROSS: usize = 81;
/// Profiles across the edge: one per two pixels of the side, at least these, at most as the effort says.
const LEAST_PROFILES: usize = 16;
const MOST_PROFILES: usize = 96;
/// Rounds of weighting profiles by their distance from the line, and the standard deviations from which weight falls.
const WEIGHTINGS: usize = 3;
const FAR: f64 = 1.5;
/// Points nearer than this many pixels keep their weight. Chosen as END was; it hardly matters on rendered tags.
const NEAR: f64 = 0.75;
/// A smaller difference between the levels on both sides is no edge, grey levels.
const LEAST_STEP: f32 = 3.0;
/// Corners that move less than this in a round have settled, pixels.
const SETTLED: f64 = 0.03;
/// A corner that moves further than this many pixels of the search grid, and these besides, has gone astray.
const FARTHEST_MOVE: (f64, f64) = (2.0, 2.0);

/// How much is done for a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Most profiles a side.
    profiles: usize,
    /// Most rounds of moving the corners.
    rounds: usize,
    /// How coarse the search grid was that the corners come from, pixels.
    factor: f64,
    /// How much of a cell the window across an edge may take.
    cells: f64,
}

impl Effort {
    /// Enough to see whether more is worth while.
    pub(crate) fn to_try(factor: f64) -> Self {
        Self { profiles: LEAST_PROFILES, rounds: 1, factor, cells: WINDOW.0 }
    }

    /// Enough to read the bits, for corners from a search grid of this factor.
    pub(crate) fn to_read(factor: f64) -> Self {
        Self { profiles: 24, rounds: if factor > 1.0 { 3 } else { 2 }, factor, cells: WINDOW.0 }
    }

    /// For a tag that is sure but whose corners do not lie within half a cell of its edges: nothing that looks like its
    /// border edge lies within a whole cell of it.
    pub(crate) fn to_read_from_afar(factor: f64) -> Self {
        Self { rounds: 4, cells: FAR_WINDOW, ..Self::to_read(factor) }
    }

    /// What long sides can give besides, for corners that were refined before.
    pub(crate) fn to_report() -> Self {
        Self { profiles: MOST_PROFILES, rounds: 1, factor: 1.0, cells: WINDOW.0 }
    }

    /// Whether some side of a quad is long enough for more profiles than were taken to read it.
    pub(crate) fn is_worth_it(corners: &[[f64; 2]; 4]) -> bool {
        let length = |k: usize| {
            (corners[(k + 1) % 4][0] - corners[k][0]).hypot(corners[(k + 1) % 4][1] - corners[k][1])
        };
        (0..4).any(|k| length(k) > 48.0)
    }
}

/// The corners moved to the edges. `None` when a side shows no clear edge or a corner moves too far.
pub(crate) fn refine(
    frame: &Frame,
    reader: &Reader,
    corners: &[[f64; 2]; 4],
    effort: &Effort,
) -> Option<[[f64; 2]; 4]> {
    frame.level().run(Refine { frame, reader, corners, effort })
}

/// A function of its own at every level: code that is read from the caches once serves all efforts.
struct Refine<'a> {
    frame: &'a Frame<'a>,
    reader: &'a Reader,
    corners: &'a [[f64; 2]; 4],
    effort: &'a Effort,
}

impl Kernel for Refine<'_> {
    type Output = Option<[[f64; 2]; 4]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        move_to_edges(self.frame, self.reader, self.corners, self.effort)
    }
}

#[inline(always)]
fn move_to_edges(
    frame: &Frame,
    reader: &Reader,
    corners: &[[f64; 2]; 4],
    effort: &Effort,
) -> Option<[[f64; 2]; 4]> {
    let mut refined = *corners;
    for round in 0..effort.rounds {
        // Once refined, corners are as near as those of an undecimated search.
        let reach = if round == 0 { WINDOW.1 * effort.factor } else { WINDOW.1 };
        let cells = if round == 0 { effort.cells } else { WINDOW.0 };
        let level_reach = if cells > WINDOW.0 { f64::MAX } else { LEVEL_REACH };
        let pass = Pass { reach, cells, level_reach, profiles: effort.profiles };
        let homography = Homography::from_square(&refined, reader.width)?;
        let mut lines = [SideLine::default(); 4];
        for (k, line) in lines.iter_mut().enumerate() {
            *line = refine_side(frame, reader, &homography, &refined, k, &pass)?;
        }
        let mut moved = 0.0f64;
        for k in 0..4 {
            let corner = lines[(k + 3) % 4].meet(&lines[k])?;
            moved = moved.max((corner[0] - refined[k][0]).abs()).max((corner[1] - refined[k][1]).abs());
            refined[k] = corner;
        }
        if moved < SETTLED {
            break;
        }
    }
    let stayed = |k: usize| {
        let moved = (refined[k][0] - corners[k][0]).hypot(refined[k][1] - corners[k][1]);
        moved <= FARTHEST_MOVE.0 * effort.factor + FARTHEST_MOVE.1
    };
    (0..4).all(stayed).then_some(refined)
}

/// How one round looks at the sides: at most this many pixels and this share of a cell across an edge, with at most so many
/// profiles.
struct Pass {
    reach: f64,
    cells: f64,
    /// Levels are not taken further from the edge than this many pixels.
    level_reach: f64,
    profiles: usize,
}

/// A line by a point on it and its direction.
#[derive(Clone, Copy, Default)]
struct SideLine {
    point: [f64; 2],
    along: [f64; 2],
}

impl SideLine {
    fn meet(&self, other: &Self) -> Option<[f64; 2]> {
        let sine = self.along[0] * other.along[1] - self.along[1] * other.along[0];
        if sine.abs() < 0.1 {
            return None;
        }
        let (dx, dy) = (other.point[0] - self.point[0], other.point[1] - self.point[1]);
        let t = (dx * other.along[1] - dy * other.along[0]) / sine;
        Some([self.point[0] + t * self.along[0], self.point[1] + t * self.along[1]])
    }
}

/// A side while it is refined: unit vectors along it and outwards, and the grey levels on both sides.
struct Side {
    from: [f64; 2],
    to: [f64; 2],
    outwards: [f64; 2],
    length: f64,
    /// Cell size across the side, pixels.
    cell: f64,
    half_way: f32,
    /// +1 when it is brighter outside, -1 when inside.
    sign: f32,
}

#[inline(always)]
fn refine_side(
    frame: &Frame,
    reader: &Reader,
    homography: &Homography,
    corners: &[[f64; 2]; 4],
    k: usize,
    pass: &Pass,
) -> Option<SideLine> {
    let side = measure_side(frame, reader, homography, corners, k, pass.level_reach)?;
    let window = (pass.cells * side.cell).min(pass.reach).max(WINDOW.2);
    let count = ((side.length / 2.0) as usize).clamp(LEAST_PROFILES, pass.profiles);
    let end = (0.5 * side.cell).min(0.12 * side.length).min(END) / side.length;
    let mut points = [[0.0f64; 2]; MOST_PROFILES];
    let mut found = 0;
    let mut first = 0;
    while first < count {
        let feet = feet(&side, first, count, end);
        let shifts = crossings(frame, &side, &feet, window);
        for i in 0..LANES {
            if shifts[i].is_finite() {
                points[found] = beside([feet[0][i], feet[1][i]], side.outwards, f64::from(shifts[i]));
                found += 1;
            }
        }
        first += LANES;
    }
    // No closure: it would be compiled without the level's instructions.
    if found >= 4 { Some(robust_line(&points[..found])) } else { None }
}

/// The feet of the profiles from number `first` on, of `count` that are spread along a side without its ends, which are this share
/// of it each; NaN behind the last one.
#[inline(always)]
fn feet(side: &Side, first: usize, count: usize, end: f64) -> [[f64; LANES]; 2] {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let t = end + (1.0 - 2.0 * end) * ((first + i) as f64 + 0.5) / count as f64;
        let t = if first + i < count { t } else { f64::NAN };
        [x[i], y[i]] = along(side.from, side.to, t);
    }
    [x, y]
}

/// Levels and cell size beside a side, from the centres of the cells along it.
#[inline(always)]
fn measure_side(
    frame: &Frame,
    reader: &Reader,
    homography: &Homography,
    corners: &[[f64; 2]; 4],
    k: usize,
    level_reach: f64,
) -> Option<Side> {
    let (from, to) = (corners[k], corners[(k + 1) % 4]);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 2.0 {
        return None;
    }
    let outwards = [dy / length, -dx / length];
    let (mut white, mut black, mut cell, mut samples) = (0.0, 0.0, 0.0, 0.0);
    for cells in &reader.sides[k] {
        let Beside { across, white: at_white, black: at_black } =
            beside_cells(homography, cells, outwards, level_reach);
        let w_inside = frame.contains_all(&at_white[0], &at_white[1]);
        let b_inside = frame.contains_all(&at_black[0], &at_black[1]);
        let w = frame.near_all(&at_white[0], &at_white[1]);
        let b = frame.near_all(&at_black[0], &at_black[1]);
        for i in 0..cells.count {
            let counts = w_inside[i] * b_inside[i];
            cell += across[i];
            white += counts * w[i];
            black += counts * b[i];
            samples += counts;
        }
    }
    let step = (white - black) / f32::max(samples, 1.0);
    if step < LEAST_STEP {
        return None;
    }
    let sign = if reader.border == Border::Normal { 1.0 } else { -1.0 };
    let half_way = (white + black) / (2.0 * samples);
    Some(Side { from, to, outwards, length, cell: cell / reader.width, half_way, sign })
}

/// Where levels are taken beside cells.
struct Beside {
    /// Cell sizes across the side, pixels.
    across: [f64; LANES],
    white: [[f32; LANES]; 2],
    black: [[f32; LANES]; 2],
}

#[inline(always)]
fn beside_cells(homography: &Homography, cells: &SideCells, outwards: [f64; 2], level_reach: f64) -> Beside {
    let (w, b) = (homography.project_lanes(&cells.white), homography.project_lanes(&cells.black));
    let mut places = Beside { across: [0.0; LANES], white: [[0.0; LANES]; 2], black: [[0.0; LANES]; 2] };
    for i in 0..LANES {
        let (w, b) = ([w[0][i], w[1][i]], [b[0][i], b[1][i]]);
        let across = ((w[0] - b[0]) * outwards[0] + (w[1] - b[1]) * outwards[1]).abs();
        let nearer = (level_reach / (0.5 * across)).min(1.0);
        // Half-way between the two cells lies the edge.
        let (w, b) = (along(w, b, 0.5 - 0.5 * nearer), along(w, b, 0.5 + 0.5 * nearer));
        places.across[i] = across;
        (places.white[0][i], places.white[1][i]) = (w[0] as f32, w[1] as f32);
        (places.black[0][i], places.black[1][i]) = (b[0] as f32, b[1] as f32);
    }
    places
}

/// How far outwards of each foot the grey value rises (or, for a reversed border, falls) through half-way; the nearest such
/// place within the window. NaN where there is none, and for a foot whose window leaves the frame.
#[inline(always)]
fn crossings(frame: &Frame, side: &Side, feet: &[[f64; LANES]; 2], window: f64) -> [f32; LANES] {
    let half = ((window / STEP).ceil() as usize).min(MOST_ACROSS / 2);
    let step = window / half as f64;
    let (mut x, mut y) = ([0.0f32; LANES], [0.0f32; LANES]);
    for i in 0..LANES {
        (x[i], y[i]) = (feet[0][i] as f32, feet[1][i] as f32);
    }
    let (first, last) = (ends(frame, side, feet, -window), ends(frame, side, feet, window));
    let mut crossings = Crossings { shifts: [f32::NAN; LANES], is_open: [0.0; LANES] };
    for i in 0..LANES {
        crossings.is_open[i] = first[i] * last[i];
    }
    if crossings.is_open == [0.0; LANES] {
        return crossings.shifts;
    }
    let (dx, dy) = ((side.outwards[0] * step) as f32, (side.outwards[1] * step) as f32);
    let middle = levels(frame, side, &x, &y, [0.0, 0.0]);
    let mut before = [middle, middle];
    // From the middle outwards, since the nearest crossing is wanted.
    for k in 1..=half {
        let k = k as f32;
        let outer = levels(frame, side, &x, &y, [k * dx, k * dy]);
        let inner = levels(frame, side, &x, &y, [-k * dx, -k * dy]);
        let now = [outer, inner];
        if !simd::look(frame.level(), &mut crossings, k, step as f32, &before, &now) {
            break;
        }
        before = now;
    }
    crossings.shifts
}

/// Whether the frame contains the points this far outwards of the feet: 1 or 0.
#[inline(always)]
fn ends(frame: &Frame, side: &Side, feet: &[[f64; LANES]; 2], distance: f64) -> [f32; LANES] {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let end = beside([feet[0][i], feet[1][i]], side.outwards, distance);
        (x[i], y[i]) = (end[0] as f32, end[1] as f32);
    }
    frame.contains_all(&x, &y)
}

/// How far the grey values at points, all moved alike, lie beyond half-way: positive outside of the tag's edge.
#[inline(always)]
fn levels(
    frame: &Frame,
    side: &Side,
    x: &[f32; LANES],
    y: &[f32; LANES],
    [dx, dy]: [f32; 2],
) -> [f32; LANES] {
    let (mut moved_x, mut moved_y) = ([0.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        moved_x[i] = x[i] + dx;
        moved_y[i] = y[i] + dy;
    }
    let mut values = frame.near_all(&moved_x, &moved_y);
    for value in &mut values {
        *value = (*value - side.half_way) * side.sign;
    }
    values
}

/// The point `share` of the way from one point to another.
#[inline(always)]
fn along(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
}

/// The point `distance` from another in a direction.
#[inline(always)]
fn beside(point: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [point[0] + distance * direction[0], point[1] + distance * direction[1]]
}

/// The line through points, by total least squares with the weight of far points reduced.
#[inline(always)]
fn robust_line(points: &[[f64; 2]]) -> SideLine {
    let mut weights = [1.0f64; MOST_PROFILES];
    let mut line = weighted_line(points, &weights);
    for _ in 1..WEIGHTINGS {
        if !reweigh(points, &line, &mut weights) {
            break;
        }
        line = weighted_line(points, &weights);
    }
    line
}

#[inline(always)]
fn weighted_line(points: &[[f64; 2]], weights: &[f64]) -> SideLine {
    let (mut total, mut x, mut y) = (0.0, 0.0, 0.0);
    for ([px, py], weight) in points.iter().zip(weights) {
        total += weight;
        x += weight * px;
        y += weight * py;
    }
    let middle = [x / total, y / total];
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for ([px, py], weight) in points.iter().zip(weights) {
        let (dx, dy) = (px - middle[0], py - middle[1]);
        xx += weight * dx * dx;
        xy += weight * dx * dy;
        yy += weight * dy * dy;
    }
    // Half the angle of the doubled-angle vector (xx - yy, 2 xy), without trigonometry.
    let (c, s) = (xx - yy, 2.0 * xy);
    let length = (c * c + s * s).sqrt();
    let along = if c >= 0.0 { [length + c, s] } else { [s.abs(), (length - c) * s.signum()] };
    let norm = along[0].hypot(along[1]).max(1e-30);
    SideLine { point: middle, along: along.map(|v| v / norm) }
}

/// Gives the points new weights; says whether there may be others among them than before.
#[inline(always)]
fn reweigh(points: &[[f64; 2]], line: &SideLine, weights: &mut [f64; MOST_PROFILES]) -> bool {
    let mut distances = [0.0f64; MOST_PROFILES];
    let mut farthest = 0.0f64;
    for (distance, [x, y]) in distances.iter_mut().zip(points) {
        *distance = ((y - line.point[1]) * line.along[0] - (x - line.point[0]) * line.along[1]).abs();
        farthest = farthest.max(*distance);
    }
    let (mut squares, mut total, mut least) = (0.0, 0.0, 1.0f64);
    if farthest < NEAR {
        // Most sides: all weights are 1, and so they were unless this is not the first time.
        for weight in &mut weights[..points.len()] {
            least = least.min(*weight);
            *weight = 1.0;
        }
        return least < 1.0;
    }
    for (distance, weight) in distances[..points.len()].iter().zip(weights.iter()) {
        squares += weight * distance.powi(2);
        total += weight;
    }
    let limit = (FAR * (squares / total).sqrt()).max(NEAR);
    for (distance, weight) in distances[..points.len()].iter().zip(weights) {
        *weight = if *distance < limit { 1.0 } else { limit / distance };
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_through_points_has_their_direction_whatever_it_is() {
        for degrees in (0..180).step_by(5) {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let points: Vec<[f64; 2]> =
                (0..20).map(|i| [5.0 + f64::from(i) * cos, 7.0 + f64::from(i) * sin]).collect();
            let line = weighted_line(&points, &[1.0; 20]);
            let parallel = (line.along[0] * cos + line.along[1] * sin).abs();
            assert!((parallel - 1.0).abs() < 1e-9, "{degrees} degrees: {:?}", line.along);
        }
    }

    #[test]
    fn one_far_point_hardly_turns_a_robust_line() {
        let mut points: Vec<[f64; 2]> = (0..30).map(|i| [f64::from(i), 2.0]).collect();
        points[3][1] = 4.0;
        let line = robust_line(&points);
        let off = (line.point[1] - 2.0).abs() + line.along[1].abs() * 15.0;
        // Without weights it is 0.22 px.
        assert!(off < 0.1, "off by {off} px");
    }
}
