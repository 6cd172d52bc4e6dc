//! Layouts: what each cell of the printed square is, where the border lies, and in which order the bits are read.
//!
//! Source: "Flexible Layouts for Fiducial Tags" (Krogius, Haggenmiller, Olson 2019), section III.

use crate::grid::{Grid, Paint};
use crate::shape;
use std::fmt;

/// More cells along an edge than any printed tag has; keeps a mistyped size from eating the memory.
const MAX_TOTAL_WIDTH: usize = 64;
/// Codes are kept in a `u64`.
const MAX_BITS: usize = 64;
/// With fewer bits not even the four ways to turn a tag can be told apart.
const MIN_BITS: usize = 4;

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
    fn from_letter(letter: char) -> Option<Cell> {
        match letter {
            'w' => Some(Cell::White),
            'b' => Some(Cell::Black),
            'd' => Some(Cell::Data),
            'x' => Some(Cell::Ignored),
            _ => None,
        }
    }

    fn letter(self) -> char {
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

/// A valid layout: a square of cells that looks the same after a quarter turn, with a border and 4 to 64 data bits.
///
/// ```
/// use tagbus_family::{Border, Layout};
///
/// let layout = Layout::parse("wwwwww wbbbbw wbddbw wbddbw wbbbbw wwwwww")?;
/// assert_eq!((layout.total_width(), layout.width_at_border(), layout.bit_count()), (6, 4, 4));
/// assert_eq!(layout.border(), Border::Normal);
/// assert_eq!(layout, Layout::classic(6)?);
/// # Ok::<(), tagbus_family::LayoutError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    square: Square,
    margin: usize,
    border: Border,
    bits: Vec<[i32; 2]>,
}

impl Layout {
    /// Reads n * n letters `w`, `b`, `d`, `x`, row after row from the top; blanks and line breaks are skipped.
    ///
    /// # Errors
    /// Any [`LayoutError`]: the letters are checked first, then the size, symmetry, border and number of bits.
    pub fn parse(cells: &str) -> Result<Layout, LayoutError> {
        let square = Square::new(read_cells(cells)?)?;
        square.check_symmetry()?;
        let (margin, border) = square.find_border().ok_or(LayoutError::NoBorder)?;
        let bits = square.quadrant_order();
        match bits.len() {
            count if count < MIN_BITS => Err(LayoutError::TooFewBits { count }),
            count if count > MAX_BITS => Err(LayoutError::TooManyBits { count }),
            _ => Ok(Layout { bits: from_border(&bits, margin), square, margin, border }),
        }
    }

