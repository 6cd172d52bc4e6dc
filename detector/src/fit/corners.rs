//! Four points of an outline that can be the corners of a quad.

use std::ops::{Add, Mul, Sub};

use super::outline::Outline;
use super::rules::area_tolerance;

/// The outline's points that span the largest quad: two that lie far apart, the farthest point on one side of the line
/// between them, and a fourth. `None` when the four do not hold the area of the outline.
///
/// The first two are usually opposite corners, and then the fourth is the farthest point on the other side. Steep
/// trapezoids have neighbouring corners farthest apart; then the fourth lies outside one of the triangle's other sides.
#[inline(always)]
pub(super) fn extreme_points(outline: &Outline) -> Option<[usize; 4]> {
    let [width, height] = outline.size;
    if width + height < SMALL { extreme_points_in::<i32>(outline) } else { extreme_points_in::<i64>(outline) }
}

/// Width and height together of the boxes below which numbers of 32 bits are enough, twice as many of which fit in a vector: most
/// components are so small. Doubled coordinates differ by less than 256 then, sums of two products of such differences stay
/// below 2^17, and there are less than 256 points.
const SMALL: usize = 128;

/// Whole numbers of which products of coordinates and an index take a part each.
trait Wide:
    Copy + Ord + From<i32> + Into<i64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Bits of an index.
    const INDEX: u32;

    /// Value and index in one number, so that the largest value is found by a plain maximum, which vectorises.
    fn packed(self, index: usize) -> Self;
}

impl Wide for i32 {
    const INDEX: u32 = 8;

    #[inline(always)]
    fn packed(self, index: usize) -> Self {
        self << Self::INDEX | index as i32
    }
}

impl Wide for i64 {
    const INDEX: u32 = 16;

    #[inline(always)]
    fn packed(self, index: usize) -> Self {
        self << Self::INDEX | index as i64
    }
}

#[inline(always)]
fn extreme_points_in<T: Wide>(outline: &Outline) -> Option<[usize; 4]> {
    let first = farthest_from::<T>(outline, outline.middle);
    let second = farthest_from::<T>(outline, outline.point(first));
    let (left, right) = extremes_beside::<T>(outline, first, second);
    let (apex, opposite) = if left.distance > right.distance { (left, right) } else { (right, left) };
    if apex.distance == 0 {
        return None;
    }
    if holds_area(outline, apex.distance + opposite.distance) {
        return Some([first, apex.index, second, opposite.index]);
    }
    let on_left = left.distance > right.distance;
    let outside = |from, to| {
        let (left, right) = extremes_beside::<T>(outline, from, to);
        // Walking along the triangle with its third corner on the other hand, the outside is on the apex's hand.
        if on_left { left } else { right }
    };
    let before = outside(first, apex.index);
    let after = outside(apex.index, second);
    if before.distance.max(after.distance) == 0 {
        return None;
    }
    // Where a side is parallel to the line of the first two, the apex may be any point of that side: it is looked for again
    // now that its other neighbour is known.
    let four = if before.distance > after.distance {
        [first, before.index, outside(before.index, second).index, second]
    } else {
        [first, outside(first, after.index).index, after.index, second]
    };
    holds_area(outline, eightfold_area(outline, four)).then_some(four)
}

