//! Why a text or a size is no layout, and the limits that it broke.

use std::fmt;

/// More cells along an edge than any printed tag has; keeps a mistyped size from eating the memory.
pub(crate) const MAX_TOTAL_WIDTH: usize = 64;
/// Codes are kept in a `u64`.
pub(crate) const MAX_BITS: usize = 64;
/// With fewer bits not even the four ways to turn a tag can be told apart.
pub(crate) const MIN_BITS: usize = 4;

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
