//! Quadrilaterals: the four lines that fit an outline best (III-C 3, figure 4 step 6).

use tagbus_family::Border;

use crate::corners::possible_corners;
use crate::decimate::Scale;
use crate::line::{Line, LineError, RunningMoments};
use crate::outline::{Outline, QUARTERS};

/// A side from which its points are farther than this on average (mean square, square pixels) is no line. AprilTag's
/// value; no paper names it.
const MAX_LINE_ERROR: f64 = 10.0;
/// Cosine of ten degrees: corners sharper or blunter than that are none. AprilTag's value as well.
const MAX_COSINE: f64 = 0.984_807_753_012_208;

/// A quadrilateral in the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quad {
    /// Counter-clockwise as seen, pixels of the frame.
    pub(crate) corners: [[f64; 2]; 4],
    pub(crate) border: Border,
}

/// The quad of an outline; `None` when it has none whose sides are as long as `shortest_side` (decimated pixels).
pub(crate) fn fit_quad(outline: &Outline, how: LineError, shortest_side: f64, scale: Scale) -> Option<Quad> {
    let points = RunningMoments::over(&outline.points);
    let sides = best_sides(&points, how)?;
    let corners = corners_between(&sides)?;
    if !is_plausible(&corners, shortest_side) {
        return None;
    }
    let in_frame = |[x, y]: [f64; 2]| {
        let [middle_x, middle_y] = outline.middle.map(|v| v as f64 / QUARTERS);
        scale.to_frame([middle_x + x, middle_y + y])
    };
    // Angles grow clockwise as seen, and reported corners go the other way round.
    let [a, b, c, d] = corners.map(in_frame);
    Some(Quad { corners: [d, c, b, a], border: outline.border })
}

/// A part of the outline between two possible corners, and the line through it.
#[derive(Clone, Copy)]
struct Side {
    line: Line,
    /// Mean squared distance of its points, square pixels.
    error: f64,
    /// The same, summed over its points.
    total: f64,
}

/// Of all ways to choose four of the possible corners the one whose lines leave the least error.
fn best_sides(points: &RunningMoments, how: LineError) -> Option<[Side; 4]> {
    let places = possible_corners(points, how);
    let side = |from: usize, to: usize| {
        let part = points.stretch(from, to);
        let error = part.line_error(how);
        Side { line: part.line(), error, total: error * part.count() }
    };
    // Every pair once, because each occurs in many choices.
    let sides: Vec<Vec<Side>> =
        places.iter().map(|from| places.iter().map(|to| side(*from, *to)).collect()).collect();
    let choices = fours(places.len());
    let candidates =
        choices.map(|[a, b, c, d]| [sides[a][b], sides[b][c], sides[c][d], sides[d][a]]).filter(fits);
    let total = |sides: &[Side; 4]| sides.iter().map(|side| side.total).sum::<f64>();
    candidates.min_by(|a, b| total(a).total_cmp(&total(b)))
}

/// All ways to choose four of `count` places in their order.
fn fours(count: usize) -> impl Iterator<Item = [usize; 4]> {
    let after = move |place: usize| place + 1..count;
    (0..count)
        .flat_map(move |a| after(a).map(move |b| [a, b]))
        .flat_map(move |[a, b]| after(b).map(move |c| [a, b, c]))
        .flat_map(move |[a, b, c]| after(c).map(move |d| [a, b, c, d]))
}

/// Whether all sides are lines, and none goes on in the direction of the one before.
fn fits(sides: &[Side; 4]) -> bool {
    let turns = |k: usize| sides[k].line.cosine(&sides[(k + 1) % 4].line) <= MAX_COSINE;
    sides.iter().all(|side| side.error <= MAX_LINE_ERROR) && (0..4).all(turns)
}

/// Where each side meets the next one.
fn corners_between(sides: &[Side; 4]) -> Option<[[f64; 2]; 4]> {
    let corner = |k: usize| sides[k].line.meet(&sides[(k + 1) % 4].line);
    Some([corner(0)?, corner(1)?, corner(2)?, corner(3)?])
}

/// Whether corners, clockwise as seen, are those of a convex quad of some size without needles.
fn is_plausible(corners: &[[f64; 2]; 4], shortest_side: f64) -> bool {
    let edge = |k: usize| [0, 1].map(|axis| corners[(k + 1) % 4][axis] - corners[k % 4][axis]);
    let is_corner = |k: usize| {
        let ([ax, ay], [bx, by]) = (edge(k), edge(k + 1));
        let lengths = ax.hypot(ay) * bx.hypot(by);
        ax * by - ay * bx > 0.0 && (ax * bx + ay * by).abs() <= MAX_COSINE * lengths
    };
    (0..4).all(is_corner) && area(corners) >= shortest_side * shortest_side
}

