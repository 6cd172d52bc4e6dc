//! Shared memory for one frame, lent by the publisher. The one file of this crate with unsafe code.
//!
//! ```text
//! payload   | 0 to 63 bytes to spare | the picture, at a multiple of 64 bytes ...          |
//!           └ data_offset ───────────┘ picture() ──────────────────────────────────────────┘
//! ```

use std::io;

use iceoryx2::port::LoanError;
use iceoryx2::port::SendError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::sample_mut::SampleMut;
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};
use rustix::param::page_size;
use tagbus_message::Local;
use tagbus_message::frame::{FrameHeader, PICTURE_ALIGNMENT};

/// Bytes that a loan for a picture of `picture_bytes` must have, so that the picture can be aligned in it.
pub(crate) fn payload_bytes(picture_bytes: usize) -> usize {
    picture_bytes + PICTURE_ALIGNMENT
}

/// More than iceoryx2 writes before a payload: its own header and ours.
const NEXT_HEADER: usize = 512;

/// Has the kernel provide the pages of memory that begins at the start of a page.
fn provide(page: *mut u8, bytes: usize) -> Result<(), Errno> {
    // SAFETY: the advice changes no byte and unmaps nothing: it does what a write of each page's own bytes would do. Where
    // nothing is mapped, or nothing may be written, it is an error.
    match unsafe { madvise(page.cast(), bytes, Advice::LinuxPopulateWrite) } {
        // Kernels before 5.14 do not know it. There a full /dev/shm stays what it was.
        Err(Errno::INVAL) => Ok(()),
        answer => answer,
    }
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
    /// Borrows memory for a picture of at most `picture_bytes` from the publisher's pool.
    pub(crate) fn take(
        publisher: &Publisher<Local, [u8], FrameHeader>,
        picture_bytes: usize,
    ) -> Result<Loan, LoanError> {
        let sample = publisher.loan_slice_uninit(payload_bytes(picture_bytes))?;
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

    /// The address of its memory, the same for each loan of the same piece.
    pub(crate) fn address(&mut self) -> usize {
        self.sample.payload_mut().as_ptr().addr()
    }

    /// Has the kernel provide every page of this memory now. Without that the first write into a full `/dev/shm` ends the process
    /// (SIGBUS); with it the page is there, or the answer is an error.
    ///
    /// Pieces are lent in the order in which they lie for the first time, so the next one's header, which is written before
    /// anybody could ask, begins where this one ends: its page is asked for as well.
    ///
    /// # Errors
    /// Shared memory is full.
    pub(crate) fn provide_pages(&mut self) -> io::Result<()> {
        let payload = self.sample.payload_mut();
        let (start, bytes) = (payload.as_mut_ptr(), payload.len());
        let within_page = start.addr() % page_size();
        provide(start.wrapping_sub(within_page), within_page + bytes)?;
        let end = start.wrapping_add(bytes + NEXT_HEADER);
        match provide(end.wrapping_sub(end.addr() % page_size()), 1) {
            // Behind the last piece nothing is mapped.
            Err(Errno::NOMEM) => Ok(()),
            answer => Ok(answer?),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_message::bus::Bus;
    use tagbus_message::domain::Domain;
    use tagbus_message::qos::FRAMES;
    use tagbus_message::stop::Stop;

    #[test]
    fn pieces_are_lent_in_the_order_in_which_they_lie_so_that_the_header_of_the_next_has_its_page() {
        let name = format!("loan-{}", std::process::id());
        let domain = Domain::with_root(&name, std::env::temp_dir().join(&name)).unwrap();
        let bus = Bus::<Local>::start(&domain, "camera", &Stop::new().unwrap()).unwrap();
        let frames = bus.create_frames("cam0", &FRAMES, payload_bytes(10_000)).unwrap();
        let mut loans: Vec<Loan> = Vec::new();
        for _ in 0..FRAMES.loans {
            let mut loan = Loan::take(frames.publisher(), 10_000).unwrap();
            loan.provide_pages().unwrap();
            loan.picture().fill(7);
            if let Some(last) = loans.last_mut() {
                let gap = loan.address() - last.address() - payload_bytes(10_000);
                assert!(gap > 0 && gap < NEXT_HEADER, "{gap} bytes between two payloads");
            }
            loans.push(loan);
        }
    }
}
