//! The flight recorder: what every role counts about itself all the time, for anybody who looks.
//!
//! ```text
//!            CameraStats              DetectorStats                                ClientStats
//! exposure ─ capture ─ publish ─▶ receive ─ start ─ detect (its phases) ─ send ─▶ deliver
//!          ╰───────────────────────────────── total ─────────────────────────────────────╯
//! ```
//!
//! Each role publishes a copy twice a second, after its other work. Numbers only grow while a role runs; whoever wants to
//! know about the last seconds takes the difference of two copies ([`crate::histogram::Histogram::since`]).

use std::fmt;
use std::mem::size_of;
use std::time::Duration;

use iceoryx2::prelude::ZeroCopySend;

use crate::histogram::Histogram;
use crate::text;

/// The layout of the messages here that this code writes and reads.
pub const STATS_SCHEMA: u32 = 1;
/// How often a role publishes a copy.
pub const STATS_PERIOD: Duration = Duration::from_millis(500);
/// Bytes that a client's name may take.
pub const CLIENT_NAME_BYTES: usize = 64;

/// The hops that a camera measures. `capture` leads from the moment that the stamp marks to when the process got the frame.
pub const CAMERA_HOPS: [&str; 2] = ["capture", "publish"];
/// The hops that a detector measures. `receive` begins when the camera published; the four after `start` are the phases of `detect`;
/// `wake` is the time that it takes to wake the clients, after a message was sent.
pub const DETECTOR_HOPS: [&str; 9] =
    ["receive", "start", "binarize", "cluster", "fit", "identify", "detect", "send", "wake"];
/// The hops that a client measures. `deliver` begins when the detector sent; `total` when the stamp of the capture says, or else
/// when the camera process got the frame.
pub const CLIENT_HOPS: [&str; 2] = ["deliver", "total"];

/// What a camera counts. Stamps are `CLOCK_MONOTONIC` nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.CameraStats.v1")]
pub struct CameraStats {
    /// Always [`STATS_SCHEMA`].
    pub schema: u32,
    /// A [`crate::info::CameraState`] code.
    pub state: u32,
    /// The process.
    pub process: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// Epoch of the camera: another number at each start.
    pub epoch: u64,
    /// When it began.
    pub started_ns: u64,
    /// When this copy was written.
    pub written_ns: u64,
    /// Frames published.
    pub frames: u64,
    /// Frames lost by driver or device.
    pub lost_in_driver: u64,
    /// Frames lost because they were damaged.
    pub lost_damaged: u64,
    /// Frames lost because there was no memory for them.
    pub lost_no_loan: u64,
    /// Frames of which a copy was made.
    pub copied: u64,
    /// Bytes of memory that the frames topic has reserved.
    pub reserved_bytes: u64,
    /// Bytes of those that were ever written.
    pub touched_bytes: u64,
    /// In the order of [`CAMERA_HOPS`].
    pub hops: [Histogram; CAMERA_HOPS.len()],
}

/// What a detector counts. Stamps are `CLOCK_MONOTONIC` nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.DetectorStats.v1")]
pub struct DetectorStats {
    /// Always [`STATS_SCHEMA`].
    pub schema: u32,
    /// A [`crate::control::DetectorState`] code.
    pub state: u32,
    /// The process.
    pub process: u32,
    /// Subscribers of its detections.
    pub subscribers: u32,
    /// Another number at each start of the detector.
    pub epoch: u64,
    /// When it began.
    pub started_ns: u64,
    /// When this copy was written.
    pub written_ns: u64,
    /// Frames searched.
    pub searched: u64,
    /// Frames passed over: no time for them, or lost by the camera.
    pub skipped: u64,
    /// Frames whose header did not fit their bytes.
    pub refused: u64,
    /// Frames that nobody wanted searched.
    pub unwatched: u64,
    /// Tags found.
    pub tags: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes of memory that the detections topic has reserved.
    pub reserved_bytes: u64,
    /// Bytes of those that were ever written.
    pub touched_bytes: u64,
    /// In the order of [`DETECTOR_HOPS`].
    pub hops: [Histogram; DETECTOR_HOPS.len()],
}

/// What a client of a detector counts. Stamps are `CLOCK_MONOTONIC` nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.ClientStats.v1")]
pub struct ClientStats {
    /// Always [`STATS_SCHEMA`].
    pub schema: u32,
    /// The process.
    pub process: u32,
    /// Another number for each client.
    pub epoch: u64,
    /// When it connected.
    pub started_ns: u64,
    /// When this copy was written.
    pub written_ns: u64,
    /// Epoch of the detector whose message was the last one.
    pub detector_epoch: u64,
    /// The number of that message.
    pub last_message: u64,
    /// Messages received.
    pub received: u64,
    /// Messages sent since the first one received, and not received: it was too slow.
    pub missed: u64,
    /// Messages that were of another version or contradicted themselves.
    pub refused: u64,
    /// What it calls itself; see [`crate::text`].
    pub name: [u8; CLIENT_NAME_BYTES],
    /// In the order of [`CLIENT_HOPS`].
    pub hops: [Histogram; CLIENT_HOPS.len()],
}

