//! What a service says while it runs, at its end, and when it cannot go on.

use std::fmt;
use std::time::{Duration, Instant};

use tagbus_detector::SettingsError;
use tagbus_message::bus::BusError;
use tagbus_message::qos::Reserved;
use tagbus_message::text::TextTooLong;
use tagbus_message::wait::WaitError;

/// Something that a user may want to know.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Report {
    /// The detections topic is there; now the camera is waited for.
    Ready {
        /// Memory of the detections topic.
        reserved: Reserved,
        /// Bytes of it that take room already.
        touched: u64,
    },
    /// The camera's frames topic was found.
    Connected,
    /// A frame was refused because its header does not fit its bytes.
    Refused {
        /// The frame's sequence number, as its header says.
        sequence: u64,
        /// What is wrong with it.
        reason: String,
        /// Frames refused since the start.
        total: u64,
    },
    /// No frame came for three frame times.
    Silent {
        /// The time that was waited.
        waited: Duration,
        /// Dead processes that were cleaned up because of it.
        dead: u64,
    },
    /// Frames come again after a silence.
    Back,
    /// The topic's files in shared memory were removed by force; the service begins anew.
    Removed,
    /// Somebody changed parameters, in force from the next frame on. Of many changes the first ten of each second are told.
    Changed {
        /// The change's number, which headers of messages name.
        number: u64,
        /// The parameters that differ.
        what: String,
    },
    /// A message could not be sent, a frame not be received, or a change not be made; work goes on.
    Trouble {
        /// What went wrong.
        reason: String,
    },
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ready { reserved, touched } => {
                let megabytes = *touched as f64 / 1e6;
                write!(f, "detections: {reserved} ({megabytes:.1} MB so far); waiting for the camera")
            }
            Self::Connected => write!(f, "connected to the camera"),
            Self::Refused { sequence, reason, total } => {
                write!(f, "frame {sequence} skipped: {reason} ({total} refused so far)")
            }
            Self::Silent { waited, dead } => write!(
                f,
                "no frame for {:.1} s: is the camera running? ({dead} dead processes cleaned up)",
                waited.as_secs_f64()
            ),
            Self::Back => write!(f, "frames arrive again"),
            Self::Removed => write!(
                f,
                "its files in /dev/shm were removed (logind does that at logout, see RemoveIPC=): beginning anew"
            ),
            Self::Changed { number, what } => write!(f, "change {number}: {what}"),
            Self::Trouble { reason } => write!(f, "{reason}"),
        }
    }
}

/// Lets the first reports of each second through; a hostile camera or client must not fill a disk with words.
#[derive(Debug)]
pub(crate) struct Limiter {
    most: u32,
    second: Option<Instant>,
    seen: u32,
}

impl Limiter {
    const EVERY: Duration = Duration::from_secs(1);

    /// At most so many a second.
    pub(crate) fn of(most: u32) -> Self {
        Self { most, second: None, seen: 0 }
    }

    pub(crate) fn lets_through(&mut self, now: Instant) -> bool {
        if self.second.is_none_or(|begin| now.duration_since(begin) >= Self::EVERY) {
            (self.second, self.seen) = (Some(now), 0);
        }
        self.seen = self.seen.saturating_add(1);
        self.seen <= self.most
    }
}

/// What a service did from its start to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Frames that were searched.
    pub frames_searched: u64,
    /// Sequence numbers that were passed over: no time for them, or lost by the camera.
    pub frames_skipped: u64,
    /// Frames whose header did not fit their bytes.
    pub frames_refused: u64,
    /// Frames that were not searched because nobody subscribed.
    pub frames_unwatched: u64,
    /// Tags found.
    pub tags_found: u64,
    /// Messages sent.
    pub messages_sent: u64,
    /// Time spent searching, nanoseconds.
    pub search_ns: u64,
    /// Starts of the camera that were seen.
    pub camera_starts: u64,
    /// Times that no frame came for three frame times.
    pub deadlines_missed: u64,
    /// Dead processes cleaned up.
    pub dead_cleaned: u64,
}

/// Why a service could not start or go on.
#[derive(Debug)]
#[non_exhaustive]
pub enum ServiceError {
    /// The bus cannot be used.
    Bus(BusError),
    /// A setting is out of range.
    Settings(SettingsError),
    /// A family's name is too long for a message.
    Family(TextTooLong),
    /// The operating system refuses to wait.
    Wait(WaitError),
}

impl fmt::Display for ServiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(error) => error.fmt(f),
            Self::Settings(error) => error.fmt(f),
            Self::Family(error) => error.fmt(f),
            Self::Wait(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ServiceError {}

impl From<BusError> for ServiceError {
    fn from(error: BusError) -> Self {
        Self::Bus(error)
    }
}

impl From<WaitError> for ServiceError {
    fn from(error: WaitError) -> Self {
        Self::Wait(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_reports_so_many_a_second_come_through() {
        let start = Instant::now();
        for (most, expected) in [(1, 3), (4, 12), (100, 30)] {
            let mut limiter = Limiter::of(most);
            let times = (0..30).map(|tenth| start + Duration::from_millis(100 * tenth));
            assert_eq!(times.filter(|&time| limiter.lets_through(time)).count(), expected);
        }
    }
}
