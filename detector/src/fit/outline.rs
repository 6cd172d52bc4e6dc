//! The outline of a component as points, and what can be refused by looking at these alone.

use super::rules;
use crate::cluster::{Component, Profile};

/// The ends of each row of a component, in doubled coordinates so that half pixels are whole numbers.
#[derive(Default)]
pub(super) struct Outline {
    /// First the left ends of all rows, then the right ends.
    pub(super) xs: Vec<i32>,
    pub(super) ys: Vec<i32>,
    /// Middle of the box, doubled.
    pub(super) middle: [i32; 2],
    /// Pixels inside the outline.
    pub(super) area: f32,
    /// Columns and rows of the box.
    pub(super) size: [usize; 2],
}

/// Whether the outline is much longer than a convex one of its box would be: longer than this factor of what is borne.
#[inline(always)]
pub(super) fn is_ragged(profile: &Profile, component: &Component, factor: f32) -> bool {
    let spans = profile.spans;
    let width = |span: &[u16; 2]| i32::from(span[1]) - i32::from(span[0]);
    let mut length = 2 * spans.len() as i32;
    for (above, below) in spans.iter().zip(&spans[1..]) {
        length += i32::from(above[0].abs_diff(below[0])) + i32::from(above[1].abs_diff(below[1]));
    }
    length += width(&spans[0]) + width(&spans[spans.len() - 1]);
    length as f32 > factor * rules::longest_outline(component.width(), component.height())
}

impl Outline {
    /// Makes room for the outline of so many rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        for list in [&mut self.xs, &mut self.ys] {
            list.reserve((2 * rows).saturating_sub(list.len()));
        }
    }

    /// Takes the outline of a component. The first and last row contribute their outer edge, the others their middle.
    #[inline(always)]
    pub(super) fn fill(&mut self, profile: &Profile, component: &Component) {
        let rows = profile.spans.len();
        self.xs.resize(2 * rows, 0);
        self.ys.resize(2 * rows, 0);
        let (left, right) = self.xs.split_at_mut(rows);
        let (left_y, right_y) = self.ys.split_at_mut(rows);
        let mut area = 0;
        for (row, span) in profile.spans.iter().enumerate() {
            let y = 2 * (profile.top + row) as i32 + 1;
            (left[row], right[row]) = (2 * i32::from(span[0]), 2 * i32::from(span[1]));
            (left_y[row], right_y[row]) = (y, y);
            area += i32::from(span[1]) - i32::from(span[0]);
        }
        for ys in [left_y, right_y] {
            ys[0] -= 1;
            ys[rows - 1] += 1;
        }
        self.area = area as f32;
        self.size = [component.width(), component.height()];
        let doubled = |a: u16, b: u16| i32::from(a) + i32::from(b);
        self.middle =
            [doubled(component.left, component.right), doubled(component.top, component.bottom + 1)];
    }

    /// A point, doubled.
    #[inline(always)]
    pub(super) fn point(&self, index: usize) -> [i32; 2] {
        [self.xs[index], self.ys[index]]
    }

    /// The pixel of the component that a point is the outer edge of.
    #[inline(always)]
    pub(super) fn pixel(&self, index: usize) -> [usize; 2] {
        let rows = self.xs.len() / 2;
        let top = (self.middle[1] as usize - rows) / 2;
        let (right, row) = (index / rows, index % rows);
        [self.xs[index] as usize / 2 - right, top + row]
    }

    /// The middle of the box in pixels.
    pub(super) fn centre(&self) -> [f32; 2] {
        self.middle.map(|v| v as f32 * 0.5)
    }

    /// Four points in pixels from the centre, put in clockwise order.
    #[inline(always)]
    pub(super) fn clockwise(&self, four: [usize; 4]) -> [[f32; 2]; 4] {
        let mut corners = four.map(|index| {
            let [x, y] = self.point(index);
            [(x - self.middle[0]) as f32 * 0.5, (y - self.middle[1]) as f32 * 0.5]
        });
        if doubled_area(&corners) < 0.0 {
            corners.swap(1, 3);
        }
        corners
    }

    /// Mean distance of the outline's points from the nearest side of `corners`, in pixels.
    #[inline(always)]
    pub(super) fn mean_distance(&self, corners: &[[f32; 2]; 4]) -> f32 {
        const LANES: usize = 16;
        let sides: [[f32; 3]; 4] = std::array::from_fn(|k| inward_distance(corners[k], corners[(k + 1) % 4]));
        let distance = |x: i32, y: i32| {
            let (x, y) = ((x - self.middle[0]) as f32 * 0.5, (y - self.middle[1]) as f32 * 0.5);
            let to = |[a, b, c]: [f32; 3]| a * x + b * y + c;
            to(sides[0]).min(to(sides[1])).min(to(sides[2]).min(to(sides[3]))).abs()
        };
        // Lanes of their own keep the order of summation, and so the result, the same at every level.
        let mut sums = [0.0f32; LANES];
        let (xs, xs_rest) = self.xs.as_chunks::<LANES>();
        let (ys, ys_rest) = self.ys.as_chunks::<LANES>();
        for (xs, ys) in xs.iter().zip(ys) {
            for lane in 0..LANES {
                sums[lane] += distance(xs[lane], ys[lane]);
            }
        }
        for (lane, (x, y)) in xs_rest.iter().zip(ys_rest).enumerate() {
            sums[lane] += distance(*x, *y);
        }
        sums.iter().sum::<f32>() / self.xs.len() as f32
    }
}

/// Twice the area of a quad; positive when it is clockwise as seen (y points down).
#[inline(always)]
pub(super) fn doubled_area(corners: &[[f32; 2]; 4]) -> f32 {
    (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
            ax * by - bx * ay
        })
        .sum()
}

/// Coefficients a, b, c of the distance a x + b y + c from the line through two points, positive to its right as seen.
#[inline(always)]
fn inward_distance([ax, ay]: [f32; 2], [bx, by]: [f32; 2]) -> [f32; 3] {
    let (dx, dy) = (bx - ax, by - ay);
    let scale = 1.0 / (dx * dx + dy * dy).sqrt().max(1e-3);
    let (a, b) = (-dy * scale, dx * scale);
    [a, b, -(a * ax + b * ay)]
}
