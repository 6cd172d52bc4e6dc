//! The cells around pixels as the blur mixes them.
//!
//! Along one axis a row of cells is a sum of steps, one at each line between two cells whose colours differ, and the blur
//! makes each step a normal distribution. Both axes after each other give the blurred pattern.

use super::blur::normal;
use super::model::Coordinate;
use super::pattern::{MOST_CELLS, colour};
use super::pixels::{BLOCK, Lanes, ZERO};

/// The blurred step at each line between the cells of a window, along one axis, with its derivatives by the pixel's place
/// and by the blur's logarithm. Line `k` lies between cells `k - 1` and `k`; there is none before the first cell.
pub(super) struct Steps<const WINDOW: usize> {
    share: [Lanes; WINDOW],
    by_place: [Lanes; WINDOW],
    by_blur: [Lanes; WINDOW],
}

impl<const WINDOW: usize> Steps<WINDOW> {
    /// `first` are the windows' first cells, `sigma` is the blur in units of the patch.
    #[inline(always)]
    pub(super) fn new(coordinate: &Coordinate, first: &Lanes, sigma: f32) -> Self {
        let mut steps = Self { share: [ZERO; WINDOW], by_place: [ZERO; WINDOW], by_blur: [ZERO; WINDOW] };
        let (mut within, mut inverse) = (ZERO, ZERO);
        for l in 0..BLOCK {
            within[l] = coordinate.place[l] - first[l];
            inverse[l] = 1.0 / (sigma * coordinate.speed[l]);
        }
        for k in 1..WINDOW {
            for l in 0..BLOCK {
                let z = (within[l] - k as f32) * inverse[l];
                let (share, density) = normal(z);
                steps.share[k][l] = share;
                steps.by_place[k][l] = density * inverse[l];
                steps.by_blur[k][l] = -z * density;
            }
        }
        steps
    }
}

/// The blurred pattern with its derivatives by place and by the blur's logarithms.
pub(super) struct Blurred {
    pub(super) value: Lanes,
    pub(super) by_u: Lanes,
    pub(super) by_v: Lanes,
    pub(super) by_blur_u: Lanes,
    pub(super) by_blur_v: Lanes,
    /// How much brighter it gets when every edge across u (v) moves away from its white side by a cell: what an edge gives
    /// does not depend on which side is white.
    pub(super) edges_u: Lanes,
    pub(super) edges_v: Lanes,
}

/// The same of one row of cells, blurred along it.
struct Row {
    value: Lanes,
    by_place: Lanes,
    by_blur: Lanes,
    edges: Lanes,
}

impl Blurred {
    /// Cells outside of the windows have the colours of the outermost ones inside.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "rows and steps have the same number")]
    pub(super) fn new<const WINDOW: usize>(
        rows: &[[u32; BLOCK]; MOST_CELLS],
        along_u: &Steps<WINDOW>,
        along_v: &Steps<WINDOW>,
    ) -> Self {
        let mut before = Row::new(&rows[0], along_u);
        let mut t = Self {
            value: before.value,
            by_u: before.by_place,
            by_v: ZERO,
            by_blur_u: before.by_blur,
            by_blur_v: ZERO,
            edges_u: before.edges,
            edges_v: ZERO,
        };
        for j in 1..WINDOW {
            let row = Row::new(&rows[j], along_u);
            let (share, by_place, by_blur) = (&along_v.share[j], &along_v.by_place[j], &along_v.by_blur[j]);
            for l in 0..BLOCK {
                let change = row.value[l] - before.value[l];
                t.value[l] += change * share[l];
                t.by_v[l] += change * by_place[l];
                t.by_blur_v[l] += change * by_blur[l];
                t.edges_v[l] += change.abs() * by_place[l];
                t.by_u[l] += (row.by_place[l] - before.by_place[l]) * share[l];
                t.by_blur_u[l] += (row.by_blur[l] - before.by_blur[l]) * share[l];
                t.edges_u[l] += (row.edges[l] - before.edges[l]) * share[l];
            }
            before = row;
        }
        t
    }
}

impl Row {
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn new<const WINDOW: usize>(words: &[u32; BLOCK], along: &Steps<WINDOW>) -> Self {
        let mut row = Self { value: ZERO, by_place: ZERO, by_blur: ZERO, edges: ZERO };
        for l in 0..BLOCK {
            row.value[l] = 0.5 * colour(words[l], 0) as f32;
        }
        for k in 1..WINDOW {
            for l in 0..BLOCK {
                // Colours are given as twice their brightness.
                let change = 0.5 * (colour(words[l], k) - colour(words[l], k - 1)) as f32;
                row.value[l] += change * along.share[k][l];
                row.by_place[l] += change * along.by_place[k][l];
                row.by_blur[l] += change * along.by_blur[k][l];
                row.edges[l] += change.abs() * along.by_place[k][l];
            }
        }
        row
    }
}
