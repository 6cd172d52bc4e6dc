//! The one clock of all stamps, and its distance from the wall clock.

use iceoryx2_bb_posix::clock::{ClockType, Time};

/// Nanoseconds of `CLOCK_MONOTONIC`: comparable between all processes of a machine until it is booted again.
#[must_use]
pub fn monotonic_ns() -> u64 {
    read_ns(ClockType::Monotonic)
}

/// Wall clock minus `CLOCK_MONOTONIC` now, nanoseconds: add it to a stamp to get the time since 1970.
///
/// The wall clock is read between two readings of the other, so the error is half of the time that takes.
#[must_use]
pub fn wall_offset_ns() -> i64 {
    let before = monotonic_ns();
    let wall = read_ns(ClockType::Realtime);
    let after = monotonic_ns();
    wall as i64 - (before + (after - before) / 2) as i64
}

/// Both clocks exist on every Linux, where reading them cannot fail; 0 would be the answer elsewhere.
fn read_ns(clock: ClockType) -> u64 {
    Time::now_with_clock(clock).map_or(0, |time| time.as_duration().as_nanos() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    #[test]
    fn time_does_not_go_back() {
        let mut last = monotonic_ns();
        for _ in 0..10_000 {
            let now = monotonic_ns();
            assert!(now >= last && last > 0);
            last = now;
        }
    }

    #[test]
    fn a_sleep_takes_at_least_its_time() {
        let before = monotonic_ns();
        std::thread::sleep(Duration::from_millis(3));
        assert!(monotonic_ns() - before >= 3_000_000);
    }

    #[test]
    fn stamp_plus_offset_is_the_wall_clock() {
        let before = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs() as i64;
        let wall_s = (monotonic_ns() as i64 + wall_offset_ns()) / 1_000_000_000;
        assert!(wall_s >= before - 1);
    }
}
