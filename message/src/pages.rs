//! Pages of lent memory, asked for before they are written.
//!
//! ```text
//! pieces | header | payload, as far as it is used |        ...        | header | payload ...
//!                 └ asked for ────────────────────┘                   └ asked for as well
//! ```
//!
//! The first write into a page of a full `/dev/shm` ends the process (SIGBUS). Asked for, the page is there, or the answer is an error.
//! Once a piece has its pages nothing is asked any more: from frame to frame this is a look into a short list.
#![allow(unsafe_code, reason = "one advice to the kernel, which changes no byte")]

use std::{fmt, io};

use iceoryx2::port::LoanError;
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};
use rustix::param::page_size;

use crate::room::{self, MORE_ROOM, SHARED_MEMORY};

/// More than iceoryx2 writes before a payload: its own header and ours.
const HEADERS: usize = 1024;

/// Why there is no memory for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LendError {
    /// Others hold all of it, or it is too little; iceoryx2's word for it.
    Taken(LoanError),
    /// Shared memory is full.
    Full {
        /// What the message takes.
        bytes: usize,
    },
}

impl fmt::Display for LendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken(error) => write!(f, "no memory is free ({error:?})"),
            Self::Full { bytes } => {
                write!(f, "{SHARED_MEMORY} is full: no room for {bytes} bytes; {MORE_ROOM}")
            }
        }
    }
}

impl std::error::Error for LendError {}

/// The pieces of one publisher's memory that have their pages.
#[derive(Debug)]
pub(crate) struct Pages {
    /// Bytes of the largest payload; the next piece's headers begin behind it.
    largest: usize,
    /// Where payloads begin, and up to where each was asked for.
    known: Vec<(usize, usize)>,
}

impl Pages {
    /// For so many pieces, with payloads of at most `largest` bytes.
    pub(crate) fn new(largest: usize, pieces: usize) -> Pages {
        Pages { largest, known: Vec::with_capacity(pieces) }
    }

    /// Has the kernel provide the first `bytes` of the payload that begins at the address `start`.
    ///
    /// Pieces are lent in the order in which they lie for the first time, so the next one's headers, which iceoryx2 writes before
    /// anybody could ask, begin where this one ends: their page is asked for as well.
    ///
    /// # Errors
    /// Shared memory is full, or would be: as much again stays free, at most what a role takes to join. Large pieces thus leave room for
    /// small ones, and for those who come.
    pub(crate) fn provide(&mut self, start: usize, bytes: usize) -> io::Result<()> {
        let known = self.known.iter().position(|piece| piece.0 == start);
        if known.is_some_and(|piece| start + bytes <= self.known[piece].1) {
            return Ok(());
        }
        let spare = (bytes as u64).min(room::TO_JOIN);
        if room::available().is_some_and(|free| free < bytes as u64 + spare) {
            return Err(Errno::NOSPC.into());
        }
        let end = populate(start, bytes)?;
        match populate(start + self.largest, HEADERS) {
            // Behind the last piece nothing is mapped.
            Ok(_) | Err(Errno::NOMEM) => {}
            Err(error) => return Err(error.into()),
        }
        match known {
            Some(piece) => self.known[piece].1 = end,
            None => self.known.push((start, end)),
        }
        Ok(())
    }
}

/// Has the kernel provide the pages in which these bytes lie, and says where the last one ends.
fn populate(start: usize, bytes: usize) -> Result<usize, Errno> {
    let first = start - start % page_size();
    let end = (start + bytes).next_multiple_of(page_size());
    let page = std::ptr::without_provenance_mut(first);
    // SAFETY: the advice changes no byte and unmaps nothing: it does what a write of each page's own bytes would do. Where nothing is mapped,
    // or nothing may be written, it is an error.
    match unsafe { madvise(page, end - first, Advice::LinuxPopulateWrite) } {
        // Kernels before 5.14 do not know it. There a full /dev/shm stays what it was.
        Ok(()) | Err(Errno::INVAL) => Ok(end),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Local;
    use crate::bus::Bus;
    use crate::domain::Domain;
    use crate::ports::{DetectionsOut, FramesOut, Output};
    use crate::qos::FRAMES;
    use crate::stop::Stop;
    use iceoryx2::prelude::ZeroCopySend;
    use std::fmt::Debug;

    fn bus(name: &str) -> Bus<Local> {
        let name = format!("pages-{name}-{}", std::process::id());
        let domain = Domain::with_root(&name, std::env::temp_dir().join(&name)).unwrap();
        Bus::start(&domain, "test", &Stop::new().unwrap()).unwrap()
    }

    /// Takes as many pieces as can be had at once, of `length` items where `largest` would go.
    fn headers_lie_behind_the_largest_payload<T, H>(out: &Output<Local, T, H>, length: usize, largest: usize)
    where
        T: Debug + ZeroCopySend,
        H: Debug + Default + ZeroCopySend,
    {
        let mut loans = Vec::new();
        while let Ok(loan) = out.lend(length) {
            loans.push(loan);
        }
        assert!(loans.len() > 1);
        let places: Vec<_> = loans.iter_mut().map(|loan| loan.payload_mut().as_ptr().addr()).collect();
        for pair in places.windows(2) {
            let gap = (pair[1] - pair[0]).checked_sub(largest * size_of::<T>());
            assert!(gap.is_some_and(|gap| gap > 0 && gap < HEADERS), "{gap:?} bytes between two payloads");
        }
    }

    #[test]
    fn pieces_are_lent_in_the_order_in_which_they_lie_so_that_the_headers_of_the_next_have_their_page() {
        let frames: FramesOut<Local> = bus("frames").create_frames("cam0", &FRAMES, 10_000).unwrap();
        headers_lie_behind_the_largest_payload(&frames, 10_000, 10_000);
        let detections: DetectionsOut<Local> = bus("tags").create_detections("cam0", "main", 40).unwrap();
        headers_lie_behind_the_largest_payload(&detections, 3, 40);
    }

    #[test]
    fn pages_are_asked_for_once_and_more_of_them_when_a_message_is_longer() {
        let out = bus("once").create_detections("cam0", "main", 4000).unwrap();
        let touched = || out.touched_bytes().unwrap();
        let before = touched();
        drop(out.lend(1).unwrap());
        assert!(touched() < before + 3 * page_size() as u64, "{before}, then {}", touched());
        let longer = 20 * page_size();
        drop(out.lend(longer / size_of::<crate::detection::TagDetection>()).unwrap());
        let after = touched();
        assert!(after >= before + longer as u64 - 2 * page_size() as u64, "{before}, then {after}");
        drop(out.lend(1).unwrap());
        assert_eq!(touched(), after);
    }

    #[test]
    fn more_than_there_is_room_for_is_refused_and_nothing_is_touched() {
        let mut pages = Pages::new(1 << 60, 1);
        let error = pages.provide(page_size(), 1 << 60).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(pages.known.is_empty());
    }

    #[test]
    fn what_is_not_mapped_is_an_error() {
        assert!(Pages::new(0, 1).provide(page_size(), 1).is_err());
    }
}
