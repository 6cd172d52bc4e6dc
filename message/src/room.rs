//! Room in shared memory.
//!
//! A full `/dev/shm` does not refuse memory when it is reserved: it kills the process that touches it (SIGBUS). So whoever comes
//! onto the bus looks first, frames and detections are written into pages that are there ([`crate::ports::Output::lend`]), and what is sent now
//! and then is left out while room is short.

use std::path::Path;

/// Where Linux keeps POSIX shared memory.
pub const SHARED_MEMORY: &str = "/dev/shm";

/// What helps when it is full.
pub const MORE_ROOM: &str = "remove what fills it (`ls -lS /dev/shm`), or enlarge it (`sudo mount -o remount,size=256M /dev/shm`; \
                             docker: --shm-size)";

/// More than a role touches when it joins a topic: its queues and its place among the others.
pub const TO_JOIN: u64 = 1 << 20;

/// More than a single message of any topic but frames and detections takes.
const FOR_A_MESSAGE: u64 = 64 << 10;

/// Bytes that are free; `None` where that cannot be asked.
#[must_use]
pub fn available() -> Option<u64> {
    available_in(Path::new(SHARED_MEMORY))
}

/// [`available`], of another place.
#[must_use]
pub fn available_in(place: &Path) -> Option<u64> {
    let about = rustix::fs::statvfs(place).ok()?;
    Some(about.f_bavail.saturating_mul(about.f_frsize))
}

/// Whether a message that touches new pages might find none.
pub(crate) fn is_short() -> bool {
    available().is_some_and(|free| free < FOR_A_MESSAGE)
}

/// Whether a role can join; the bytes that are free when it cannot.
pub(crate) fn check() -> Result<(), u64> {
    // Without an answer the topic's own error is the better one.
    match available() {
        Some(free) if free < TO_JOIN => Err(free),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_cannot_be_measured_has_no_answer_and_one_that_can_has() {
        assert_eq!(available_in(Path::new("/no/such/place")), None);
        assert!(available_in(Path::new("/")).is_some());
    }
}
