//! Shared memory for one frame, lent by the publisher. The one file of this crate with unsafe code.
//!
//! ```text
//! payload   | 0 to 63 bytes to spare | the picture, at a multiple of 64 bytes ...          |
//!           └ data_offset ───────────┘ picture() ──────────────────────────────────────────┘
//! ```

use iceoryx2::port::SendError;
use iceoryx2::sample_mut::SampleMut;
use tagbus_message::Local;
use tagbus_message::frame::{FrameHeader, PICTURE_ALIGNMENT};
use tagbus_message::ports::{FramesOut, LendError};

/// Bytes that a loan for a picture of `picture_bytes` must have, so that the picture can be aligned in it.
pub(crate) fn payload_bytes(picture_bytes: usize) -> usize {
    picture_bytes + PICTURE_ALIGNMENT
}

/// A loan that has not been sent yet; dropped, it goes back unsent.
///
/// It owns its place and can be moved and kept, several at a time: a driver's queue holds loans in the same way.
pub(crate) struct Loan {
    sample: SampleMut<Local, [u8], FrameHeader>,
    picture_bytes: usize,
    data_offset: usize,
}

impl Loan {
    /// Borrows memory for a picture of at most `picture_bytes` from the publisher's pool, with all its pages: a driver may write it.
    pub(crate) fn take(frames: &FramesOut<Local>, picture_bytes: usize) -> Result<Loan, LendError> {
        let sample = frames.lend(payload_bytes(picture_bytes))?;
        // SAFETY: every byte of the payload is initialised and every value is a valid u8: the payload lies in POSIX shared
        // memory, which the kernel hands out filled with zeros and into which afterwards only bytes are written;
        // iceoryx2 lends the slice without writing to it. The safe ways (`loan_slice`, `write_from_fn`) would write each
        // frame's memory once more before the frame itself is written.
        let mut sample = unsafe { sample.assume_init() };
        let start = sample.payload_mut().as_ptr().addr();
        // Segments are mapped at page boundaries in every process, so what is aligned here is aligned there.
        let data_offset = start.next_multiple_of(PICTURE_ALIGNMENT) - start;
        Ok(Loan { sample, picture_bytes, data_offset })
    }

    /// The picture's bytes. They still hold an earlier frame: only what is written counts.
    pub(crate) fn picture(&mut self) -> &mut [u8] {
        &mut self.sample.payload_mut()[self.data_offset..][..self.picture_bytes]
    }

    /// Publishes the picture with its header; the answer is the number of subscribers that got it.
    pub(crate) fn send(mut self, header: FrameHeader) -> Result<usize, SendError> {
        *self.sample.user_header_mut() = FrameHeader { data_offset: self.data_offset as u32, ..header };
        self.sample.send()
    }
}
