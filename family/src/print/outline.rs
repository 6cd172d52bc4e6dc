//! Cells that touch, merged into closed outlines.

use std::collections::BTreeMap;

/// A closed polygon in whole cells; its last point is joined to its first.
pub(super) type Loop = Vec<[i32; 2]>;

/// Start, direction and outward side of a cell's four edges, clockwise as seen, for the cell (0, 0).
const EDGES: [([i32; 2], [i32; 2], [i32; 2]); 4] = [
    ([0, 0], [1, 0], [0, -1]),
    ([1, 0], [0, 1], [1, 0]),
    ([1, 1], [-1, 0], [0, 1]),
    ([0, 1], [0, -1], [-1, 0]),
];

/// The outlines of the cells `0..width` squared that are filled; together, by the even-odd rule, they enclose just these.
///
/// Every edge between a filled cell and one that is not is walked once, with the filled cell at the right. Where two
/// filled cells touch at a corner only, either way of going on encloses the same area.
pub(super) fn trace(width: usize, filled: impl Fn(usize, usize) -> bool) -> Vec<Loop> {
    let mut edges = open_edges(width as i32, |[x, y]| {
        let inside = |at: i32| (0..width as i32).contains(&at);
        inside(x) && inside(y) && filled(x as usize, y as usize)
    });
    let mut loops = Vec::new();
    // The first point left is the leftmost one of its outline, and therefore one of its corners.
    while let Some(start) = edges.keys().next().copied() {
        loops.push(walk(start, &mut edges));
    }
    loops
}

/// Directions of the edges that leave each point.
type Edges = BTreeMap<[i32; 2], Vec<[i32; 2]>>;

fn open_edges(width: i32, filled: impl Fn([i32; 2]) -> bool) -> Edges {
    let mut edges = Edges::new();
    let cells = (0..width).flat_map(|y| (0..width).map(move |x| [x, y]));
    for cell in cells.filter(|&cell| filled(cell)) {
        for (start, direction, outward) in EDGES {
            if !filled(sum(cell, outward)) {
                edges.entry(sum(cell, start)).or_default().push(direction);
            }
        }
    }
    edges
}

fn walk(start: [i32; 2], edges: &mut Edges) -> Loop {
    let (mut at, mut last) = (start, [0, 0]);
    let mut corners = Loop::new();
    while let Some(direction) = take(at, edges) {
        if direction != last {
            corners.push(at);
        }
        (at, last) = (sum(at, direction), direction);
        if at == start {
            break;
        }
    }
    corners
}

fn take(at: [i32; 2], edges: &mut Edges) -> Option<[i32; 2]> {
    let leaving = edges.get_mut(&at)?;
    let direction = leaving.pop();
    if leaving.is_empty() {
        edges.remove(&at);
    }
    direction
}

fn sum([x, y]: [i32; 2], [dx, dy]: [i32; 2]) -> [i32; 2] {
    [x + dx, y + dy]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Whether a cell's centre is inside: an odd number of upright edges lies at its right.
    fn inside(loops: &[Loop], x: i32, y: i32) -> bool {
        let crosses = |[from, to]: [[i32; 2]; 2]| {
            from[0] == to[0] && from[0] > x && (from[1].min(to[1])..from[1].max(to[1])).contains(&y)
        };
        let sides = |corners: &Loop| {
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).filter(|(from, to)| crosses([**from, **to])).count()
        };
        loops.iter().map(sides).sum::<usize>() % 2 == 1
    }

    #[test]
    fn outlines_enclose_the_filled_cells_and_no_others() {
        let mut random = Random::new(5);
        for case in 0..2000 {
            let width = 1 + random.below(9);
            let share = 1 + random.below(7);
            let cells: Vec<bool> = (0..width * width).map(|_| random.below(8) < share).collect();
            let loops = trace(width, |x, y| cells[y * width + x]);
            for y in 0..width {
                for x in 0..width {
                    assert_eq!(
                        inside(&loops, x as i32, y as i32),
                        cells[y * width + x],
                        "case {case}: {x}, {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn outlines_have_corners_only_and_sides_along_the_cells() {
        assert_eq!(trace(3, |_, _| true), [[[0, 0], [3, 0], [3, 3], [0, 3]]]);
        let ring = trace(3, |x, y| (x, y) != (1, 1));
        assert_eq!(ring.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
    }
}