    /// White ring, black ring, data inside (16h5, 25h9, 36h10, 36h11: 8, 9, 10 and 10 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits.
    pub fn classic(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::classic(total_width))
    }

    /// Data, black ring, white ring, data (41h12 and 52h13: 9 and 10 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits, or no border.
    pub fn standard(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::standard(total_width))
    }

    /// The standard order of rings cut to a disc (21h7 and 49h12: 9 and 11 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits, or no border.
    pub fn circle(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::circle(total_width))
    }

    /// Cells along one edge of the print.
    pub fn total_width(&self) -> usize {
        self.square.width
    }

    /// Cells along the edge where black meets white: the tag size of pose estimation, in cells.
    pub fn width_at_border(&self) -> usize {
        self.square.width - 2 * self.margin
    }

    /// Which side of that edge is white.
    pub fn border(&self) -> Border {
        self.border
    }

    /// Cells between the edge of the print and the border edge.
    pub fn margin(&self) -> usize {
        self.margin
    }

    /// Number of data bits, 4 to 64; 0 or 1 more than a multiple of four.
    pub fn bit_count(&self) -> u32 {
        self.bits.len() as u32
    }

    /// `[x, y]` of each data cell, counted from the top-left cell inside the border edge and therefore negative for
    /// cells outside it; most significant bit first.
    ///
    /// The order goes round by quadrants so that turning the tag is a cyclic shift of the code: first the wedge
    /// between the two diagonals at the top (row by row), then the same wedge turned to the right, bottom and left,
    /// last the centre cell if that is data.
    pub fn bits(&self) -> &[[i32; 2]] {
        &self.bits
    }

    /// The cell at `x`, `y` counted as in [`Layout::bits`]; [`Cell::Ignored`] outside the print.
    pub fn cell(&self, x: i32, y: i32) -> Cell {
        let in_print = |at: i32| usize::try_from(i64::from(at) + self.margin as i64).ok();
        match (in_print(x), in_print(y)) {
            (Some(x), Some(y)) if x.max(y) < self.square.width => self.square.at(x, y),
            _ => Cell::Ignored,
        }
    }

    /// The code of the same tag turned counter-clockwise by 90 degrees: what was at its right is at its top.
    ///
    /// Bits of `code` beyond [`Layout::bit_count`] are dropped.
    pub fn rotate90(&self, code: u64) -> u64 {
        rotate90(code, self.bit_count())
    }

    /// Cells that belong to the tag: all but the ignored ones.
    pub fn area(&self) -> usize {
        self.square.cells.iter().filter(|&&cell| cell != Cell::Ignored).count()
    }

    /// Width of the centred square of ignored cells into which a smaller tag fits, 0 when there is none
    /// (tagCustom48h12: 2).
    pub fn hole_width(&self) -> usize {
        let smallest_margin = self.square.width.div_ceil(2);
        let ring_is_open = |ring: &usize| self.square.ring_is(*ring, Cell::Ignored);
        let open_rings = (0..smallest_margin).rev().take_while(ring_is_open).count();
        match open_rings {
            0 => 0,
            rings => self.square.width - 2 * (smallest_margin - rings),
        }
    }

    /// The letters of the layout without blanks, as [`Layout::parse`] reads them.
    pub fn text(&self) -> String {
        self.square.cells.iter().map(|cell| cell.letter()).collect()
    }

    /// The tag with this code, cell by cell. Bits beyond [`Layout::bit_count`] are not looked at.
    pub fn draw(&self, code: u64) -> Grid {
        let mut paint: Vec<Paint> = self.square.cells.iter().map(|&cell| fixed_paint(cell)).collect();
        for (place, &[x, y]) in self.bits.iter().rev().enumerate() {
            if code >> place & 1 == 1 {
                paint[self.print_offset(x, y)] = Paint::White;
            }
        }
        Grid::new(self.square.width, paint)
    }

    /// The code whose data cells, read row after row from the top, spell `rows` (most significant bit first).
    ///
    /// Older tables (the first AprilTag release, ArUco dictionaries) keep their codes in this order.
    pub fn from_row_major(&self, rows: u64) -> u64 {
        let places = self.row_major_places();
        self.bits.iter().fold(0, |code, &[x, y]| code << 1 | rows >> places[self.print_offset(x, y)] & 1)
    }

    /// The inverse of [`Layout::from_row_major`].
    pub fn to_row_major(&self, code: u64) -> u64 {
        let places = self.row_major_places();
        let bit = |place: usize, [x, y]: [i32; 2]| (code >> place & 1) << places[self.print_offset(x, y)];
        self.bits.iter().rev().enumerate().fold(0, |rows, (place, &at)| rows | bit(place, at))
    }

    /// For each cell of the print the place of its bit, counted from the least significant, in row-major codes.
    fn row_major_places(&self) -> Vec<u32> {
        let mut place = self.bit_count();
        let next = |&cell: &Cell| {
            place -= u32::from(cell == Cell::Data);
            place
        };
        self.square.cells.iter().map(next).collect()
    }

    fn print_offset(&self, x: i32, y: i32) -> usize {
        let margin = self.margin as i32;
        (y + margin) as usize * self.square.width + (x + margin) as usize
    }
}

/// [`Layout::rotate90`] for codes of `bit_count` bits; the centre bit, if there is one, is the lowest and stays.
pub(crate) fn rotate90(code: u64, bit_count: u32) -> u64 {
    let centre = bit_count % 4;
    let turning = bit_count - centre;
    let quarter = turning / 4;
    let mask = u64::MAX >> (64 - turning);
    let turned = code >> centre & mask;
    let turned = (turned << quarter | turned >> (turning - quarter)) & mask;
    turned << centre | code & centre_mask(centre)
}

fn centre_mask(centre: u32) -> u64 {
    (1 << centre) - 1
}

fn fixed_paint(cell: Cell) -> Paint {
    match cell {
        Cell::White => Paint::White,
        Cell::Black | Cell::Data => Paint::Black,
        Cell::Ignored => Paint::Clear,
    }
}

fn read_cells(cells: &str) -> Result<Vec<Cell>, LayoutError> {
    let letters = cells.chars().filter(|letter| !letter.is_whitespace());
    let read =
        |(position, letter)| Cell::from_letter(letter).ok_or(LayoutError::UnknownLetter { letter, position });
    letters.enumerate().map(read).collect()
}

fn check_width(total_width: usize) -> Result<(), LayoutError> {
    match total_width {
        0 => Err(LayoutError::NotSquare { cells: 0 }),
        1..=MAX_TOTAL_WIDTH => Ok(()),
        _ => Err(LayoutError::TooWide { total_width }),
    }
}

fn from_border(bits: &[[usize; 2]], margin: usize) -> Vec<[i32; 2]> {
    bits.iter().map(|at| at.map(|print| print as i32 - margin as i32)).collect()
}

/// The cells of the print before anything but their number is known to be right.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Square {
    width: usize,
    cells: Vec<Cell>,
}

