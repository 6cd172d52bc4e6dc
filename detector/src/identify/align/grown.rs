//! The cells around pixels as the blur mixes them once white has grown or ink has spread.
//!
//! Along one axis a row of cells is a sum of steps, one at each line between two cells whose colours differ, and the blur
//! makes each step a normal distribution. Both axes after each other give the blurred pattern. Steps lie where white's edges
//! have moved to.

use super::blur::normal;
use super::model::Coordinate;
use super::pattern::{MOST_CELLS, colour, joined};
use super::pixels::{BLOCK, Lanes, ZERO};
use super::window::Blurred;

/// The blurred step at each line between the cells of a window, along one axis. Line `k` lies between cells `k - 1` and `k`;
/// there is none before the first cell. Where white has grown, lines from black to white lie earlier and lines from white to
/// black later.
#[repr(align(64))]
pub(super) struct Steps<const WINDOW: usize> {
    /// The mean of both.
    mean: [Step; WINDOW],
    /// Half of what the earlier one is ahead.
    ahead: [Step; WINDOW],
}

/// A blurred step with its derivatives by the pixel's place and by the blur's logarithm.
#[derive(Clone, Copy)]
struct Step {
    share: Lanes,
    by_place: Lanes,
    by_blur: Lanes,
}

impl Step {
    const NONE: Self = Self { share: ZERO, by_place: ZERO, by_blur: ZERO };

    /// `within` is how far pixels lie behind the line, in cells; `inverse` is one over the blur, in cells.
    #[inline(always)]
    fn new(within: &Lanes, inverse: &Lanes) -> Self {
        let mut step = Self::NONE;
        for l in 0..BLOCK {
            let z = within[l] * inverse[l];
            let (share, density) = normal(z);
            step.share[l] = share;
            step.by_place[l] = density * inverse[l];
            step.by_blur[l] = -z * density;
        }
        step
    }

    /// Half the sum and half the difference of two steps.
    #[inline(always)]
    fn halves(&self, other: &Self) -> (Self, Self) {
        let (mut mean, mut ahead) = (Self::NONE, Self::NONE);
        for l in 0..BLOCK {
            mean.share[l] = 0.5 * (self.share[l] + other.share[l]);
            mean.by_place[l] = 0.5 * (self.by_place[l] + other.by_place[l]);
            mean.by_blur[l] = 0.5 * (self.by_blur[l] + other.by_blur[l]);
            ahead.share[l] = 0.5 * (self.share[l] - other.share[l]);
            ahead.by_place[l] = 0.5 * (self.by_place[l] - other.by_place[l]);
            ahead.by_blur[l] = 0.5 * (self.by_blur[l] - other.by_blur[l]);
        }
        (mean, ahead)
    }
}

/// White cannot take more than this of a black cell on each side, nor black of a white one.
pub(super) const MOST_GROWTH: f32 = 0.45;

impl<const WINDOW: usize> Steps<WINDOW> {
    /// `first` are the windows' first cells, `sigma` is the blur and `bloom` the growth of white in units of the patch.
    #[inline(always)]
    pub(super) fn new(coordinate: &Coordinate, first: &Lanes, sigma: f32, bloom: f32) -> Self {
        let mut steps = Self { mean: [Step::NONE; WINDOW], ahead: [Step::NONE; WINDOW] };
        let (mut inverse, mut growth) = (ZERO, ZERO);
        for l in 0..BLOCK {
            inverse[l] = 1.0 / (sigma * coordinate.speed[l]);
            growth[l] = (bloom * coordinate.speed[l]).clamp(-MOST_GROWTH, MOST_GROWTH);
        }
        let (mut rising, mut falling) = (ZERO, ZERO);
        for k in 1..WINDOW {
            for l in 0..BLOCK {
                let within = coordinate.place[l] - first[l] - k as f32;
                rising[l] = within + growth[l];
                falling[l] = within - growth[l];
            }
            let (rising, falling) = (Step::new(&rising, &inverse), Step::new(&falling, &inverse));
            (steps.mean[k], steps.ahead[k]) = rising.halves(&falling);
        }
        steps
    }
}

