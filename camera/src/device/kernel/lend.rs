//! A queue of memory of ours (USERPTR).

use std::io;
use std::os::raw::c_ulong;

use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{KERNEL_PLANES, zeroed};
use super::facts::{Dequeued, Memory, MemoryPlace};
use super::numbers::Numbers;
use super::port::Port;
use crate::loan::Loan;

/// A queue of loans that the driver fills.
pub(crate) struct LoanQueue {
    // Dropped first: a closed device writes nowhere, whatever calls before it said.
    port: Port,
    numbers: Numbers<Loan>,
    places: Vec<MemoryPlace>,
}

impl LoanQueue {
    /// Asks the driver for `count` numbers. `places` are the memories of a frame in a loan's picture.
    pub(crate) fn new(port: Port, count: u32, places: Vec<MemoryPlace>) -> io::Result<LoanQueue> {
        let granted = port.request(Memory::Ours, count)?.count;
        Ok(LoanQueue { port, numbers: Numbers::new(granted as usize), places })
    }

    /// The device, to wait for it.
    pub(crate) fn port(&self) -> &Port {
        &self.port
    }

    /// Numbers that the driver granted.
    pub(crate) fn count(&self) -> usize {
        self.numbers.count()
    }

    /// Loans that the driver has.
    pub(crate) fn lent(&self) -> usize {
        self.numbers.lent()
    }

    /// How often memory got a number under which the kernel knew other memory, which it then had to pin anew.
    pub(crate) fn repins(&self) -> u64 {
        self.numbers.repins()
    }

    /// Begins; to be called with loans in the queue.
    pub(crate) fn start(&self) -> io::Result<()> {
        self.port.stream(true)
    }

    /// Hands a loan to the driver. It stays here until it is dequeued.
    pub(crate) fn queue(&mut self, mut loan: Loan) -> io::Result<()> {
        // Exposed, because it is the kernel that writes through it.
        let address = loan.picture().as_mut_ptr().expose_provenance();
        let room = loan.picture().len();
        let fits = |place: &MemoryPlace| place.offset.checked_add(place.bytes).is_some_and(|end| end <= room);
        if !self.places.iter().all(fits) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "a loan is smaller than the driver's frame",
            ));
        }
        let number = self.numbers.number_for(address).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "every buffer is in the driver's queue")
        })?;
        let mut planes = [zeroed::<sys::v4l2_plane>(); KERNEL_PLANES];
        for (plane, place) in planes.iter_mut().zip(&self.places) {
            // Within the loan, as checked above; the loan is kept below until the driver gives the number back.
            plane.m.userptr = (address + place.offset) as c_ulong;
            plane.length = place.bytes as u32;
        }
        self.port.buffer_call(vidioc::VIDIOC_QBUF, Memory::Ours, number, &mut planes)?;
        self.numbers.keep(number, address, loan);
        Ok(())
    }

    /// The next filled loan; `None` when there is none yet.
    pub(crate) fn dequeue(&mut self) -> io::Result<Option<(Loan, Dequeued)>> {
        let Some(frame) = self.port.dequeue(Memory::Ours)? else { return Ok(None) };
        let loan = self.numbers.take(frame.index);
        let loan =
            loan.ok_or_else(|| io::Error::other(format!("the driver gave back buffer {}", frame.index)))?;
        Ok(Some((loan, frame)))
    }
}

impl Drop for LoanQueue {
    /// Takes every loan back from the driver, before the loans themselves go.
    fn drop(&mut self) {
        // On a device that has gone these fail, and closing it does the same.
        let _ = self.port.stream(false);
        let _ = self.port.request(Memory::Ours, 0);
    }
}
