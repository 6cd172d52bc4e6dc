//! Frames with their headers onto the bus.

use std::time::Duration;

use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::ipc;
use tagbus_message::clock;
use tagbus_message::frame::{CaptureKind, ClockKind, FrameHeader};
use tagbus_message::ports::FramesOut;

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

/// Frames that were given up before a frame, by cause.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Lost {
    pub(crate) damaged: u64,
    pub(crate) no_loan: u64,
}

/// Publishes frames: numbers them, stamps them, sends, then wakes.
pub(crate) struct FramePublisher {
    frames: FramesOut<ipc::Service>,
    epoch: Epoch,
    largest: FrameShape,
    /// The header of the last shape, which the next frame usually has too.
    shape: FrameShape,
    template: FrameHeader,
    next_sequence: u64,
}

impl FramePublisher {
    pub(crate) fn new(frames: FramesOut<ipc::Service>, epoch: Epoch, largest: FrameShape) -> FramePublisher {
        let template = largest.header();
        FramePublisher { frames, epoch, largest, shape: largest, template, next_sequence: 0 }
    }

    /// Memory for the next frame.
    pub(crate) fn loan(&self) -> Result<Loan, LoanError> {
        Loan::take(self.frames.publisher(), self.largest.bytes())
    }

    /// Sends a filled loan, then wakes whoever waits. `asked_ns` is when the source was asked for the frame.
    ///
    /// Frames that were lost before it leave a gap in the sequence.
    pub(crate) fn send(
        &mut self,
        loan: Loan,
        filled: Filled,
        asked_ns: u64,
        lost: Lost,
    ) -> Result<(), SendError> {
        if filled.shape != self.shape {
            (self.shape, self.template) = (filled.shape, filled.shape.header());
        }
        let sequence = self.next_sequence + lost.damaged + lost.no_loan;
        self.next_sequence = sequence + 1;
        loan.send(FrameHeader {
            epoch: self.epoch.number,
            sequence,
            copies: filled.copies.into(),
            // These sources have no better moment than this one.
            capture_ns: asked_ns,
            capture_clock: ClockKind::Monotonic.code(),
            capture_kind: CaptureKind::Dequeue.code(),
            dequeue_ns: asked_ns,
            publish_ns: clock::monotonic_ns(),
            frame_time_ns: self.epoch.frame_time.as_nanos() as u64,
            info_number: self.epoch.info_number,
            lost_damaged: lost.damaged.try_into().unwrap_or(u32::MAX),
            lost_no_loan: lost.no_loan.try_into().unwrap_or(u32::MAX),
            ..self.template
        })?;
        if self.frames.notify().is_err() {
            // A listener died without leaving; with its remains away the next frame wakes the others as ever.
            self.frames.bus().clean_up_dead();
        }
        Ok(())
    }

    /// Gives back what dead subscribers hold.
    pub(crate) fn clean_up_dead(&self) -> u64 {
        self.frames.bus().clean_up_dead()
    }
}
