//! Where black is on paper: in the cells that are black, and a little beside them where ink has spread.
//!
//! Ink that spreads by `d` of a cell makes every black cell wider by `d` on all sides. Seen on a lattice that is three
//! times as fine, with strips of width `d` along the sides of every cell, it is a matter of whole parts again:
//!
//! ```text
//!    0  d      1-d 1
//!    ┌──┬───────┬──┐
//!    ├──┼───────┼──┤     a part is black when the cell it lies in is black,
//!    │  │       │  │     or the cell across one of the sides that it touches,
//!    ├──┼───────┼──┤     or, in a corner, the cell across that corner
//!    └──┴───────┴──┘
//! ```

use crate::tag::Tag;
use tagbus_family::Paint;

/// The parts of a tag's cells, from one cell outside of the print on.
pub(crate) struct Lattice<'a> {
    tag: &'a Tag,
    /// How far ink has spread, in cells.
    spread: f64,
    /// Parts of a cell on each axis: 1 without spreading, else 3.
    parts: i64,
}

impl<'a> Lattice<'a> {
    /// The parts of a print whose ink has spread by that share of a cell, which is taken as 0 to 0.45.
    pub(crate) fn new(tag: &'a Tag, spread: f64) -> Lattice<'a> {
        let spread = if spread > 0.0 { spread.min(0.45) } else { 0.0 };
        Lattice { tag, spread, parts: if spread > 0.0 { 3 } else { 1 } }
    }

    /// The lines between parts on one axis: the first and the last one have nothing but clear parts beyond.
    pub(crate) fn lines(&self) -> std::ops::RangeInclusive<i64> {
        let width = self.tag.grid().width() as i64;
        if self.parts == 1 { 0..=width } else { -self.parts..=self.parts * (width + 1) }
    }

    /// Where a line lies, in cells of the print.
    pub(crate) fn line_at(&self, line: i64) -> f64 {
        let offset = match line.rem_euclid(self.parts) {
            0 => 0.0,
            1 => self.spread,
            _ => 1.0 - self.spread,
        };
        line.div_euclid(self.parts) as f64 + offset
    }

    /// What the part between the lines `x` and `x + 1`, `y` and `y + 1` shows.
    pub(crate) fn paint_at(&self, x: i64, y: i64) -> Paint {
        let (cell_x, cell_y) = (x.div_euclid(self.parts), y.div_euclid(self.parts));
        let own = self.tag.paint_at(cell_x, cell_y);
        if self.parts == 1 {
            return own;
        }
        let [beside_x, beside_y] = [x, y].map(|part| self.neighbour_of(part));
        let across = [[beside_x, 0], [0, beside_y], [beside_x, beside_y]];
        let is_black = |[dx, dy]: [i64; 2]| self.tag.paint_at(cell_x + dx, cell_y + dy) == Paint::Black;
        if across.into_iter().any(is_black) { Paint::Black } else { own }
    }

    /// The direction of the cell that a part touches on one axis; 0 in the middle of its own.
    fn neighbour_of(&self, part: i64) -> i64 {
        match (self.parts, part.rem_euclid(self.parts)) {
            (3, 0) => -1,
            (3, 2) => 1,
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Family;

    fn tag(name: &str) -> Tag {
        Tag::new(&Family::published(name).unwrap(), 3).unwrap()
    }

    #[test]
    fn without_spreading_parts_are_cells() {
        let tag = tag("tag36h11");
        for spread in [0.0, -1.0, f64::NAN] {
            let lattice = Lattice::new(&tag, spread);
            assert_eq!(lattice.lines(), 0..=10);
            for (x, y) in (-1..11).flat_map(|y| (-1..11).map(move |x| (x, y))) {
                assert_eq!(lattice.paint_at(x, y), tag.paint_at(x, y));
                assert_eq!(lattice.line_at(x), x as f64);
            }
        }
    }

    /// Black somewhere within the spread of a point, asked of the cells alone.
    fn is_inked(tag: &Tag, spread: f64, x: f64, y: f64) -> bool {
        [-spread, 0.0, spread].into_iter().any(|dx| {
            [-spread, 0.0, spread]
                .into_iter()
                .any(|dy| tag.paint_at((x + dx).floor() as i64, (y + dy).floor() as i64) == Paint::Black)
        })
    }

    #[test]
    fn a_part_is_black_where_a_black_cell_is_within_the_spread() {
        for name in ["tag36h11", "tagStandard41h12", "tagCircle21h7"] {
            let tag = tag(name);
            let lattice = Lattice::new(&tag, 0.2);
            let lines = *lattice.lines().start()..*lattice.lines().end();
            for (x, y) in lines.clone().flat_map(|y| lines.clone().map(move |x| (x, y))) {
                let middle = |part: i64| (lattice.line_at(part) + lattice.line_at(part + 1)) / 2.0;
                let expected = is_inked(&tag, 0.2, middle(x), middle(y));
                assert_eq!(lattice.paint_at(x, y) == Paint::Black, expected, "{name}: part {x}, {y}");
            }
        }
    }
}
