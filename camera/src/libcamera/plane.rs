//! The first plane of a buffer, mapped. The kernel is told before and after each reading, so that caches agree with what the
//! camera's hardware wrote.

use std::io;
use std::os::fd::BorrowedFd;

use ::libcamera::framebuffer::AsFrameBuffer;
use ::libcamera::framebuffer_allocator::FrameBuffer;
use dma_buf::{BufferError, DmaBuf, MappedDmaBuf};

use super::luma::Luma;

/// Memory of a buffer from which luma is read.
pub(super) struct LumaPlane {
    memory: MappedDmaBuf,
    offset: usize,
    bytes: usize,
}

impl LumaPlane {
    /// Maps the memory of a buffer, which lives on its own from then on.
    pub(super) fn of(buffer: &FrameBuffer) -> io::Result<LumaPlane> {
        let planes = buffer.planes();
        let plane = planes.get(0).ok_or_else(|| io::Error::other("a buffer without planes"))?;
        let offset = plane.offset().ok_or_else(|| io::Error::other("a plane without a place"))?;
        // SAFETY: the descriptor belongs to the buffer, which is borrowed until it has been duplicated.
        let memory = unsafe { BorrowedFd::borrow_raw(plane.fd()) }.try_clone_to_owned()?;
        Ok(LumaPlane { memory: DmaBuf::from(memory).memory_map()?, offset, bytes: plane.len() })
    }

    /// Copies luma; an error says that the plane is smaller than the picture, or what the kernel says.
    pub(super) fn copy(&self, luma: Luma, stride: usize, width: usize, to: &mut [u8]) -> io::Result<()> {
        let needed = luma.plane_bytes([width, to.len() / width], stride);
        if self.bytes < needed {
            let seen = self.bytes;
            return Err(io::Error::other(format!("a plane of {seen} bytes, and the picture takes {needed}")));
        }
        let read = |memory: &[u8], to: Option<&mut [u8]>| {
            let plane = memory.get(self.offset..self.offset + needed).ok_or("a plane beyond its memory")?;
            if let Some(to) = to {
                luma.copy(plane, stride, width, to);
            }
            Ok(())
        };
        self.memory.read(read, Some(to)).map_err(|error| match error {
            BufferError::FdAccess { source, .. } => source,
            BufferError::Closure(error) => io::Error::other(error.to_string()),
        })
    }
}
