//! How much a tag differs from what nature puts into pictures: plain surfaces and straight edges look like tags of
//! low complexity, and families leave such codes out.

use crate::grid::{Grid, Paint};

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
    assert!((1..=8).contains(&width), "a square of {width} x {width} bits does not fit 64");
    let rectangles = rectangles(width);
    let everything = u64::MAX >> (64 - width * width);
    // Which cells show the right colour already; at first they show none.
    let mut right = 0;
    let mut count = 0;
    while right != everything {
        let gain = |area: u64, wanted: u64| {
            (area & wanted & !right).count_ones() as i32 - (area & !wanted & right).count_ones() as i32
        };
        let mut best = (0, 0, 0);
        for &area in &rectangles {
            for wanted in [!square, square] {
                let gain = gain(area, wanted);
                if gain > best.0 {
                    best = (gain, area, wanted);
                }
            }
        }
        let (_, area, wanted) = best;
        right = right & !area | area & wanted;
        count += 1;
    }
    count
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
}
