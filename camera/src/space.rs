//! Room in shared memory.
//!
//! A full `/dev/shm` does not refuse memory when it is reserved: it kills the process that touches it (SIGBUS). So the room is
//! checked before anything is reserved, and the pages of each piece are asked for before it is written ([`tagbus_message::ports::Output::lend`]).

use std::fmt;
use std::path::Path;

use tagbus_message::qos::{Reserved, TopicQos};
use tagbus_message::room::{MORE_ROOM, SHARED_MEMORY, available_in};

/// Room in shared memory, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Space {
    /// What this camera reserves in all; it is touched only when every subscriber holds and queues all it may.
    pub reserved: u64,
    /// What is touched in normal work: loans, history and one subscriber.
    pub usual: u64,
    /// What is free now.
    pub available: u64,
}

impl Space {
    /// Measures the room for a frames topic whose frames have `payload_bytes`.
    ///
    /// # Errors
    /// Not even normal work fits.
    pub(crate) fn check(qos: &TopicQos, payload_bytes: usize) -> Result<Space, SpaceError> {
        Space::check_in(Path::new(SHARED_MEMORY), qos, payload_bytes)
    }

    fn check_in(place: &Path, qos: &TopicQos, payload_bytes: usize) -> Result<Space, SpaceError> {
        let reserved = Reserved::frames(qos, payload_bytes);
        let usual_chunks = qos.loans + qos.history + qos.buffer + qos.borrowed;
        let space = Space {
            reserved: reserved.bytes() as u64,
            usual: (usual_chunks * reserved.chunk_bytes) as u64,
            // Without an answer (no such folder) the topic's own error is the better one.
            available: available_in(place).unwrap_or(u64::MAX),
        };
        if space.available < space.usual { Err(SpaceError(space)) } else { Ok(space) }
    }

    /// Whether a case that is possible, though not usual, would not fit.
    #[must_use]
    pub fn is_tight(&self) -> bool {
        self.available < self.reserved
    }
}

/// Shared memory is too full for this camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpaceError(pub Space);

impl fmt::Display for SpaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Space { reserved, usual, available } = self.0;
        write!(
            f,
            "{SHARED_MEMORY} has {available} bytes free, but normal work touches {usual} (at most {reserved}): use smaller frames, \
             {MORE_ROOM}"
        )
    }
}

impl std::error::Error for SpaceError {}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_message::qos::FRAMES;

    #[test]
    fn small_frames_fit_and_frames_beyond_any_memory_are_refused_with_both_numbers() {
        let small = Space::check(&FRAMES, 64).unwrap();
        assert!(small.usual <= small.reserved);
        let error = Space::check(&FRAMES, 1 << 50).unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains(&error.0.available.to_string()) && text.contains(&error.0.usual.to_string()),
            "{text}"
        );
    }

    #[test]
    fn a_place_that_cannot_be_measured_stands_in_nobodys_way() {
        assert!(Space::check_in(Path::new("/no/such/place"), &FRAMES, 1 << 30).is_ok());
    }
}