/// Eight times the area of the quad of four points: twice by the formula, four times by doubled coordinates.
#[inline(always)]
fn eightfold_area(outline: &Outline, four: [usize; 4]) -> i64 {
    let mut sum = 0;
    for k in 0..4 {
        let ([ax, ay], [bx, by]) = (outline.point(four[k]), outline.point(four[(k + 1) % 4]));
        sum += i64::from(ax) * i64::from(by) - i64::from(bx) * i64::from(ay);
    }
    sum.abs()
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

#[inline(always)]
fn farthest_from<T: Wide>(outline: &Outline, [x, y]: [i32; 2]) -> usize {
    let mut best = T::from(-1);
    for (index, (px, py)) in outline.xs.iter().zip(&outline.ys).enumerate() {
        let (dx, dy) = (T::from(px - x), T::from(py - y));
        best = best.max((dx * dx + dy * dy).packed(index));
    }
    unpacked(best).index
}

/// The points farthest to the left and to the right of the line from one point to another, as seen with y up.
#[inline(always)]
fn extremes_beside<T: Wide>(outline: &Outline, from: usize, to: usize) -> (Beside, Beside) {
    let ([ax, ay], [bx, by]) = (outline.point(from), outline.point(to));
    let (dx, dy) = (T::from(bx - ax), T::from(by - ay));
    let (mut left, mut right) = (T::from(0), T::from(0));
    for (index, (px, py)) in outline.xs.iter().zip(&outline.ys).enumerate() {
        let cross = dx * T::from(py - ay) - dy * T::from(px - ax);
        left = left.max(cross.packed(index));
        right = right.max((T::from(0) - cross).packed(index));
    }
    (unpacked(left), unpacked(right))
}

#[inline(always)]
fn unpacked<T: Wide>(packed: T) -> Beside {
    let packed: i64 = packed.into();
    Beside { distance: packed >> T::INDEX, index: (packed & ((1 << T::INDEX) - 1)) as usize }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outline of a convex quad, row by row, as a component would give it.
    fn outline_of(corners: [[f64; 2]; 4]) -> Outline {
        let mut outline = Outline::default();
        let (top, bottom) =
            corners.iter().fold((f64::MAX, f64::MIN), |(low, high), c| (low.min(c[1]), high.max(c[1])));
        let (mut right_xs, mut right_ys) = (Vec::new(), Vec::new());
        for y in top as i32..bottom as i32 {
            let middle = f64::from(y) + 0.5;
            let crossings = (0..4).filter_map(|k| {
                let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
                ((ay <= middle) != (by <= middle)).then(|| ax + (middle - ay) / (by - ay) * (bx - ax))
            });
            let (left, right) =
                crossings.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            if left > right {
                continue;
            }
            outline.xs.push(2 * left.round() as i32);
            outline.ys.push(2 * y + 1);
            right_xs.push(2 * right.round() as i32);
            right_ys.push(2 * y + 1);
            outline.area += (right.round() - left.round()) as f32;
        }
        outline.xs.extend(right_xs);
        outline.ys.extend(right_ys);
        let xs = || outline.xs.iter().copied();
        let (left, right) = (xs().min().unwrap(), xs().max().unwrap());
        outline.middle = [(left + right) / 2, (top + bottom) as i32];
        outline.size = [(right - left) as usize / 2, (bottom - top) as usize];
        outline
    }

    #[test]
    fn the_corners_of_wide_quads_with_parallel_sides_are_found() {
        // As in a hand-held video where a point in the middle of the far side was taken for its corner: all points of a side
        // that is parallel to the line of the two farthest ones are equally far from it, but for rounding.
        for step in 0..400 {
            let (slope, shift) = (0.06 + 0.0001 * f64::from(step), f64::from(step % 7) / 7.0);
            let on_line = |x: f64, y: f64| [x, y + shift + slope * (x - 172.0)];
            let corners =
                [on_line(216.0, 245.0), on_line(422.0, 245.0), on_line(442.0, 350.5), on_line(172.0, 350.5)];
            let outline = outline_of(corners);
            let four = extreme_points(&outline).unwrap();
            for [x, y] in corners {
                let distance = |index: &usize| {
                    let [px, py] = outline.point(*index).map(|v| f64::from(v) * 0.5);
                    (px - x).hypot(py - y)
                };
                let nearest = four.iter().map(distance).fold(f64::MAX, f64::min);
                // The end of a flat side lies within one row's run of it.
                assert!(
                    nearest < 1.0 / slope,
                    "step {step}: no point near {x}, {y} in {:?}",
                    four.map(|i| outline.point(i))
                );
            }
        }
    }

    #[test]
    fn small_outlines_have_the_same_corners_in_short_numbers() {
        let (mut found, mut state) = (0, 7_u64);
        for _ in 0..4000 {
            let mut up_to = |most: u64| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) % most
            };
            let (width, height) = (1 + up_to(124), 1 + up_to(2));
            let [width, height] = if up_to(2) == 0 { [width, height] } else { [height, width] };
            let [left, top] = [up_to(16_000), up_to(16_000)].map(|v| v as f64);
            let [w, h] = [width, height].map(|v| v as f64 + 0.6);
            let mut share = || up_to(1000) as f64 / 1000.0;
            let corners = [
                [left + w * share(), top],
                [left + w, top + h * share()],
                [left + w * share(), top + h],
                [left, top + h * share()],
            ];
            let outline = outline_of(corners);
            if outline.xs.len() < 2 {
                continue;
            }
            assert!(outline.size[0] + outline.size[1] < SMALL, "{corners:?}");
            let four = extreme_points_in::<i64>(&outline);
            assert_eq!(extreme_points_in::<i32>(&outline), four, "{corners:?}");
            found += usize::from(four.is_some());
        }
        assert!(found > 1000, "only {found} outlines had corners");
    }
}
