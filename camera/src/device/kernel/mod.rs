//! The few calls to Video4Linux that the crate v4l does not make the way a loan needs them.
//!
//! ```text
//! call         one call, and what lies in its argument             unsafe
//! Port         an open device: asks, sets formats, rates and controls
//! LoanQueue    USERPTR: the driver writes into loans, which lie in here until they come back filled
//! MappedQueue  MMAP: the driver writes into memory of its own (a Mapping, unsafe), looked at between two calls
//! ```
//!
//! What makes it sound: every argument is a struct of the kernel's own header (by the crate v4l), whose size is held against the
//! request's; addresses in arguments are set in this folder only; and memory that the driver may write to is owned by a queue,
//! which ends streaming and closes the device before it lets go of it.

#[allow(unsafe_code, reason = "the one place that makes calls to the kernel's video drivers")]
mod call;

mod buffers;
mod controls;
mod facts;
mod formats;
mod port;

mod lend;
mod numbers;

mod map;
#[allow(unsafe_code, reason = "the one place that looks into memory of the kernel's video drivers")]
mod mapping;

#[cfg(test)]
pub(super) use facts::Planes;
pub(super) use facts::{
    About, ControlKind, Dequeued, DriverControl, DriverFormat, Listed, MemoryPlace, MemoryPlane,
};
pub(super) use lend::LoanQueue;
pub(super) use map::MappedQueue;
pub(super) use port::Port;
