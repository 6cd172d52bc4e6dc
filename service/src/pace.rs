//! How fast frames come, how many were passed over, and when to worry.

use std::time::Duration;

use tagbus_message::frame::FrameHeader;

/// Frame time of a camera that has not said its own.
const UNKNOWN_FRAME_TIME: Duration = Duration::from_millis(100);
/// A deadline is never shorter: looking for the dead costs about as much as a search of a small frame.
const SHORTEST_DEADLINE: Duration = Duration::from_millis(50);
/// A deadline is never longer, also after many misses.
const LONGEST_DEADLINE: Duration = Duration::from_secs(1);
/// Frame times that a camera may be silent for.
const FRAME_TIMES: u32 = 3;

/// The rhythm of one camera.
#[derive(Debug)]
pub(crate) struct Pace {
    last: Option<(u64, u64)>,
    frame_time: Duration,
    deadline: Duration,
}

/// What a frame's number says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// Sequence numbers that were passed over.
    pub(crate) skipped: u64,
    /// Whether the camera was started anew.
    pub(crate) new_epoch: bool,
}

impl Pace {
    pub(crate) fn new() -> Self {
        let deadline = deadline_of(UNKNOWN_FRAME_TIME);
        Self { last: None, frame_time: UNKNOWN_FRAME_TIME, deadline }
    }

    /// Takes note of a frame whose header was checked.
    pub(crate) fn step(&mut self, header: &FrameHeader) -> Step {
        if header.frame_time_ns > 0 {
            self.frame_time = Duration::from_nanos(header.frame_time_ns);
        }
        self.deadline = deadline_of(self.frame_time);
        let last = self.last.replace((header.epoch, header.sequence));
        match last {
            Some((epoch, sequence)) if epoch == header.epoch => {
                // A camera whose numbers go back skips nothing; it only counts badly.
                let skipped = header.sequence.saturating_sub(sequence).saturating_sub(1);
                Step { skipped, new_epoch: false }
            }
            _ => Step { skipped: 0, new_epoch: true },
        }
    }

    /// How long to wait for the next frame before looking for the dead.
    pub(crate) fn deadline(&self) -> Duration {
        self.deadline
    }

    /// Takes note of a missed deadline: while a camera stays silent, looking gets rarer.
    pub(crate) fn missed(&mut self) {
        self.deadline = (self.deadline * 2).min(LONGEST_DEADLINE);
    }
}

fn deadline_of(frame_time: Duration) -> Duration {
    frame_time.saturating_mul(FRAME_TIMES).clamp(SHORTEST_DEADLINE, LONGEST_DEADLINE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(epoch: u64, sequence: u64) -> FrameHeader {
        FrameHeader { epoch, sequence, ..FrameHeader::default() }
    }

    #[test]
    fn gaps_are_counted_within_an_epoch_only() {
        let mut pace = Pace::new();
        let mut step = |epoch, sequence| pace.step(&frame(epoch, sequence));
        assert_eq!(step(1, 5), Step { skipped: 0, new_epoch: true });
        assert_eq!(step(1, 6), Step { skipped: 0, new_epoch: false });
        assert_eq!(step(1, 10), Step { skipped: 3, new_epoch: false });
        assert_eq!(step(2, 90), Step { skipped: 0, new_epoch: true });
        assert_eq!(step(2, 3), Step { skipped: 0, new_epoch: false });
        assert_eq!(step(2, u64::MAX), Step { skipped: u64::MAX - 4, new_epoch: false });
    }

    #[test]
    fn the_deadline_is_three_frame_times_and_grows_with_silence() {
        let mut pace = Pace::new();
        assert_eq!(pace.deadline(), Duration::from_millis(300));
        pace.step(&FrameHeader { frame_time_ns: 40_000_000, ..frame(1, 1) });
        assert_eq!(pace.deadline(), Duration::from_millis(120));
        pace.missed();
        assert_eq!(pace.deadline(), Duration::from_millis(240));
        for _ in 0..20 {
            pace.missed();
        }
        assert_eq!(pace.deadline(), LONGEST_DEADLINE);
        pace.step(&frame(1, 2));
        assert_eq!(pace.deadline(), Duration::from_millis(120));
        pace.step(&FrameHeader { frame_time_ns: u64::MAX, ..frame(1, 3) });
        assert_eq!(pace.deadline(), LONGEST_DEADLINE);
    }
}