/// Half the cross product of the diagonals, positive when the corners go clockwise as seen.
fn area(corners: &[[f64; 2]; 4]) -> f64 {
    let diagonal = |k: usize| [0, 1].map(|axis| corners[k + 2][axis] - corners[k][axis]);
    let ([ax, ay], [bx, by]) = (diagonal(0), diagonal(1));
    0.5 * (ax * by - ay * bx)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{Unions, components};
    use crate::contours::contours;
    use crate::decimate::Filter;
    use crate::outline::{SortKey, outline};
    use crate::threshold::{Shade, Shades};
    use tagbus_scene::Stream;

    /// The pixels whose centres lie inside a convex quad (clockwise as seen).
    fn filled(corners: &[[f64; 2]; 4]) -> Shades {
        let mut at = 0;
        Shades::from_fn(160, 160, || {
            let [x, y] = [at % 160, at / 160].map(|v| f64::from(v) + 0.5);
            at += 1;
            let inside = |k: usize| {
                let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
                (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
            };
            if (0..4).all(inside) { Shade::Black } else { Shade::White }
        })
    }

    fn quads_of(shades: &Shades, how: LineError) -> Vec<Quad> {
        let contours = contours(shades, &mut components(shades, Unions::WithoutRedundant));
        let outlines = contours.iter().filter_map(|contour| outline(contour, SortKey::Slope));
        outlines
            .filter_map(|outline| fit_quad(&outline, how, 3.0, Scale::new(1, Filter::PointSampling)))
            .collect()
    }

    fn random_quad(random: &mut Stream) -> [[f64; 2]; 4] {
        let turn = random.between(0.0, 7.0);
        let mut corner = |k: i32| {
            let angle = turn + f64::from(k) * std::f64::consts::FRAC_PI_2 + random.between(-0.3, 0.3);
            let reach = random.between(30.0, 70.0);
            [80.0 + reach * angle.cos(), 80.0 + reach * angle.sin()]
        };
        [corner(0), corner(1), corner(2), corner(3)]
    }

    #[test]
    fn the_corners_of_filled_quads_are_found_within_a_pixel_and_both_line_errors_agree() {
        let mut random = Stream::new(11);
        let mut checked = 0;
        while checked < 100 {
            let truth = random_quad(&mut random);
            // Blunt corners and short sides are another matter.
            let edge = |k: usize| [0, 1].map(|axis| truth[(k + 1) % 4][axis] - truth[k % 4][axis]);
            let is_clear = |k: usize| {
                let ([ax, ay], [bx, by]) = (edge(k), edge(k + 1));
                ax * by - ay * bx > 0.5 * ax.hypot(ay) * bx.hypot(by) && ax.hypot(ay) > 25.0
            };
            if !(0..4).all(is_clear) {
                continue;
            }
            checked += 1;
            let found = quads_of(&filled(&truth), LineError::Eigenvalue);
            assert_eq!(found.len(), 1, "{truth:?}");
            assert_eq!(found[0].border, Border::Normal);
            for corner in truth {
                let off = found[0].corners.iter().map(|[x, y]| (x - corner[0]).hypot(y - corner[1]));
                let off = off.fold(f64::MAX, f64::min);
                assert!(off < 1.0, "{corner:?} of {truth:?} is {off} away from {:?}", found[0].corners);
            }
            assert!(area(&found[0].corners) < 0.0, "counter-clockwise as seen");
            let other = quads_of(&filled(&truth), LineError::Normal);
            for (a, b) in found[0].corners.iter().zip(&other[0].corners) {
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6);
            }
        }
    }

    #[test]
    fn quads_with_a_dent_a_needle_or_too_little_area_are_refused() {
        let square = [[40.0, 40.0], [52.0, 40.0], [52.0, 52.0], [40.0, 52.0]];
        assert!(is_plausible(&square, 12.0));
        assert!(!is_plausible(&square, 12.1));
        let [a, b, c, d] = square;
        assert!(!is_plausible(&[d, c, b, a], 3.0), "the other way round");
        assert!(!is_plausible(&[a, b, [46.0, 41.0], d], 3.0), "a dent");
        assert!(!is_plausible(
            &[[0.0, 0.0], [100.0, 0.0], [101.0, 10.0], [1.0, 10.0]].map(|[x, y]| [x + 9.9 * y, y]),
            3.0
        ));
    }

    #[test]
    fn every_choice_of_four_occurs_once() {
        assert_eq!(fours(10).count(), 210);
        assert_eq!(fours(4).collect::<Vec<_>>(), [[0, 1, 2, 3]]);
        assert_eq!(fours(3).count(), 0);
    }
}
