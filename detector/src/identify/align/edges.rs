//! Which pixels of a tag say where it lies: those across the edges between black and white cells.
//!
//! A grid line is straight in the picture, so the edges on it are followed row by row where they are steep and column by
//! column where they are flat, and the four pixels nearest to the edge are taken. Large tags have far more than are needed:
//! there every so many rows are left out.

use super::super::homography::Homography;
use super::super::sample::Frame;
use super::pattern::Pattern;

/// Rows or columns whose pixels across an edge are taken, over all edges. More hardly help the corners.
const MOST_PROFILES: f64 = 400.0;
/// Pixels on each side of an edge.
pub(super) const HALF_PROFILE: usize = 2;
/// More pixels than this are not collected; rounding may give one row more than is wanted.
pub(super) const MOST_PLACES: usize = (MOST_PROFILES as usize + 1) * 2 * HALF_PROFILE;

/// A stretch of a grid line along which black and white meet, in pixels of the frame.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    from: [f64; 2],
    to: [f64; 2],
    /// 0 where u is the same all along it, 1 where v is.
    pub(super) axis: usize,
    /// That coordinate, in cells from the border edge.
    pub(super) line: f64,
    /// 1 where white lies behind the line, -1 where black does.
    pub(super) sign: i8,
}

/// Rows (or columns) whose pixel centres a stretch crosses.
struct Crossed {
    /// The axis that it mainly follows, and the other one.
    along: usize,
    across: usize,
    first: usize,
    count: usize,
}

impl Stretch {
    #[inline(always)]
    fn crossed(&self, size: [usize; 2]) -> Crossed {
        let run = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let along = usize::from(run[1].abs() >= run[0].abs());
        let (low, high) = (self.from[along].min(self.to[along]), self.from[along].max(self.to[along]));
        let whole = |place: f64| ((place - 0.5).ceil().max(0.0) as usize).min(size[along]);
        let first = whole(low);
        Crossed { along, across: 1 - along, first, count: whole(high) - first }
    }

    /// Without so many pixels at both ends; `None` when nothing is left.
    #[inline(always)]
    pub(super) fn without_ends(&self, end: f64) -> Option<Self> {
        let run = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let length = (run[0] * run[0] + run[1] * run[1]).sqrt();
        if length <= 2.0 * end {
            return None;
        }
        let off = [run[0] * end / length, run[1] * end / length];
        let from = [self.from[0] + off[0], self.from[1] + off[1]];
        Some(Self { from, to: [self.to[0] - off[0], self.to[1] - off[1]], ..*self })
    }

    /// Gives the first pixel of every `spacing`-th profile across it, and the step from that to the next. `next` is how far
    /// away the first one is, and afterwards the first one behind this stretch.
    #[inline(always)]
    pub(super) fn visit(
        &self,
        size: [usize; 2],
        spacing: f64,
        next: &mut f64,
        mut visit: impl FnMut([usize; 2], [usize; 2]),
    ) {
        let crossed = self.crossed(size);
        let across = Across::new(self, &crossed, size);
        while *next < crossed.count as f64 {
            let along = crossed.first + *next as usize;
            *next += spacing;
            let Some(first) = across.first(along) else { continue };
            if crossed.along == 1 { visit([first, along], [1, 0]) } else { visit([along, first], [0, 1]) }
        }
        *next -= crossed.count as f64;
    }
}

/// Every which profile is taken so that there are not too many, once stretches are without their ends.
#[inline(always)]
pub(super) fn spacing(stretches: &[Stretch], end: f64, size: [usize; 2]) -> f64 {
    let mut total = 0;
    for stretch in stretches {
        if let Some(inner) = stretch.without_ends(end) {
            total += inner.crossed(size).count;
        }
    }
    (total as f64 / MOST_PROFILES).max(1.0)
}

/// All stretches of a tag's pattern. `to_frame` maps cells to the frame.
#[inline(always)]
pub(super) fn find(pattern: &Pattern, to_frame: &Homography, stretches: &mut Vec<Stretch>) {
    stretches.clear();
    let width = pattern.width();
    for axis in 0..2 {
        for line in 1..width {
            // Cells before and behind the line, and points on it.
            let cell = |line: usize, i: usize| if axis == 0 { [line, i] } else { [i, line] };
            let point = |i: usize| {
                let [x, y] = cell(line, i);
                to_frame.project([x as f64 - pattern.margin(), y as f64 - pattern.margin()])
            };
            let (mut start, mut sign) = (0, 0);
            for i in 0..width {
                let step = pattern.step(cell(line - 1, i), cell(line, i));
                if step == sign {
                    continue;
                }
                if sign != 0 {
                    let line = line as f64 - pattern.margin();
                    stretches.push(Stretch { from: point(start), to: point(i), axis, line, sign });
                }
                (start, sign) = (i, step);
            }
        }
    }
}

/// A pixel's column and row.
pub(super) type Place = [u32; 2];

/// Collects the pixels across all stretches, each once.
#[inline(always)]
pub(super) fn collect(frame: &Frame, stretches: &[Stretch], sieve: &mut Sieve, places: &mut Vec<Place>) {
    let size = frame.size();
    let spacing = spacing(stretches, 0.0, size);
    let mut next = 0.0;
    places.clear();
    sieve.clear();
    for stretch in stretches {
        stretch.visit(size, spacing, &mut next, |[column, row], step| {
            for i in 0..2 * HALF_PROFILE {
                let (column, row) = (column + i * step[0], row + i * step[1]);
                if sieve.is_new(column, row) {
                    places.push([column as u32, row as u32]);
                }
            }
        });
    }
}

/// Where a stretch lies in the rows (columns) that it crosses.
struct Across {
    at_zero: f64,
    slope: f64,
    /// Pixels a row.
    size: f64,
}

impl Across {
    #[inline(always)]
    fn new(stretch: &Stretch, crossed: &Crossed, size: [usize; 2]) -> Self {
        let Crossed { along: a, across: b, .. } = *crossed;
        let slope = (stretch.to[b] - stretch.from[b]) / (stretch.to[a] - stretch.from[a]);
        let at_zero = stretch.from[b] + slope * (0.5 - stretch.from[a]) - 0.5 - (HALF_PROFILE - 1) as f64;
        Self { at_zero, slope, size: size[b] as f64 }
    }

    /// The first pixel across it in a row; `None` where the frame ends.
    #[inline(always)]
    fn first(&self, along: usize) -> Option<usize> {
        let first = self.at_zero + self.slope * along as f64;
        let fits = first >= 0.0 && first + 2.0 * HALF_PROFILE as f64 <= self.size;
        fits.then_some(first as usize)
    }
}

/// Which pixels were taken. Exact for tags of up to 256 pixels; of larger ones about one pixel of a hundred is lost.
#[derive(Default)]
pub(super) struct Sieve(Vec<u64>);

impl Sieve {
    const SIDE: usize = 256;

    pub(super) fn clear(&mut self) {
        self.0.clear();
        self.0.resize(Self::SIDE * Self::SIDE / 64, 0);
    }

    /// Takes a pixel.
    #[inline(always)]
    fn is_new(&mut self, column: usize, row: usize) -> bool {
        let bit = row % Self::SIDE * Self::SIDE + column % Self::SIDE;
        let word = &mut self.0[bit / 64];
        let is_new = *word >> (bit % 64) & 1 == 0;
        *word |= 1 << (bit % 64);
        is_new
    }
}
