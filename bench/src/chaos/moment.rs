//! One moment on the clocks by which processes can be compared.

use std::time::{SystemTime, UNIX_EPOCH};

use rustix::time::{ClockId, clock_gettime};

/// A moment: messages carry the start of their detector on `CLOCK_MONOTONIC` and that of their camera on the wall clock, and the
/// kernel keeps the start of a process on `CLOCK_BOOTTIME`. All in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) boot_ns: u64,
    pub(super) monotonic_ns: u64,
    pub(super) wall_ns: u64,
}

impl Moment {
    pub(super) fn now() -> Self {
        let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            boot_ns: boot_ns(),
            monotonic_ns: nanoseconds(ClockId::Monotonic),
            wall_ns: wall.as_nanos() as u64,
        }
    }
}

pub(super) fn boot_ns() -> u64 {
    nanoseconds(ClockId::Boottime)
}

fn nanoseconds(clock: ClockId) -> u64 {
    let now = clock_gettime(clock);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}
