//! Frames with their headers onto the bus.

use std::time::Duration;

use iceoryx2::port::SendError;
use tagbus_message::Local;
use tagbus_message::clock;
use tagbus_message::frame::{CaptureKind, ClockKind, FrameHeader};
use tagbus_message::info::CameraInfo;
use tagbus_message::ports::{FramesOut, LendError};
use tagbus_message::stats::{CAMERA_HOPS, CameraStats};
use tagbus_message::tally::{Tally, UNKNOWN, between};

use crate::format::FrameShape;
use crate::loan::Loan;
use crate::source::Filled;

/// Numbers of one run of a camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Epoch {
    /// The wall clock at the start in nanoseconds: another number at each start.
    pub(crate) number: u64,
    /// The camera information that applies.
    pub(crate) info_number: u32,
    /// Nominal time from frame to frame; zero when there is none.
    pub(crate) frame_time: Duration,
}

/// Places in [`tagbus_message::stats::CAMERA_HOPS`].
const CAPTURE: usize = 0;
const PUBLISH: usize = 1;

/// When a frame was taken, and when this process got it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Moment {
    /// Nanoseconds of the clock that is named.
    pub(crate) capture_ns: u64,
    pub(crate) clock: ClockKind,
    pub(crate) kind: CaptureKind,
    /// `CLOCK_MONOTONIC` nanoseconds.
    pub(crate) dequeue_ns: u64,
}

impl Moment {
    /// A frame of which no better moment is known than when this process got it.
    pub(crate) fn dequeued(dequeue_ns: u64) -> Moment {
        let (clock, kind) = (ClockKind::Monotonic, CaptureKind::Dequeue);
        Moment { capture_ns: dequeue_ns, clock, kind, dequeue_ns }
    }
}

/// Frames that were given up before a frame, by cause.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Lost {
    pub(crate) in_driver: u64,
    pub(crate) damaged: u64,
    pub(crate) no_loan: u64,
}

impl Lost {
    fn all(self) -> u64 {
        self.in_driver + self.damaged + self.no_loan
    }
}

/// Publishes frames: numbers them, stamps them, sends, then wakes.
pub(crate) struct FramePublisher {
    frames: FramesOut<Local>,
    epoch: Epoch,
    largest: FrameShape,
    /// The header of the last shape, which the next frame usually has too.
    shape: FrameShape,
    template: FrameHeader,
    next_sequence: u64,
    exposure_ns: u64,
    stats: Box<CameraStats>,
    tally: Tally<{ CAMERA_HOPS.len() }>,
}

impl FramePublisher {
    pub(crate) fn new(frames: FramesOut<Local>, epoch: Epoch, largest: FrameShape) -> FramePublisher {
        let template = largest.header();
        let stats = Box::new(CameraStats {
            epoch: epoch.number,
            started_ns: clock::monotonic_ns(),
            reserved_bytes: frames.reserved().bytes() as u64,
            ..CameraStats::default()
        });
        FramePublisher {
            frames,
            epoch,
            largest,
            shape: largest,
            template,
            next_sequence: 0,
            exposure_ns: 0,
            stats,
            tally: Tally::default(),
        }
    }

    /// Format and size of the largest frame.
    #[cfg(any(feature = "v4l", feature = "libcamera"))]
    pub(crate) fn largest(&self) -> FrameShape {
        self.largest
    }

    /// Memory for the next frame, which can be written.
    pub(crate) fn loan(&self) -> Result<Loan, LendError> {
        Loan::take(&self.frames, self.largest.bytes())
    }

    /// From here on this camera information applies.
    pub(crate) fn set_info(&mut self, info: &CameraInfo) {
        self.epoch.info_number = info.number;
        self.exposure_ns = info.exposure_ns;
    }

    /// Sends a filled loan, then wakes whoever waits.
    ///
    /// Frames that were lost before it leave a gap in the sequence.
    pub(crate) fn send(
        &mut self,
        loan: Loan,
        filled: Filled,
        moment: Moment,
        lost: Lost,
    ) -> Result<(), SendError> {
        if filled.shape != self.shape {
            (self.shape, self.template) = (filled.shape, filled.shape.header());
        }
        let sequence = self.next_sequence + lost.all();
        self.next_sequence = sequence + 1;
        let publish_ns = clock::monotonic_ns();
        loan.send(FrameHeader {
            epoch: self.epoch.number,
            sequence,
            copies: filled.copies.into(),
            capture_ns: moment.capture_ns,
            capture_clock: moment.clock.code(),
            capture_kind: moment.kind.code(),
            dequeue_ns: moment.dequeue_ns,
            publish_ns,
            frame_time_ns: self.epoch.frame_time.as_nanos() as u64,
            exposure_ns: self.exposure_ns,
            info_number: self.epoch.info_number,
            lost_in_driver: lost.in_driver.try_into().unwrap_or(u32::MAX),
            lost_damaged: lost.damaged.try_into().unwrap_or(u32::MAX),
            lost_no_loan: lost.no_loan.try_into().unwrap_or(u32::MAX),
            ..self.template
        })?;
        if self.frames.notify().is_err() {
            // A listener died without leaving; with its remains away the next frame wakes the others as ever.
            self.frames.bus().clean_up_dead();
        }
        self.count(&filled, moment, publish_ns, lost);
        Ok(())
    }

    /// The exposure time of the frames from now on, nanoseconds; 0 when it is not known.
    #[cfg(feature = "libcamera")]
    pub(crate) fn note_exposure(&mut self, exposure_ns: u64) {
        self.exposure_ns = exposure_ns;
    }

    fn count(&mut self, filled: &Filled, moment: Moment, publish_ns: u64, lost: Lost) {
        let stats = &mut self.stats;
        stats.frames += 1;
        stats.copied += u64::from(filled.copies > 0);
        stats.lost_in_driver += lost.in_driver;
        stats.lost_damaged += lost.damaged;
        stats.lost_no_loan += lost.no_loan;
        let mut hops = [UNKNOWN; CAMERA_HOPS.len()];
        if moment.kind != CaptureKind::Dequeue && moment.clock == ClockKind::Monotonic {
            hops[CAPTURE] = between(moment.capture_ns, moment.dequeue_ns);
        }
        hops[PUBLISH] = between(moment.dequeue_ns, publish_ns);
        self.tally.frame(hops, &mut stats.hops);
    }

    /// Counts a stamp that cannot be right.
    #[cfg(any(feature = "v4l", feature = "libcamera"))]
    pub(crate) fn count_refused_stamp(&mut self) {
        self.stats.hops[CAPTURE].backwards += 1;
    }

    /// What was counted, with the memory that is in use now.
    pub(crate) fn stats(&mut self, state: u32) -> &CameraStats {
        self.tally.count(&mut self.stats.hops);
        self.stats.state = state;
        self.stats.touched_bytes = self.frames.touched_bytes().unwrap_or(0);
        self.stats.written_ns = clock::monotonic_ns();
        &self.stats
    }

    /// Whether those who come still find the topic.
    pub(crate) fn is_in_place(&self) -> bool {
        self.frames.is_in_place()
    }

    /// Gives back what dead subscribers hold.
    pub(crate) fn clean_up_dead(&self) -> u64 {
        self.frames.bus().clean_up_dead()
    }
}
