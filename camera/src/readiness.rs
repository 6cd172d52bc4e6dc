//! A file descriptor that wakes a wait set.

use std::io;
use std::os::fd::AsRawFd;

use iceoryx2::prelude::{FileDescriptor, FileDescriptorBased};

/// Wakes a wait set when there is something to read; to be dropped before what it was made of.
#[derive(Debug)]
pub(crate) struct Readiness(FileDescriptor);

impl Readiness {
    /// Of an open file or pipe.
    pub(crate) fn of(file: &impl AsRawFd) -> io::Result<Readiness> {
        let descriptor = FileDescriptor::non_owning_new(file.as_raw_fd());
        descriptor.map(Readiness).ok_or_else(|| io::Error::other("an open file has no valid descriptor"))
    }
}

impl FileDescriptorBased for Readiness {
    fn file_descriptor(&self) -> &FileDescriptor {
        &self.0
    }
}
