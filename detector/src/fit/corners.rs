//! Four points of an outline that can be the corners of a quad.

use super::outline::Outline;
use super::rules::area_tolerance;

/// The outline's points that span the largest quad: two that lie far apart, the farthest point on one side of the line
/// between them, and a fourth. `None` when the four do not hold the area of the outline.
///
/// The first two are usually opposite corners, and then the fourth is the farthest point on the other side. Steep
/// trapezoids have neighbouring corners farthest apart; then the fourth lies outside one of the triangle's other sides.
#[inline(always)]
pub(super) fn extreme_points(outline: &Outline) -> Option<[usize; 4]> {
    let first = farthest_from(outline, outline.middle);
    let second = farthest_from(outline, outline.point(first));
    let (left, right) = extremes_beside(outline, first, second);
    let (apex, opposite) = if left.distance > right.distance { (left, right) } else { (right, left) };
    if apex.distance == 0 {
        return None;
    }
    if holds_area(outline, apex.distance + opposite.distance) {
        return Some([first, apex.index, second, opposite.index]);
    }
    let on_left = left.distance > right.distance;
    let outside = |from, to| {
        let (left, right) = extremes_beside(outline, from, to);
        // Walking along the triangle with its third corner on the other hand, the outside is on the apex's hand.
        if on_left { left } else { right }
    };
    let before = outside(first, apex.index);
    let after = outside(apex.index, second);
    let four = if before.distance > after.distance {
        [first, before.index, apex.index, second]
    } else {
        [first, apex.index, after.index, second]
    };
    let gain = before.distance.max(after.distance).max(opposite.distance);
    holds_area(outline, apex.distance + gain).then_some(four)
}

/// A point beside a line: twice the area of the triangle that it spans with it, in quarter pixels, and which point.
#[derive(Clone, Copy)]
struct Beside {
    distance: i64,
    index: usize,
}

/// Whether two triangles of these doubled areas (in doubled coordinates) make up the outline's area.
#[inline(always)]
fn holds_area(outline: &Outline, eightfold: i64) -> bool {
    let [width, height] = outline.size;
    (outline.area - eightfold as f32 / 8.0).abs() <= area_tolerance(outline.area, width, height)
}

/// Value and index in one number, so that the largest value is found by a plain maximum, which vectorises.
#[inline(always)]
fn packed(value: i64, index: usize) -> i64 {
    value << 16 | index as i64
}

#[inline(always)]
fn farthest_from(outline: &Outline, [x, y]: [i32; 2]) -> usize {
    let mut best = -1;
    for (index, (px, py)) in outline.xs.iter().zip(&outline.ys).enumerate() {
        let (dx, dy) = (i64::from(px - x), i64::from(py - y));
        best = best.max(packed(dx * dx + dy * dy, index));
    }
    (best & 0xffff) as usize
}

/// The points farthest to the left and to the right of the line from one point to another, as seen with y up.
#[inline(always)]
fn extremes_beside(outline: &Outline, from: usize, to: usize) -> (Beside, Beside) {
    let ([ax, ay], [bx, by]) = (outline.point(from), outline.point(to));
    let (dx, dy) = (i64::from(bx - ax), i64::from(by - ay));
    let (mut left, mut right) = (0, 0);
    for (index, (px, py)) in outline.xs.iter().zip(&outline.ys).enumerate() {
        let cross = dx * i64::from(py - ay) - dy * i64::from(px - ax);
        left = left.max(packed(cross, index));
        right = right.max(packed(-cross, index));
    }
    let unpack = |packed: i64| Beside { distance: packed >> 16, index: (packed & 0xffff) as usize };
    (unpack(left), unpack(right))
}
