//! The contour of a small component, edge by edge in order: where a side has only a few rows, the arcs between corners
//! are fitted and split again where their lines meet.

use super::edge::Edges;
use super::line::{Line, Moments, lines};
use super::rules;
use crate::binarize::raster::Raster;
use crate::cluster::Profile;

/// Edge points of a contour, clockwise from the top left.
#[derive(Default)]
pub(super) struct Contour {
    xs: Vec<f32>,
    ys: Vec<f32>,
    /// Sums over the points before each; one entry more than points.
    before: Vec<Moments>,
    /// The point nearest to the left end of each row, then to the right end.
    of_row: [Vec<usize>; 2],
    /// Places that were looked at.
    looked: usize,
}

impl Contour {
    /// Makes room for any contour that is walked: an outline of few rows that was not found ragged.
    pub(super) fn reserve(&mut self) {
        let most = rules::longest_outline(rules::CONTOUR_BELOW, 0) as usize + 1;
        for list in [&mut self.xs, &mut self.ys] {
            list.reserve(most.saturating_sub(list.len()));
        }
        self.before.reserve((most + 1).saturating_sub(self.before.len()));
        for of_row in &mut self.of_row {
            of_row.reserve(rules::CONTOUR_BELOW.saturating_sub(of_row.len()));
        }
    }

    /// Walks around the outline: along the top, down the right ends, along the bottom, up the left ends.
    #[inline(always)]
    pub(super) fn fill<R: Raster>(&mut self, edges: &Edges<R>, profile: &Profile) {
        let rows = profile.spans.len();
        self.clear(rows);
        let span = |row: usize| [usize::from(profile.spans[row][0]), usize::from(profile.spans[row][1])];
        let y_of = |row: usize| profile.top + row;
        for x in span(0)[0]..span(0)[1] {
            self.look(edges, [x, y_of(0)], [x, y_of(0).wrapping_sub(1)]);
        }
        for row in 0..rows {
            let (y, right) = (y_of(row), span(row)[1]);
            self.look(edges, [right - 1, y], [right, y]);
            self.of_row[1][row] = self.last_point();
            if row + 1 < rows {
                let next = span(row + 1)[1];
                // Loops, since closures would be compiled without the level's instructions.
                for x in right..next {
                    self.look(edges, [x, y + 1], [x, y]);
                }
                for x in (next..right).rev() {
                    self.look(edges, [x, y], [x, y + 1]);
                }
            }
        }
        for x in (span(rows - 1)[0]..span(rows - 1)[1]).rev() {
            self.look(edges, [x, y_of(rows - 1)], [x, y_of(rows)]);
        }
        for row in (0..rows).rev() {
            let (y, left) = (y_of(row), span(row)[0]);
            self.look(edges, [left, y], [left.wrapping_sub(1), y]);
            self.of_row[0][row] = self.last_point();
            if row > 0 {
                let above = span(row - 1)[0];
                for x in (above..left).rev() {
                    self.look(edges, [x, y - 1], [x, y]);
                }
                for x in left..above {
                    self.look(edges, [x, y], [x, y - 1]);
                }
            }
        }
    }

    fn clear(&mut self, rows: usize) {
        self.xs.clear();
        self.ys.clear();
        self.before.clear();
        self.before.push(Moments::default());
        self.looked = 0;
        for of_row in &mut self.of_row {
            of_row.resize(rows, 0);
        }
    }

    fn last_point(&self) -> usize {
        self.xs.len().saturating_sub(1)
    }

    #[inline(always)]
    fn look<R: Raster>(&mut self, edges: &Edges<R>, inner: [usize; 2], outer: [usize; 2]) {
        self.looked += 1;
        if let Some(point) = edges.between(inner, outer) {
            self.xs.push(point.x);
            self.ys.push(point.y);
            let mut sums = self.before[self.before.len() - 1];
            sums.add(f64::from(point.x), f64::from(point.y), f64::from(point.weight));
            self.before.push(sums);
        }
    }