const _: () = {
    assert!(size_of::<CameraStats>() == 96 + 2 * size_of::<Histogram>());
    assert!(size_of::<DetectorStats>() == 104 + 9 * size_of::<Histogram>());
    assert!(size_of::<ClientStats>() == 136 + 2 * size_of::<Histogram>());
};

impl Default for CameraStats {
    fn default() -> Self {
        Self {
            schema: STATS_SCHEMA,
            state: 0,
            process: std::process::id(),
            reserved: 0,
            epoch: 0,
            started_ns: 0,
            written_ns: 0,
            frames: 0,
            lost_in_driver: 0,
            lost_damaged: 0,
            lost_no_loan: 0,
            copied: 0,
            reserved_bytes: 0,
            touched_bytes: 0,
            hops: Default::default(),
        }
    }
}

impl Default for DetectorStats {
    fn default() -> Self {
        Self {
            schema: STATS_SCHEMA,
            state: 0,
            process: std::process::id(),
            subscribers: 0,
            epoch: 0,
            started_ns: 0,
            written_ns: 0,
            searched: 0,
            skipped: 0,
            refused: 0,
            unwatched: 0,
            tags: 0,
            messages: 0,
            reserved_bytes: 0,
            touched_bytes: 0,
            hops: Default::default(),
        }
    }
}

impl Default for ClientStats {
    fn default() -> Self {
        Self {
            schema: STATS_SCHEMA,
            process: std::process::id(),
            epoch: 0,
            started_ns: 0,
            written_ns: 0,
            detector_epoch: 0,
            last_message: 0,
            received: 0,
            missed: 0,
            refused: 0,
            name: [0; CLIENT_NAME_BYTES],
            hops: Default::default(),
        }
    }
}

/// A message of the recorder: checked before it is believed.
pub trait Stats: Copy + fmt::Debug + ZeroCopySend + 'static {
    /// Version and histograms.
    fn parts(&self) -> (u32, &[Histogram]);

    /// Whether the message may be believed.
    fn checked(&self) -> Result<(), StatsError> {
        let (seen, hops) = self.parts();
        if seen != STATS_SCHEMA {
            return Err(StatsError::Schema { seen, known: STATS_SCHEMA });
        }
        match hops.iter().position(|hop| !hop.is_sound()) {
            Some(hop) => Err(StatsError::Histogram { hop }),
            None => Ok(()),
        }
    }
}

impl Stats for CameraStats {
    fn parts(&self) -> (u32, &[Histogram]) {
        (self.schema, &self.hops)
    }
}

impl Stats for DetectorStats {
    fn parts(&self) -> (u32, &[Histogram]) {
        (self.schema, &self.hops)
    }
}

impl Stats for ClientStats {
    fn parts(&self) -> (u32, &[Histogram]) {
        (self.schema, &self.hops)
    }
}

impl ClientStats {
    /// What the client calls itself; "?" when the field holds no text.
    #[must_use]
    pub fn name(&self) -> &str {
        text::read(&self.name).unwrap_or("?")
    }
}

/// What a message of the recorder says that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StatsError {
    /// It is of another version.
    Schema {
        /// The version that the message names.
        seen: u32,
        /// The version that this code reads.
        known: u32,
    },
    /// The buckets of a histogram do not hold as many as it counts, or its shortest is longer than its longest.
    Histogram {
        /// The place of the histogram among the hops.
        hop: usize,
    },
}

impl fmt::Display for StatsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schema { seen, known } => {
                write!(f, "statistics of version {seen}, but this program reads version {known}")
            }
            Self::Histogram { hop } => write!(f, "the histogram of hop {hop} contradicts itself"),
        }
    }
}

impl std::error::Error for StatsError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_contradicts_itself_is_not_believed() {
        let mut stats = DetectorStats::default();
        stats.hops[8].count(5);
        assert_eq!(stats.checked(), Ok(()));
        stats.hops[8].count = 7;
        assert_eq!(stats.checked(), Err(StatsError::Histogram { hop: 8 }));
        let foreign = ClientStats { schema: 9, ..ClientStats::default() };
        assert!(foreign.checked().unwrap_err().to_string().contains("version 9"));
    }
}
