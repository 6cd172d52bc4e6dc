//! How much a tag differs from what nature puts into pictures: plain surfaces and straight edges look like tags of
//! low complexity, and families leave such codes out.

use crate::grid::{Grid, Paint};

/// The Ising energy of a tag: pairs of neighbouring cells (left and right, above and below) of which one is black and
/// the other white. Cells that are not part of the tag do not count.
///
/// Source: "Flexible Layouts for Fiducial Tags", section IV; used for tagCircle, tagCustom and tagStandard.
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
/// Bit `y * width + x` of `square` is the cell in column `x` of row `y`; `width` is 1 to 8. Which of equally good
/// rectangles is taken can matter, so the published families are reproduced only by scanning y, height, x, width and
/// black before white, with the least significant bit of the row-major code at the top left.
pub fn rectangle_count(square: u64, width: u32) -> u32 {
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
