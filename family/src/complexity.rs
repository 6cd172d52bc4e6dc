//! How much a tag differs from what nature puts into pictures: plain surfaces and straight edges look like tags of
//! low complexity, and families leave such codes out.

use crate::candidates::Candidates;
use crate::grid::{Grid, Paint};
use crate::layout::Layout;
use std::fmt;

/// A way to measure the complexity of a tag.
///
/// Source: "Flexible Layouts for Fiducial Tags", section III-B, which compares the first three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// [`ising_energy`]: the choice of the paper, used for tagCircle, tagCustom and tagStandard.
    Ising,
    /// [`tag_rectangle_count`]: the whole tag painted with rectangles.
    Rectangles,
    /// [`component_count`]: areas of one colour.
    Components,
    /// [`rectangle_count`] of the square of data bits alone, with at most 8 x 8 of them: the first AprilTag families.
    DataRectangles,
}

impl Metric {
    /// All of them.
    pub const ALL: [Metric; 4] =
        [Metric::Ising, Metric::Rectangles, Metric::Components, Metric::DataRectangles];

    /// `ising`, `rectangles`, `components` or `data-rectangles`.
    pub fn name(self) -> &'static str {
        match self {
            Metric::Ising => "ising",
            Metric::Rectangles => "rectangles",
            Metric::Components => "components",
            Metric::DataRectangles => "data-rectangles",
        }
    }

    /// The metric of this name.
    pub fn named(name: &str) -> Option<Metric> {
        Metric::ALL.into_iter().find(|metric| metric.name() == name)
    }

    /// The complexity of the tag with this code. Counting rectangles stops at `enough`, because each costs time; the
    /// other metrics are exact.
    pub fn of(self, layout: &Layout, code: u64, enough: u32) -> u32 {
        match self {
            Metric::Ising => ising_energy(&layout.draw(code)),
            Metric::Rectangles => tag_rectangle_count(&layout.draw(code), enough),
            Metric::Components => component_count(&layout.draw(code)),
            Metric::DataRectangles => rectangle_count(layout.to_row_major(code), layout.bit_count().isqrt()),
        }
    }

    /// The least complexity that codes are held to when nobody says otherwise.
    ///
    /// Ising: [`least_ising_energy`]. Rectangles and components, whose limits the paper does not tell: what lets
    /// pass as near as possible the same share of all codes. Rectangles of data: a third of the bits, at most 10.
    pub fn default_least(self, layout: &Layout) -> u32 {
        match self {
            Metric::Ising => least_ising_energy(layout.area()),
            Metric::DataRectangles => (layout.bit_count() / 3).min(10),
            Metric::Rectangles | Metric::Components => self.as_strict_as_ising(layout),
        }
    }

    fn as_strict_as_ising(self, layout: &Layout) -> u32 {
        let candidates = Candidates::new(layout.bit_count(), 0, 0);
        let sample = || (1..=STRICTNESS_SAMPLE).map(|number| candidates.code(number));
        let least = least_ising_energy(layout.area());
        let wanted = sample().filter(|&code| ising_energy(&layout.draw(code)) >= least).count();
        let mut measured: Vec<u32> = sample().map(|code| self.of(layout, code, u32::MAX)).collect();
        measured.sort_unstable_by_key(|&complexity| std::cmp::Reverse(complexity));
        let passing = |least: u32| measured.partition_point(|&complexity| complexity >= least);
        let most = measured.first().copied().unwrap_or(0);
        (0..=most).min_by_key(|&least| passing(least).abs_diff(wanted)).unwrap_or(0)
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// Codes by which two metrics are made equally strict.
const STRICTNESS_SAMPLE: u64 = 2000;

/// Which codes are complex enough for a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// How complexity is measured.
    pub metric: Metric,
    /// The least complexity that is allowed.
    pub least: u32,
}

impl Rule {
    /// Whether the tag with this code is complex enough.
    pub fn allows(&self, layout: &Layout, code: u64) -> bool {
        self.metric.of(layout, code, self.least) >= self.least
    }
}