    /// The sums of the points from `first` up to but not including `end`, around the contour.
    #[inline(always)]
    fn moments(&self, first: usize, end: usize) -> Moments {
        let count = self.xs.len();
        let (first, end) = (first % count, end % count);
        let wrapped = if end <= first { self.before[count] } else { Moments::default() };
        self.before[end].since(&self.before[first], &wrapped)
    }

    /// The corners, from outline points that lie near them (`four`, as indices of the outline's points).
    #[inline(always)]
    pub(super) fn corners(&self, four: [usize; 4], rows: usize) -> Option<[[f64; 2]; 4]> {
        let count = self.xs.len();
        if count < rules::LEAST_CONTOUR || (count as f32) < rules::EDGE_SHARE_OF_CONTOUR * self.looked as f32
        {
            return None;
        }
        let mut splits =
            four.map(|index| if index < rows { self.of_row[0][index] } else { self.of_row[1][index - rows] });
        splits.sort_unstable();
        for round in 1..=rules::ROUNDS {
            let lines = self.arc_lines(&splits)?;
            let mut corners = [[0.0; 2]; 4];
            for k in 0..4 {
                corners[k] = lines[(k + 3) % 4].meet(&lines[k])?;
            }
            let before = splits;
            if round < rules::ROUNDS {
                splits = self.nearest_points(&before, &corners);
            }
            if splits == before {
                return lines_are_straight(&lines, &corners).then_some(corners);
            }
        }
        None
    }

    /// The lines of the four arcs between `splits`, without the arcs' ends.
    #[inline(always)]
    fn arc_lines(&self, splits: &[usize; 4]) -> Option<[Line; 4]> {
        let count = self.xs.len();
        let mut moments = [Moments::default(); 4];
        for k in 0..4 {
            let (first, mut last) = (splits[k], splits[(k + 1) % 4]);
            if last <= first {
                last += count;
            }
            let length = last - first;
            if length < 4 {
                return None;
            }
            let end = if length < 8 { length.min(6) / 4 } else { (length / 10).max(1) };
            moments[k] = self.moments(first + end, last - end + 1);
        }
        Some(lines(&moments))
    }

    /// For each corner the contour point nearest to it, between the middles of the arcs that meet there.
    #[inline(always)]
    fn nearest_points(&self, splits: &[usize; 4], corners: &[[f64; 2]; 4]) -> [usize; 4] {
        let count = self.xs.len();
        std::array::from_fn(|k| {
            let (before, mut here, mut after) = (splits[(k + 3) % 4], splits[k], splits[(k + 1) % 4]);
            if here <= before {
                here += count;
            }
            while after <= here {
                after += count;
            }
            self.nearest_point((before + here) / 2, (here + after) / 2, corners[k])
        })
    }

    /// The point nearest to a corner from `first` to `last`, which may run on around the contour.
    #[inline(always)]
    fn nearest_point(&self, first: usize, last: usize, corner: [f64; 2]) -> usize {
        let count = self.xs.len();
        let (x, y) = (corner[0] as f32, corner[1] as f32);
        // Distances are not negative, so that their bits are in their order; the step says which of equal ones is the first.
        let mut nearest = u64::MAX;
        let mut index = first;
        for step in 0..=last - first {
            index = if index >= count { index - count } else { index };
            let (dx, dy) = (self.xs[index] - x, self.ys[index] - y);
            nearest = nearest.min(u64::from((dx * dx + dy * dy).to_bits()) << 32 | step as u64);
            index += 1;
        }
        (first + (nearest & u64::from(u32::MAX)) as usize) % count
    }
}

fn lines_are_straight(lines: &[Line; 4], corners: &[[f64; 2]; 4]) -> bool {
    (0..4).all(|k| {
        let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
        let (dx, dy) = (bx - ax, by - ay);
        lines[k].error as f32 <= rules::side_error((dx * dx + dy * dy).sqrt() as f32)
    })
}
