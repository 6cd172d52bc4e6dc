//! What requests and replies of every role have in common.

use super::fault::ControlFault;
use crate::text;

/// The layout of requests and replies that this code writes and reads.
pub const CONTROL_SCHEMA: u32 = 1;
/// Bytes that the text of a reply may take.
pub const REPLY_TEXT_BYTES: usize = 512;

/// What a request asks for. Every reply tells what is in force, the state and the statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum RequestKind {
    /// Nothing but the reply.
    Get = 1,
    /// Other values.
    Set = 2,
    /// Statistics that begin anew. Counters in headers of messages go on.
    ResetStatistics = 3,
}

impl RequestKind {
    /// The kind of a code.
    pub fn from_code(code: u32) -> Result<Self, ControlFault> {
        match code {
            1 => Ok(Self::Get),
            2 => Ok(Self::Set),
            3 => Ok(Self::ResetStatistics),
            seen => Err(ControlFault::Kind { seen }),
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }
}

/// How a request ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// A code of a newer version: the reply's text says more.
    Unknown = 0,
    /// As it was asked for; the text may add something worth knowing.
    Done = 1,
    /// Nothing has changed; the text says which value is not possible, and what is.
    Refused = 2,
}

impl Outcome {
    /// The outcome of a code.
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            1 => Self::Done,
            2 => Self::Refused,
            _ => Self::Unknown,
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }
}

pub(super) fn check_schema(seen: u32) -> Result<(), ControlFault> {
    if seen == CONTROL_SCHEMA { Ok(()) } else { Err(ControlFault::Schema { seen, known: CONTROL_SCHEMA }) }
}

/// A field that must hold text, as text of its own.
pub(super) fn read_text(field: &[u8], what: &'static str) -> Result<String, ControlFault> {
    text::read(field).map(str::to_owned).ok_or(ControlFault::Text { what })
}

/// A number of entries, of which there must be room for `room`.
pub(super) fn check_count(seen: u32, room: usize, what: &'static str) -> Result<usize, ControlFault> {
    let count = seen as usize;
    if count <= room { Ok(count) } else { Err(ControlFault::Count { what, seen: count, room }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_kinds_and_outcomes_come_back() {
        for code in 1..4 {
            assert_eq!(RequestKind::from_code(code).unwrap().code(), code);
        }
        assert!(RequestKind::from_code(0).is_err() && RequestKind::from_code(4).is_err());
        for code in 0..3 {
            assert_eq!(Outcome::from_code(code).code(), code);
        }
        assert_eq!(Outcome::from_code(77), Outcome::Unknown);
    }
}
