//! The driver's stamps and numbers, believed only as far as they can be true.

use std::time::Duration;

use tagbus_message::clock;
use tagbus_message::frame::{CaptureKind, ClockKind};

use crate::outlet::Outlet;
use crate::publish::Moment;
use crate::run::CameraEvent;

/// What a driver says about a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DriverStamp {
    /// Its number of the frame.
    pub(crate) sequence: u32,
    /// Nanoseconds.
    pub(crate) stamp_ns: u64,
    /// Whether the stamp is of `CLOCK_MONOTONIC`.
    pub(crate) monotonic: bool,
    /// What the stamp marks.
    pub(crate) kind: CaptureKind,
}

/// A stamp may be this many frame times old: a driver's queue holds four frames, and one more is on its way.
const LONGEST_AGE_FRAMES: u32 = 8;

/// ... and this old at least, because a busy machine lets a process wait longer than that.
const LONGEST_AGE: Duration = Duration::from_secs(1);

/// Larger steps of the driver's numbers are a driver that began anew, not so many frames lost.
const LARGEST_GAP: u32 = 1 << 16;

/// Watches the stamps and numbers of one stream.
#[derive(Debug)]
pub(crate) struct Stamps {
    longest_age_ns: u64,
    last_ns: u64,
    last_sequence: Option<u32>,
    /// Stamps that could not be true.
    refused: u64,
}

impl Stamps {
    pub(crate) fn new(frame_time: Duration) -> Stamps {
        let longest_age = LONGEST_AGE.max(frame_time * LONGEST_AGE_FRAMES);
        Stamps { longest_age_ns: longest_age.as_nanos() as u64, last_ns: 0, last_sequence: None, refused: 0 }
    }

    /// Frames that the driver lost since the one before.
    fn lost(&mut self, frame: &DriverStamp) -> u64 {
        let last = self.last_sequence.replace(frame.sequence);
        let step = last.map_or(1, |last| frame.sequence.wrapping_sub(last));
        if (1..=LARGEST_GAP).contains(&step) { u64::from(step - 1) } else { 0 }
    }

    /// When the frame was taken: what the driver says, unless it names no clock or cannot be right. Then the reason is said,
    /// and the moment is that at which this process got the frame.
    fn moment(&mut self, frame: &DriverStamp, dequeue_ns: u64) -> (Moment, Option<String>) {
        if !frame.monotonic {
            return (Moment::dequeued(dequeue_ns), None);
        }
        if let Some(wrong) = self.what_is_wrong(frame.stamp_ns, dequeue_ns) {
            self.refused += 1;
            return (Moment::dequeued(dequeue_ns), Some(wrong));
        }
        self.last_ns = frame.stamp_ns;
        let clock = ClockKind::Monotonic;
        (Moment { capture_ns: frame.stamp_ns, clock, kind: frame.kind, dequeue_ns }, None)
    }

    /// Stamp and number of a frame that was just taken; what the driver lost and stamps that cannot be right are counted and told.
    pub(crate) fn take_note(&mut self, frame: &DriverStamp, outlet: &mut Outlet) -> Moment {
        let dequeue_ns = clock::monotonic_ns();
        outlet.lost.in_driver += self.lost(frame);
        let (moment, wrong) = self.moment(frame, dequeue_ns);
        if wrong.is_some() {
            outlet.count_refused_stamp();
        }
        // A driver whose stamps are all wrong is told of now and then.
        if let Some(reason) = wrong
            && self.refused.is_power_of_two()
        {
            outlet.tell(CameraEvent::StampRefused { reason, total: self.refused });
        }
        moment
    }

    fn what_is_wrong(&self, stamp_ns: u64, dequeue_ns: u64) -> Option<String> {
        let (stamp_ms, limit_ms) = (stamp_ns / 1_000_000, self.longest_age_ns / 1_000_000);
        if stamp_ns > dequeue_ns {
            return Some(format!("it lies {} us in the future", (stamp_ns - dequeue_ns) / 1000));
        }
        if dequeue_ns - stamp_ns > self.longest_age_ns {
            let age_ms = (dequeue_ns - stamp_ns) / 1_000_000;
            return Some(format!(
                "it is {age_ms} ms old (at {stamp_ms} ms), and at most {limit_ms} ms can be"
            ));
        }
        if stamp_ns <= self.last_ns {
            return Some(format!(
                "it is not later than the one before, by {} us",
                (self.last_ns - stamp_ns) / 1000
            ));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn frame(sequence: u32, stamp_ns: u64) -> DriverStamp {
        DriverStamp { sequence, stamp_ns, monotonic: true, kind: CaptureKind::StartOfExposure }
    }

    fn stamps() -> Stamps {
        Stamps::new(Duration::from_millis(33))
    }

    #[test]
    fn a_stamp_that_can_be_true_is_passed_on_with_its_clock_and_what_it_marks() {
        let mut stamps = stamps();
        let (moment, wrong) = stamps.moment(&frame(0, 5000 * MS), 5010 * MS);
        assert_eq!((moment.capture_ns, moment.dequeue_ns, wrong), (5000 * MS, 5010 * MS, None));
        assert_eq!((moment.clock, moment.kind), (ClockKind::Monotonic, CaptureKind::StartOfExposure));
        let end = DriverStamp { kind: CaptureKind::EndOfFrame, ..frame(1, 5033 * MS) };
        assert_eq!(stamps.moment(&end, 5040 * MS).0.kind, CaptureKind::EndOfFrame);
    }

    #[test]
    fn a_stamp_that_cannot_be_true_is_replaced_by_the_time_of_the_dequeue_and_the_reason_is_said() {
        let mut stamps = stamps();
        assert!(stamps.moment(&frame(0, 9000 * MS), 9001 * MS).1.is_none());
        let cases = [
            (9002 * MS, 9001 * MS, "1000 us in the future"),
            (9000 * MS, 9033 * MS, "not later than the one before"),
            (0, 9033 * MS, "9033 ms old"),
        ];
        for (stamp, now, text) in cases {
            let (moment, wrong) = stamps.moment(&frame(1, stamp), now);
            assert_eq!(moment, Moment::dequeued(now));
            assert!(wrong.as_deref().is_some_and(|wrong| wrong.contains(text)), "{wrong:?} {text}");
        }
        assert_eq!(stamps.refused, 3);
        assert!(stamps.moment(&frame(2, 9066 * MS), 9070 * MS).1.is_none(), "the next good one counts again");
    }

    #[test]
    fn a_stamp_of_no_clock_is_no_fault_and_not_used() {
        let mut stamps = stamps();
        let nameless = DriverStamp { monotonic: false, ..frame(0, 7) };
        assert_eq!(stamps.moment(&nameless, 9 * MS), (Moment::dequeued(9 * MS), None));
        assert_eq!(stamps.refused, 0);
    }

    #[test]
    fn gaps_in_the_drivers_numbers_are_counted_also_where_they_wrap() {
        let mut stamps = stamps();
        let lost: Vec<u64> =
            [7, 8, 11, 11, u32::MAX, 0, 2].map(|sequence| stamps.lost(&frame(sequence, 0))).into();
        assert_eq!(lost, [0, 0, 2, 0, 0, 0, 1]);
    }
}