/// One row of cells, blurred along it: its brightness and how that changes.
struct Row {
    value: Lanes,
    by_place: Lanes,
    by_blur: Lanes,
    by_growth: Lanes,
}

impl Blurred {
    /// Around pixels with steps along both axes. `grows` tells whether white has grown or black.
    ///
    /// Growing along one axis and then along the other makes squares of corners, as ink does. From one row to the next white
    /// begins where neither was white before: what both rows together show, grown, less what the first one shows.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "rows and steps have the same number")]
    pub(super) fn grown<const WINDOW: usize>(
        rows: &[[u32; BLOCK]; MOST_CELLS],
        along_u: &Steps<WINDOW>,
        along_v: &Steps<WINDOW>,
        grows: bool,
    ) -> Self {
        let mut before = Row::new(&rows[0], along_u);
        let mut t = Self {
            value: before.value,
            by_u: before.by_place,
            by_v: ZERO,
            by_blur_u: before.by_blur,
            by_blur_v: ZERO,
            by_growth_u: before.by_growth,
            by_growth_v: ZERO,
        };
        for j in 1..WINDOW {
            let row = Row::new(&rows[j], along_u);
            let both = Row::new(&both_rows(&rows[j - 1], &rows[j], grows), along_u);
            let (p, q) = (&along_v.mean[j], &along_v.ahead[j]);
            let sign = if grows { 1.0 } else { -1.0 };
            for l in 0..BLOCK {
                // What changes from row to row, and how much of the rows' edge moves.
                let change = row.value[l] - before.value[l];
                let moves = sign * (2.0 * both.value[l] - before.value[l] - row.value[l]);
                t.value[l] += change * p.share[l] + moves * q.share[l];
                t.by_v[l] += change * p.by_place[l] + moves * q.by_place[l];
                t.by_blur_v[l] += change * p.by_blur[l] + moves * q.by_blur[l];
                t.by_growth_v[l] += moves * p.by_place[l] + change * q.by_place[l];
                let change = row.by_place[l] - before.by_place[l];
                let moves = sign * (2.0 * both.by_place[l] - before.by_place[l] - row.by_place[l]);
                t.by_u[l] += change * p.share[l] + moves * q.share[l];
                let change = row.by_blur[l] - before.by_blur[l];
                let moves = sign * (2.0 * both.by_blur[l] - before.by_blur[l] - row.by_blur[l]);
                t.by_blur_u[l] += change * p.share[l] + moves * q.share[l];
                let change = row.by_growth[l] - before.by_growth[l];
                let moves = sign * (2.0 * both.by_growth[l] - before.by_growth[l] - row.by_growth[l]);
                t.by_growth_u[l] += change * p.share[l] + moves * q.share[l];
            }
            before = row;
        }
        t
    }
}

/// Two rows as one: white in either when white grows, in both when black does.
#[inline(always)]
fn both_rows(a: &[u32; BLOCK], b: &[u32; BLOCK], grows: bool) -> [u32; BLOCK] {
    let mut words = [0; BLOCK];
    for l in 0..BLOCK {
        words[l] = joined(a[l], b[l], grows);
    }
    words
}