/// The Ising energy of a tag: pairs of neighbouring cells (left and right, above and below) of which one is black and
/// the other white. Cells that are not part of the tag do not count.
///
/// Source: "Flexible Layouts for Fiducial Tags", section III-B; used for tagCircle, tagCustom and tagStandard.
pub fn ising_energy(grid: &Grid) -> u32 {
    let width = grid.width();
    let differ = |left: Paint, right: Paint| left != right && left != Paint::Clear && right != Paint::Clear;
    let across = |x: usize, y: usize| x + 1 < width && differ(grid.get(x, y), grid.get(x + 1, y));
    let down = |x: usize, y: usize| y + 1 < width && differ(grid.get(x, y), grid.get(x, y + 1));
    let cells = (0..width).flat_map(|y| (0..width).map(move |x| (x, y)));
    cells.map(|(x, y)| u32::from(across(x, y)) + u32::from(down(x, y))).sum()
}

/// The least Ising energy that the published families allow for a tag of `area` cells: a third of all pairs of
/// neighbours, of which there are about two a cell.
pub fn least_ising_energy(area: usize) -> u32 {
    // The rule is E >= 0.3333 * 2 * area, with the third rounded like this when the families were made.
    (area * 6666).div_ceil(10_000) as u32
}

/// The number of rectangles that a greedy painter needs for a square of bits: each time the one that sets most cells
/// right (those it spoils deducted), until all are. Used for the families of the first AprilTag releases.
///
/// Bit `y * width + x` of `square` is the cell in column `x` of row `y`. Which of equally good
/// rectangles is taken can matter, so the published families are reproduced only by scanning y, height, x, width and
/// black before white, with the least significant bit of the row-major code at the top left.
///
/// # Panics
/// When `width` is not 1 to 8.
pub fn rectangle_count(square: u64, width: u32) -> u32 {
    RectanglePainter::new(width).count(square, u32::MAX)
}

/// [`rectangle_count`] for many squares of one size.
pub(crate) struct RectanglePainter {
    rectangles: Vec<u64>,
    everything: u64,
}

impl RectanglePainter {
    pub(crate) fn new(width: u32) -> RectanglePainter {
        assert!((1..=8).contains(&width), "a square of {width} x {width} bits does not fit 64");
        RectanglePainter { rectangles: rectangles(width), everything: u64::MAX >> (64 - width * width) }
    }

    /// Stops at `enough`.
    pub(crate) fn count(&self, square: u64, enough: u32) -> u32 {
        // Which cells show the right colour already; at first they show none.
        let mut right = 0;
        let mut count = 0;
        while right != self.everything && count < enough {
            let (area, wanted) = self.best(square, right);
            right = right & !area | area & wanted;
            count += 1;
        }
        count
    }

    /// The rectangle that sets most cells right, and the cells that are right when it is painted.
    fn best(&self, square: u64, right: u64) -> (u64, u64) {
        let gain = |area: u64, wanted: u64| {
            (area & wanted & !right).count_ones() as i32 - (area & !wanted & right).count_ones() as i32
        };
        let mut best = (0, 0, 0);
        for &area in &self.rectangles {
            for wanted in [!square, square] {
                let gain = gain(area, wanted);
                if gain > best.0 {
                    best = (gain, area, wanted);
                }
            }
        }
        (best.1, best.2)
    }
}

/// The number of areas of one colour, neighbours being left and right, above and below. Cells that are not part of the
/// tag do not count.
pub fn component_count(grid: &Grid) -> u32 {
    let width = grid.width();
    let mut seen = vec![false; width * width];
    let mut count = 0;
    for start in 0..width * width {
        if !seen[start] && paint_at(grid, start) != Paint::Clear {
            count += 1;
            flood(grid, start, &mut seen);
        }
    }
    count
}

fn flood(grid: &Grid, start: usize, seen: &mut [bool]) {
    let mut open = vec![start];
    seen[start] = true;
    while let Some(cell) = open.pop() {
        for next in neighbours(cell, grid.width()).into_iter().flatten() {
            if !seen[next] && paint_at(grid, next) == paint_at(grid, start) {
                seen[next] = true;
                open.push(next);
            }
        }
    }
}

fn neighbours(cell: usize, width: usize) -> [Option<usize>; 4] {
    let (x, y) = (cell % width, cell / width);
    [
        (x > 0).then(|| cell - 1),
        (x + 1 < width).then(|| cell + 1),
        (y > 0).then(|| cell - width),
        (y + 1 < width).then(|| cell + width),
    ]
}

fn paint_at(grid: &Grid, cell: usize) -> Paint {
    grid.get(cell % grid.width(), cell / grid.width())
}

