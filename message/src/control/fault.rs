//! What a request or a reply says that cannot be.

use std::fmt;

/// What a request or a reply says that cannot be: found where it is written, and again where it is read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlFault {
    /// Of another version.
    Schema {
        /// The version that it names.
        seen: u32,
        /// The version that this code reads.
        known: u32,
    },
    /// Asks for something that nobody knows.
    Kind {
        /// The code.
        seen: u32,
    },
    /// Sets a parameter that nobody knows.
    Parameter {
        /// The bits of the unknown ones.
        bits: u32,
    },
    /// Bytes that are no text.
    Text {
        /// What they should name.
        what: &'static str,
    },
    /// A text that does not fit.
    Long {
        /// What it names.
        what: &'static str,
        /// The text.
        text: String,
        /// Bytes that there is room for.
        room: usize,
    },
    /// More entries than there is room for.
    Count {
        /// Entries of what.
        what: &'static str,
        /// How many.
        seen: usize,
        /// How many there is room for.
        room: usize,
    },
    /// A choice that is none.
    Choice {
        /// What is chosen.
        what: &'static str,
        /// The code.
        seen: u32,
    },
    /// A number that is none.
    Number {
        /// What it is for.
        what: &'static str,
        /// The number.
        seen: f32,
    },
    /// A number of corrected bits below zero that does not mean "each family's own".
    Hamming(i32),
    /// A range of ids that ends before it begins.
    Range {
        /// Its first id.
        first: u32,
        /// Its last id.
        last: u32,
    },
}

impl fmt::Display for ControlFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schema { seen, known } => {
                write!(f, "control message of version {seen}, but this program reads version {known}")
            }
            Self::Kind { seen } => {
                write!(f, "request of kind {seen}: known are 1 (get), 2 (set) and 3 (reset statistics)")
            }
            Self::Parameter { bits } => write!(f, "the request sets unknown parameters (bits {bits:#x})"),
            Self::Text { what } => write!(f, "the {what} is no text in UTF-8"),
            Self::Long { what, text, room } => {
                write!(f, "the {what} \"{text}\" takes {} bytes but at most {room} fit", text.len())
            }
            Self::Count { what, seen, room } => write!(f, "{seen} {what}, but at most {room} fit"),
            Self::Choice { what, seen } => write!(f, "{what} number {seen}: known are 0, 1 and 2"),
            Self::Number { what, seen } => write!(f, "{what} {seen} is no number"),
            Self::Hamming(seen) => {
                write!(f, "{seen} corrected bits: use 0 or more, or -1 for each family's own number")
            }
            Self::Range { first, last } => write!(f, "ids {first} to {last}: the first is above the last"),
        }
    }
}

impl std::error::Error for ControlFault {}