impl Row {
    /// Edges of cells of unknown colour stay where they are whatever grows: it is not known what grows there.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn new<const WINDOW: usize>(words: &[u32; BLOCK], along: &Steps<WINDOW>) -> Self {
        let mut row = Self { value: ZERO, by_place: ZERO, by_blur: ZERO, by_growth: ZERO };
        for l in 0..BLOCK {
            row.value[l] = 0.25 * colour(words[l], 0) as f32;
        }
        for k in 1..WINDOW {
            let (p, q) = (&along.mean[k], &along.ahead[k]);
            for l in 0..BLOCK {
                // Colours are given as four times their brightness; only from black to white and back it changes by all four.
                let code = colour(words[l], k) - colour(words[l], k - 1);
                let (change, moves) = (0.25 * code as f32, ((code * code) >> 4) as f32);
                row.value[l] += change * p.share[l] + moves * q.share[l];
                row.by_place[l] += change * p.by_place[l] + moves * q.by_place[l];
                row.by_blur[l] += change * p.by_blur[l] + moves * q.by_blur[l];
                row.by_growth[l] += moves * p.by_place[l] + change * q.by_place[l];
            }
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use tagbus_family::Family;

    use super::super::super::reader::Reader;
    use super::super::pattern::Pattern;
    use super::*;

    const SIGMA: f32 = 0.4;

    /// The pattern's brightness at points of the middle of a window of the most cells, by the model.
    fn modelled(pattern: &Pattern, first: [usize; 2], bloom: f32) -> (Lanes, Lanes, Lanes) {
        let mut rows = [[0; BLOCK]; MOST_CELLS];
        let (mut u, mut v) = (ZERO, ZERO);
        for l in 0..BLOCK {
            u[l] = first[0] as f32 + 1.9 + (l % 8) as f32 * 0.15;
            v[l] = first[1] as f32 + 2.0 + (l / 8) as f32 * 0.25;
            for (j, row) in rows.iter_mut().enumerate() {
                row[l] = pattern.word(first[0], first[1] + j);
            }
        }
        let steps = |place: Lanes, first: usize| {
            let coordinate = Coordinate::at_unit_speed(place);
            Steps::<MOST_CELLS>::new(&coordinate, &[first as f32; BLOCK], SIGMA, bloom)
        };
        let (along_u, along_v) = (steps(u, first[0]), steps(v, first[1]));
        (Blurred::grown(&rows, &along_u, &along_v, bloom > 0.0).value, u, v)
    }

    /// The same by summing over small parts, each white or black as the cells within the growth are.
    fn summed(pattern: &Pattern, [u, v]: [f32; 2], first: [usize; 2], bloom: f32) -> f32 {
        const PARTS: i32 = 20;
        let is_white = |x: f32, y: f32| {
            let inside = |place: f32, first: usize| (place as usize).clamp(first, first + MOST_CELLS - 1);
            colour(pattern.word(inside(x, first[0]), inside(y, first[1])), 0) == 4
        };
        let (mut sum, mut total) = (0.0, 0.0);
        for i in -2 * PARTS..2 * PARTS {
            for j in -2 * PARTS..2 * PARTS {
                let [dx, dy] = [i, j].map(|k| (k as f32 + 0.5) / PARTS as f32);
                let mut near = [-bloom, bloom]
                    .into_iter()
                    .flat_map(|a| [-bloom, bloom].map(|b| is_white(u + dx + a, v + dy + b)));
                let white = if bloom > 0.0 { near.any(|white| white) } else { near.all(|white| white) };
                let weight = (-(dx * dx + dy * dy) / (2.0 * SIGMA * SIGMA)).exp();
                sum += if white { weight } else { 0.0 };
                total += weight;
            }
        }
        sum / total
    }

    #[test]
    fn grown_white_and_spread_ink_are_blurred_where_their_edges_have_moved_to() {
        let family = Family::published("tag36h11").unwrap();
        let reader = Reader::new(0, &family, None, &[]);
        let mut pattern = Pattern::default();
        pattern.paint(&reader, family.codes()[3]);
        let middle = pattern.width() / 2;
        for (bloom, first) in [0.3, -0.3].into_iter().flat_map(|b| (0..4).map(move |k| (b, k))) {
            let first = [middle - 4 + first, middle - 3];
            let (values, u, v) = modelled(&pattern, first, bloom);
            for l in 0..BLOCK {
                let expected = summed(&pattern, [u[l], v[l]], first, bloom);
                assert!(
                    (values[l] - expected).abs() < 0.01,
                    "bloom {bloom} at {}, {}: {}, not {expected}",
                    u[l],
                    v[l],
                    values[l]
                );
            }
        }
    }
}