/// As [`rectangle_count`], for a whole tag: with cells that are not part of it, the smaller count of the tag with all
/// of them black and with all of them white. Stops counting at `enough`.
pub fn tag_rectangle_count(grid: &Grid, enough: u32) -> u32 {
    let cells = || (0..grid.width() * grid.width()).map(|cell| paint_at(grid, cell));
    let filled = |clear_is_white: bool| -> Vec<bool> {
        let white = |paint| paint == Paint::White || paint == Paint::Clear && clear_is_white;
        cells().map(white).collect()
    };
    let count = |white: Vec<bool>| Painter::new(grid.width(), white).count(enough);
    let black = count(filled(false));
    if cells().any(|paint| paint == Paint::Clear) { black.min(count(filled(true))) } else { black }
}

/// Paints a square with rectangles, always the one that sets most cells right.
struct Painter {
    width: usize,
    white: Vec<bool>,
    /// Which cells show the right colour already.
    right: Vec<bool>,
    /// For each corner of cells, the gain of all cells above and left of it.
    sums: Vec<i32>,
}

impl Painter {
    fn new(width: usize, white: Vec<bool>) -> Painter {
        Painter { right: vec![false; white.len()], sums: vec![0; (width + 1) * (width + 1)], width, white }
    }

    fn count(&mut self, enough: u32) -> u32 {
        let mut count = 0;
        while count < enough && self.right.contains(&false) {
            self.paint_best();
            count += 1;
        }
        count
    }

    fn paint_best(&mut self) {
        let mut best = (0, [0; 4], false);
        for white in [false, true] {
            self.add_up(white);
            self.for_each_rectangle(|gain, rectangle| {
                if gain > best.0 {
                    best = (gain, rectangle, white);
                }
            });
        }
        let (_, [left, top, right, bottom], white) = best;
        for y in top..bottom {
            for x in left..right {
                self.right[y * self.width + x] = self.white[y * self.width + x] == white;
            }
        }
    }

    /// The gain of a cell is 1 where it would become right, -1 where it would be spoilt.
    fn add_up(&mut self, white: bool) {
        let stride = self.width + 1;
        for y in 0..self.width {
            for x in 0..self.width {
                let cell = y * self.width + x;
                let becomes_right = self.white[cell] == white;
                let gain = i32::from(becomes_right && !self.right[cell])
                    - i32::from(!becomes_right && self.right[cell]);
                let at = (y + 1) * stride + x + 1;
                self.sums[at] =
                    gain + self.sums[at - 1] + self.sums[at - stride] - self.sums[at - stride - 1];
            }
        }
    }

    fn for_each_rectangle(&self, mut look: impl FnMut(i32, [usize; 4])) {
        let stride = self.width + 1;
        for top in 0..self.width {
            for bottom in top + 1..=self.width {
                let column = |x: usize| self.sums[bottom * stride + x] - self.sums[top * stride + x];
                for left in 0..self.width {
                    for right in left + 1..=self.width {
                        look(column(right) - column(left), [left, top, right, bottom]);
                    }
                }
            }
        }
    }
}