impl Square {
    fn new(cells: Vec<Cell>) -> Result<Square, LayoutError> {
        let width = cells.len().isqrt();
        if width * width != cells.len() {
            return Err(LayoutError::NotSquare { cells: cells.len() });
        }
        check_width(width)?;
        Ok(Square { width, cells })
    }

    fn at(&self, x: usize, y: usize) -> Cell {
        self.cells[y * self.width + x]
    }

    /// Where the cell at `x`, `y` lies after a quarter turn clockwise.
    fn turned(&self, [x, y]: [usize; 2]) -> [usize; 2] {
        [self.width - 1 - y, x]
    }

    fn check_symmetry(&self) -> Result<(), LayoutError> {
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
    fn find_border(&self) -> Option<(usize, Border)> {
        let pair = |outer: usize, outer_cell, inner_cell| {
            self.ring_is(outer, outer_cell) && self.ring_is(outer + 1, inner_cell)
        };
        (0..self.width.div_ceil(2).saturating_sub(1)).find_map(|outer| {
            let normal = pair(outer, Cell::White, Cell::Black).then_some((outer + 1, Border::Normal));
            normal.or_else(|| pair(outer, Cell::Black, Cell::White).then_some((outer + 1, Border::Reversed)))
        })
    }

    /// Whether all four sides of a ring (0 is the outermost) consist of this kind of cell.
    fn ring_is(&self, ring: usize, kind: Cell) -> bool {
        let last = self.width - 1 - ring;
        (ring..=last).all(|along| {
            let sides = [[along, ring], [last, along], [along, last], [ring, along]];
            sides.iter().all(|&[x, y]| self.at(x, y) == kind)
        })
    }

    /// The data cells in the order of their bits, in print coordinates.
    fn quadrant_order(&self) -> Vec<[usize; 2]> {
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

/// Why a text or a size is no layout. Cells are named `[x, y]`, counted from the top-left cell of the print.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LayoutError {
    /// A letter other than `w`, `b`, `d`, `x`.
    UnknownLetter {
        /// The letter.
        letter: char,
        /// Its place among the letters, blanks not counted, from 0.
        position: usize,
    },
    /// The number of letters is not 1, 4, 9, 16, ...
    NotSquare {
        /// The number of letters.
        cells: usize,
    },
    /// More than 64 cells along an edge.
    TooWide {
        /// Cells along an edge.
        total_width: usize,
    },
    /// A cell differs from the one on which it falls after a quarter turn.
    NotSymmetric {
        /// The first such cell.
        cell: [usize; 2],
        /// Its letter.
        letter: char,
        /// Where it lies after a quarter turn clockwise.
        turned_cell: [usize; 2],
        /// The letter found there.
        turned_letter: char,
    },
    /// No ring of white cells lies next to a ring of black cells.
    NoBorder,
    /// Fewer than 4 data cells.
    TooFewBits {
        /// The number of data cells.
        count: usize,
    },
    /// More than 64 data cells.
    TooManyBits {
        /// The number of data cells.
        count: usize,
    },
}

impl fmt::Display for LayoutError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LayoutError::UnknownLetter { letter, position } => write!(
                out,
                "cell {position} of the layout is {letter:?}, allowed are w (white), b (black), d (data) and \
                 x (not part of the tag)"
            ),
            LayoutError::NotSquare { cells } => {
                let below = cells.isqrt().max(1);
                let (fewer, more) = (below * below, (below + 1) * (below + 1));
                write!(
                    out,
                    "a layout needs n x n cells, but {cells} were given; the next squares are {fewer} and {more}"
                )
            }
            LayoutError::TooWide { total_width } => {
                write!(
                    out,
                    "a layout has at most {MAX_TOTAL_WIDTH} cells along an edge, but {total_width} were asked for"
                )
            }
            LayoutError::NotSymmetric {
                cell: [x, y],
                letter,
                turned_cell: [turned_x, turned_y],
                turned_letter,
            } => {
                write!(
                    out,
                    "the layout must look the same after a quarter turn, but cell ({x}, {y}) is {letter} and falls on \
                     cell ({turned_x}, {turned_y}), which is {turned_letter}; make them equal"
                )
            }
            LayoutError::NoBorder => write!(
                out,
                "the layout has no border: a closed ring of w cells is needed right outside or inside a closed ring \
                 of b cells"
            ),
            LayoutError::TooFewBits { count } => {
                write!(out, "the layout has {count} data cells, at least {MIN_BITS} are needed")
            }
            LayoutError::TooManyBits { count } => {
                write!(
                    out,
                    "the layout has {count} data cells, at most {MAX_BITS} are possible; turn some into w, b or x"
                )
            }
        }
    }
}

impl std::error::Error for LayoutError {}
