//! Memory of a driver in our address space.

use std::io;
use std::os::fd::AsRawFd;
use std::os::raw::c_void;
use std::ptr;
use std::slice;

use v4l::v4l2;

use super::port::Port;

/// A part of the driver's memory in our address space.
#[derive(Debug)]
pub(super) struct Mapping {
    start: *mut c_void,
    bytes: usize,
}

impl Mapping {
    /// Maps `bytes` of the driver's memory, which begin at `offset` by the kernel's count.
    pub(super) fn new(port: &Port, bytes: usize, offset: u32) -> io::Result<Mapping> {
        let shared = rustix::mm::MapFlags::SHARED.bits() as i32;
        // Some drivers refuse a mapping that cannot be written.
        let access = (rustix::mm::ProtFlags::READ | rustix::mm::ProtFlags::WRITE).bits() as i32;
        // SAFETY: a new mapping at an address of the kernel's choice touches no memory that exists.
        let start = unsafe {
            v4l2::mmap(ptr::null_mut(), bytes, access, shared, port.file.as_raw_fd(), offset.into())
        }?;
        Ok(Mapping { start, bytes })
    }

    /// The bytes. To be called only while the buffer is ours, between taking it from the driver and giving it back.
    pub(super) fn bytes(&self) -> &[u8] {
        // SAFETY: the mapping has this length and lives as long as `self`; bytes of a mapping are initialised; the driver
        // does not write between DQBUF and QBUF, and that is the only time when this is called.
        unsafe { slice::from_raw_parts(self.start.cast(), self.bytes) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: this is the mapping that `new` made; slices of it are bound to `self`, which nobody borrows any more.
        let _ = unsafe { v4l2::munmap(self.start, self.bytes) };
    }
}