/// All rectangles in a square as masks, in the order in which the painter looks at them.
fn rectangles(width: u32) -> Vec<u64> {
    let spans = || (0..width).flat_map(|from| (from..width).map(move |to| (from, to)));
    let row = |(from, to): (u32, u32)| (from..=to).fold(0_u64, |cells, x| cells | 1 << x);
    let stack = |row: u64, (from, to): (u32, u32)| (from..=to).fold(0, |cells, y| cells | row << (y * width));
    spans().flat_map(|high| spans().map(move |wide| stack(row(wide), high))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use crate::random::Random;

    #[test]
    fn the_rings_alone_have_the_energy_of_their_edge() {
        // 4 x 4 data cells, all black, melt into the border; its edge of 6 cells a side is all that is left.
        let layout = Layout::classic(8).unwrap();
        assert_eq!(ising_energy(&layout.draw(0)), 4 * 6);
        // White data cells have an edge of 4 cells a side to the border.
        assert_eq!(ising_energy(&layout.draw(0xffff)), 4 * 6 + 4 * 4);
    }

    #[test]
    fn a_hole_has_no_energy() {
        // The white ring's own edges: 2 cells a side to the hole, which do not count, and 4 to the black ring.
        let layout =
            Layout::parse("dddddddd dbbbbbbd dbwwwwbd dbwxxwbd dbwxxwbd dbwwwwbd dbbbbbbd dddddddd").unwrap();
        assert_eq!(ising_energy(&layout.draw(0)), 4 * 4);
    }

    #[test]
    fn energy_does_not_change_when_the_tag_is_turned() {
        let mut random = Random::new(8);
        for layout in [Layout::circle(11), Layout::standard(9), Layout::classic(9)].map(Result::unwrap) {
            for _ in 0..100 {
                let code = random.next();
                let turned = layout.rotate90(code);
                assert_eq!(ising_energy(&layout.draw(code)), ising_energy(&layout.draw(turned)), "{code:#x}");
            }
        }
    }

    #[test]
    fn the_least_energies_are_those_of_the_published_families() {
        for (area, energy) in [(61, 41), (81, 54), (96, 64), (89, 60), (100, 67)] {
            assert_eq!(least_ising_energy(area), energy);
        }
    }

    #[test]
    fn rectangles_are_counted() {
        let chessboard = 0b0101_1010_0101_1010;
        // The whole square once, then one cell after the other.
        assert_eq!(rectangle_count(chessboard, 4), 9);
        for (square, count) in [(0x0000, 1), (0xffff, 1), (0x00ff, 2), (0x8001, 3), (0x0660, 2), (0xf99f, 2)]
        {
            assert_eq!(rectangle_count(square, 4), count, "{square:#x}");
        }
        assert_eq!(rectangle_count(1, 1), 1);
        assert_eq!(rectangle_count(u64::MAX, 8), 1);
    }

    #[test]
    fn a_negative_needs_as_many_rectangles_when_no_ties_decide() {
        for square in [0x8001_u64, 0x0660, 0xf99f, 0x00ff] {
            assert_eq!(rectangle_count(square, 4), rectangle_count(!square & 0xffff, 4));
        }
    }

    #[test]
    fn components_are_counted_without_the_hole() {
        let layout = Layout::classic(8).unwrap();
        // White ring, black rest.
        assert_eq!(component_count(&layout.draw(0)), 2);
        // White ring, black ring, white data.
        assert_eq!(component_count(&layout.draw(0xffff)), 3);
        // A chessboard of 16 cells: 8 white ones alone, the black ones at the rim belong to the ring, two do not.
        let chessboard = layout.from_row_major(0b0101_1010_0101_1010);
        assert_eq!(component_count(&layout.draw(chessboard)), 2 + 8 + 2);
        let open =
            Layout::parse("dddddddd dbbbbbbd dbwwwwbd dbwxxwbd dbwxxwbd dbwwwwbd dbbbbbbd dddddddd").unwrap();
        assert_eq!(component_count(&open.draw(u64::MAX)), 3);
    }

    #[test]
    fn a_whole_tag_is_painted_with_the_largest_gain_first() {
        let layout = Layout::classic(8).unwrap();
        // The black middle, then the four sides of the white ring.
        assert_eq!(tag_rectangle_count(&layout.draw(0), 99), 5);
        // All white, then the four sides of the black ring.
        assert_eq!(tag_rectangle_count(&layout.draw(0xffff), 99), 5);
        assert_eq!(tag_rectangle_count(&layout.draw(0xffff), 2), 2, "counting stops");
    }

    #[test]
    fn painting_a_square_of_data_and_painting_a_tag_are_the_same_up_to_ties() {
        let mut random = Random::new(21);
        for _ in 0..200 {
            let bits = random.next() & 0x1ff_ffff;
            let white = (0..25).map(|bit| bits >> bit & 1 == 1).collect();
            let (masks, sums) = (rectangle_count(bits, 5), Painter::new(5, white).count(99));
            assert!(masks.abs_diff(sums) <= 2, "{bits:#x}: {masks} and {sums}");
        }
    }

    #[test]
    fn metrics_are_as_strict_as_ising_by_default() {
        let layout = Layout::circle(9).unwrap();
        let share = |metric: Metric| {
            let rule = Rule { metric, least: metric.default_least(&layout) };
            let mut random = Random::new(5);
            (0..1000).filter(|_| rule.allows(&layout, random.next() >> 43)).count()
        };
        let ising = share(Metric::Ising);
        assert!((20..980).contains(&ising), "{ising}");
        for metric in [Metric::Rectangles, Metric::Components] {
            let other = share(metric);
            assert!(other * 3 > ising && other < ising * 3, "{metric}: {other} of 1000, ising {ising}");
        }
    }

    #[test]
    fn metrics_are_found_by_their_names() {
        for metric in Metric::ALL {
            assert_eq!(Metric::named(metric.name()), Some(metric));
        }
        assert_eq!(Metric::named("area"), None);
    }
}
