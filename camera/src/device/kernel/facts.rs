//! What drivers are asked and what they answer, in words of ours.

use tagbus_message::frame::{Fourcc, MAX_PLANES};
use v4l::v4l_sys as sys;

use crate::stamps::DriverStamp;

/// Which of the kernel's two ways to describe buffers a device uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Planes {
    /// One memory a frame.
    Single,
    /// Each plane may lie in memory of its own.
    Multi,
}

/// Whose memory the driver writes into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Memory {
    /// The driver's own (MMAP).
    Drivers,
    /// Ours (USERPTR).
    Ours,
}

impl Memory {
    /// The kernel's number for it.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::Drivers => sys::v4l2_memory_V4L2_MEMORY_MMAP,
            Self::Ours => sys::v4l2_memory_V4L2_MEMORY_USERPTR,
        }
    }
}

/// What a device says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct About {
    pub(crate) driver: String,
    pub(crate) card: String,
    /// How it captures; `None` for a device that does not capture pictures.
    pub(crate) captures: Option<Planes>,
    /// Whether it hands over buffers, and not only bytes to read.
    pub(crate) streams: bool,
}

/// One memory of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct MemoryPlane {
    /// Bytes from row to row; 0 where the driver does not say.
    pub(crate) stride: u32,
    /// Bytes that a buffer must have.
    pub(crate) bytes: u32,
}

/// A format as the driver states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DriverFormat {
    pub(crate) fourcc: Fourcc,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Whether a frame holds all rows of one moment.
    pub(crate) progressive: bool,
    /// Memories in use.
    pub(crate) count: usize,
    pub(crate) memories: [MemoryPlane; MAX_PLANES],
}

/// Sizes or intervals: one of a list, or a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Listed<T> {
    One(T),
    Range { min: T, max: T, step: T },
}

/// A frame as it comes back from the driver.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dequeued {
    pub(crate) index: usize,
    /// Bytes written to each memory.
    pub(crate) bytes_used: [u32; MAX_PLANES],
    /// Whether the driver says that data was lost.
    pub(crate) damaged: bool,
    /// The driver's number and stamp of the frame.
    pub(crate) stamp: DriverStamp,
}

/// What a control's values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ControlKind {
    Number,
    Switch,
    /// One of a list of texts.
    Menu,
    /// One of a list of numbers.
    NumberMenu,
    /// Does something when it is written, and has no value.
    Button,
    /// A heading, a text, or a kind that does not concern us.
    Other,
}

/// A control as the driver describes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DriverControl {
    pub(crate) id: u32,
    pub(crate) kind: ControlKind,
    /// The driver's words for it.
    pub(crate) title: String,
    pub(crate) min: i64,
    pub(crate) max: i64,
    pub(crate) step: i64,
    pub(crate) default: i64,
    /// Whether it cannot be written.
    pub(crate) read_only: bool,
    /// Whether another control has its say at present, so that a value has no effect.
    pub(crate) inactive: bool,
}

/// Where one memory of a frame begins in a loan's picture, and its bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct MemoryPlace {
    pub(crate) offset: usize,
    pub(crate) bytes: usize,
}
