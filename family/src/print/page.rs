//! What is on a page, before any format.

use super::outline::Loop;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Black cells, the ruler, text.
    Black,
    /// White cells, so that a tag can be laid over a coloured ground.
    White,
    /// Cut marks.
    Grey,
}

impl Ink {
    /// From 0, black, to 255.
    pub fn level(self) -> u8 {
        match self {
            Ink::Black => 0,
            Ink::Grey => 128,
            Ink::White => 255,
        }
    }
}

/// Polygons on a grid of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlines {
    /// Where the grid's (0, 0) lies, in millimetres.
    pub origin: [f64; 2],
    /// Millimetres of one step of the grid.
    pub step_mm: f64,
    /// Closed polygons in steps of the grid.
    pub loops: Vec<Loop>,
}

impl Outlines {
    /// The corners of each polygon in millimetres.
    fn polygons(&self) -> impl Iterator<Item = impl Iterator<Item = [f64; 2]>> {
        let [x, y] = self.origin;
        let at = move |corner: &[i32; 2]| {
            [x + self.step_mm * f64::from(corner[0]), y + self.step_mm * f64::from(corner[1])]
        };
        self.loops.iter().map(move |corners| corners.iter().map(at))
    }
}

/// One path, filled by the even-odd rule. What touches, also from one grid to another, is to be in the same pattern: renderers
/// leave hairlines between two paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// What it consists of; none lies over another.
    pub parts: Vec<Outlines>,
    /// Their colour.
    pub ink: Ink,
}

impl Pattern {
    /// The same pattern elsewhere.
    pub(super) fn moved(&self, [dx, dy]: [f64; 2]) -> Pattern {
        let moved = |part: &Outlines| {
            let [x, y] = part.origin;
            Outlines { origin: [x + dx, y + dy], ..part.clone() }
        };
        Pattern { parts: self.parts.iter().map(moved).collect(), ink: self.ink }
    }

    /// The corners of each polygon in millimetres.
    pub(super) fn polygons(&self) -> impl Iterator<Item = impl Iterator<Item = [f64; 2]>> {
        self.parts.iter().flat_map(Outlines::polygons)
    }
}

/// Something on a page, in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Cells, or an arrow.
    Pattern(Pattern),
    /// A straight line.
    Line {
        /// From here
        from: [f64; 2],
        /// to here.
        to: [f64; 2],
        /// Its width.
        width: f64,
        /// Its colour.
        ink: Ink,
    },
    /// A circular line.
    Circle {
        /// Its middle.
        centre: [f64; 2],
        /// To the middle of the line.
        radius: f64,
        /// The line's width.
        width: f64,
        /// Its colour.
        ink: Ink,
    },
    /// A line of text in Helvetica or what resembles it.
    Text {
        /// Where its base line begins.
        at: [f64; 2],
        /// The font's size.
        size: f64,
        /// The text.
        text: String,
    },
}

/// A page; later marks cover earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// Width and height in millimetres.
    pub size: [f64; 2],
    /// What is on it.
    pub marks: Vec<Mark>,
}
