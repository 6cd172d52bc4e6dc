//! How frames get from a driver into shared memory, in words.

use std::fmt;

use tagbus_message::qos::FRAMES;

/// How frames get from the driver into shared memory.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Transfer {
    /// The driver writes into shared memory (USERPTR): no copy.
    Lent {
        /// Buffer numbers of the driver's queue; with one for each piece of shared memory none is pinned twice.
        numbers: usize,
    },
    /// The driver writes into memory of its own (MMAP), from where each frame is copied or decoded: one pass.
    Mapped {
        /// Buffers of the driver.
        buffers: usize,
        /// Why the driver does not write into shared memory.
        reason: String,
    },
    /// The camera writes into memory that it shares with this process (dma-buf), from where luma is copied.
    Shared {
        /// Buffers of the camera.
        buffers: usize,
    },
    /// A program writes into a pipe, from which each frame is read into shared memory: one copy.
    Piped,
}

impl fmt::Display for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lent { numbers } => write!(
                f,
                "0 copies: the driver writes into shared memory (USERPTR, {numbers} numbers for {} pieces of memory)",
                FRAMES.chunks()
            ),
            Self::Shared { buffers } => {
                write!(f, "1 copy: luma from {buffers} buffers of the camera (dma-buf)")
            }
            Self::Piped => f.write_str("1 copy: read from the program's pipe"),
            Self::Mapped { buffers, reason } => {
                write!(f, "1 copy: from {buffers} buffers of the driver (MMAP), because {reason}")
            }
        }
    }
}
