//! The cells of a print as they were written down: reading them, and finding out what kind of square they are.

use crate::layout_error::{LayoutError, MAX_TOTAL_WIDTH};

/// What one cell of the printed square is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cell {
    /// Always white, letter `w`.
    White,
    /// Always black, letter `b`.
    Black,
    /// Holds a data bit, white for 1, letter `d`.
    Data,
    /// Not part of the tag, letter `x`.
    Ignored,
}

impl Cell {
    pub(crate) fn from_letter(letter: char) -> Option<Cell> {
        match letter {
            'w' => Some(Cell::White),
            'b' => Some(Cell::Black),
            'd' => Some(Cell::Data),
            'x' => Some(Cell::Ignored),
            _ => None,
        }
    }

    pub(crate) fn letter(self) -> char {
        match self {
            Cell::White => 'w',
            Cell::Black => 'b',
            Cell::Data => 'd',
            Cell::Ignored => 'x',
        }
    }
}

/// Which side of the border edge is white.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Border {
    /// White outside, black inside (tag36h11).
    Normal,
    /// Black outside, white inside (tagStandard41h12).
    Reversed,
}

/// The cells of the print before anything but their number is known to be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Square {
    width: usize,
    cells: Vec<Cell>,
}

impl Square {
    /// Reads letters row after row, blanks skipped; checks that they form a square, and nothing else.
    pub(crate) fn parse(letters: &str) -> Result<Square, LayoutError> {
        let cells = read_cells(letters)?;
        let width = cells.len().isqrt();
        if width * width != cells.len() {
            return Err(LayoutError::NotSquare { cells: cells.len() });
        }
        check_width(width)?;
        Ok(Square { width, cells })
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Row after row from the top.
    pub(crate) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    pub(crate) fn at(&self, x: usize, y: usize) -> Cell {
        self.cells[y * self.width + x]
    }

    /// Where the cell at `x`, `y` lies after a quarter turn clockwise.
    fn turned(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [self.width - 1 - y, x]
    }

    pub(crate) fn check_symmetry(&self) -> Result<(), LayoutError> {
        for y in 0..self.width {
            for x in 0..self.width {
                let [turned_x, turned_y] = self.turned([x, y]);
                let (cell, turned) = (self.at(x, y), self.at(turned_x, turned_y));
                if cell != turned {
                    return Err(LayoutError::NotSymmetric {
                        cell: [x, y],
                        letter: cell.letter(),
                        turned_cell: [turned_x, turned_y],
                        turned_letter: turned.letter(),
                    });
                }
            }
        }
        Ok(())
    }

    /// The outermost pair of neighbouring rings of which one is all black and the other all white: the number of
    /// cells outside the edge between them, and its kind.
    pub(crate) fn find_border(&self) -> Option<(usize, Border)> {
        let pair = |outer: usize, outer_cell, inner_cell| {
            self.ring_is(outer, outer_cell) && self.ring_is(outer + 1, inner_cell)
        };
        (0..self.width.div_ceil(2).saturating_sub(1)).find_map(|outer| {
            let normal = pair(outer, Cell::White, Cell::Black).then_some((outer + 1, Border::Normal));
            normal.or_else(|| pair(outer, Cell::Black, Cell::White).then_some((outer + 1, Border::Reversed)))
        })
    }

    /// Whether all four sides of a ring (0 is the outermost) consist of this kind of cell.
    pub(crate) fn ring_is(&self, ring: usize, kind: Cell) -> bool {
        let last = self.width - 1 - ring;
        (ring..=last).all(|along| {
            let sides = [[along, ring], [last, along], [along, last], [ring, along]];
            sides.iter().all(|&[x, y]| self.at(x, y) == kind)
        })
    }

    /// The data cells in the order of their bits, in print coordinates.
    pub(crate) fn quadrant_order(&self) -> Vec<[usize; 2]> {
        let mut quadrant = self.top_wedge();
        let mut bits = Vec::with_capacity(4 * quadrant.len() + 1);
        for _ in 0..4 {
            bits.extend_from_slice(&quadrant);
            quadrant.iter_mut().for_each(|at| *at = self.turned(*at));
        }
        let middle = self.width / 2;
        if self.width % 2 == 1 && self.at(middle, middle) == Cell::Data {
            bits.push([middle, middle]);
        }
        bits
    }

    /// The data cells between the diagonals at the top; of the diagonals' cells only those at the left.
    fn top_wedge(&self) -> Vec<[usize; 2]> {
        let row = |y: usize| (y..self.width - 1 - y).map(move |x| [x, y]);
        (0..self.width / 2).flat_map(row).filter(|&[x, y]| self.at(x, y) == Cell::Data).collect()
    }
}

fn read_cells(cells: &str) -> Result<Vec<Cell>, LayoutError> {
    let letters = cells.chars().filter(|letter| !letter.is_whitespace());
    let read =
        |(position, letter)| Cell::from_letter(letter).ok_or(LayoutError::UnknownLetter { letter, position });
    letters.enumerate().map(read).collect()
}

/// Refuses sizes that no print has.
pub(crate) fn check_width(total_width: usize) -> Result<(), LayoutError> {
    match total_width {
        0 => Err(LayoutError::NotSquare { cells: 0 }),
        1..=MAX_TOTAL_WIDTH => Ok(()),
        _ => Err(LayoutError::TooWide { total_width }),
    }
}
