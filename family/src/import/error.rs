//! Why a table is no family.

use crate::layout_error::LayoutError;
use std::fmt;

/// What is wrong with a table, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportError {
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What can be wrong with a table.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The text looks like none of the forms that are read.
    UnknownFormat,
    /// Something that the form needs is not there.
    Missing {
        /// What was looked for.
        what: &'static str,
    },
    /// The text ends inside of something.
    Truncated {
        /// What does not end.
        what: &'static str,
    },
    /// A word or sign stands where it makes no sense.
    Unexpected {
        /// What stands there.
        found: String,
        /// What would make sense.
        wanted: &'static str,
    },
    /// A number is none, or too large, or makes no sense where it stands.
    Number {
        /// The number as it is written.
        text: String,
        /// What would make sense.
        wanted: &'static str,
    },
    /// There are more or fewer codes than the table says.
    CodeCount {
        /// Codes that the table says it has.
        stated: usize,
        /// Codes that are there.
        found: usize,
    },
    /// A code has bits that the layout has no cells for.
    CodeTooWide {
        /// The id.
        id: usize,
        /// The code.
        code: u64,
        /// Data cells of the layout.
        bit_count: u32,
    },
    /// Two codes are the same tag, perhaps turned.
    SameTag {
        /// The id of the first.
        first: usize,
        /// The line of the first.
        first_line: usize,
        /// The id of the second.
        second: usize,
    },
    /// A tag looks the same after a turn, so that nobody can say how it lies.
    Symmetric {
        /// The id.
        id: usize,
        /// Its code, in the order of the layout's bits.
        code: u64,
    },
    /// A marker of a dictionary is not a text of the right number of 0 and 1.
    Marker {
        /// The id.
        id: usize,
        /// Bits that a marker of this size has.
        bit_count: usize,
    },
    /// A bit lies outside of the tag, on its border, or where another lies.
    BitPlace {
        /// Its number, 0 being the most significant.
        bit: usize,
        /// Column and row, counted from the first cell inside the border edge.
        at: [i64; 2],
        /// Why it cannot lie there.
        why: &'static str,
    },
    /// The cells make no tag.
    Layout(LayoutError),
}

impl Problem {
    pub(crate) fn at(self, line: usize) -> ImportError {
        ImportError { line, problem: self }
    }
}

impl fmt::Display for ImportError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "line {}: {}", self.line, self.problem)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFormat => write!(
                out,
                "this is no table that is known; give a C table of the AprilTag library, a Java class of its generator, \
                 or a dictionary of OpenCV in YAML"
            ),
            Self::Missing { what } => write!(out, "{what} is missing"),
            Self::Truncated { what } => write!(out, "the text ends inside of {what}: is the file whole?"),
            Self::Unexpected { found, wanted } => write!(out, "{found:?} stands here, expected was {wanted}"),
            Self::Number { text, wanted } => write!(out, "{text} is not {wanted}"),
            Self::CodeCount { stated, found } => {
                write!(
                    out,
                    "the table says that it has {stated} codes, but {found} are there: is the file whole?"
                )
            }
            Self::CodeTooWide { id, code, bit_count } => write!(
                out,
                "code {id} is {code:#x}, but a tag has only {bit_count} bits; check the number of bits and the codes"
            ),
            Self::SameTag { first, first_line, second } => write!(
                out,
                "code {second} is the same tag as code {first} of line {first_line}, perhaps turned; drop one of them"
            ),
            Self::Symmetric { id, code } => write!(
                out,
                "code {id} ({code:#x}) looks the same after a turn, nobody could say how the tag lies; drop it, or name \
                 DICT_ARUCO_ORIGINAL, which is built in, if it is that"
            ),
            Self::Marker { id, bit_count } => {
                write!(out, "marker_{id} must be {bit_count} times 0 or 1, row after row")
            }
            Self::BitPlace { bit, at: [x, y], why } => {
                write!(out, "bit {bit} lies at x {x}, y {y} (bit_x, bit_y), {why}")
            }
            Self::Layout(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for ImportError {}
