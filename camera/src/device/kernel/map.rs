//! A queue of memory of the driver's own (MMAP).

use std::io;

use tagbus_message::frame::MAX_PLANES;
use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{KERNEL_PLANES, plane_offset, zeroed};
use super::facts::{Dequeued, Memory};
use super::mapping::Mapping;
use super::port::Port;

/// A queue of the driver's own buffers.
pub(crate) struct MappedQueue {
    port: Port,
    buffers: Vec<Vec<Mapping>>,
}

impl MappedQueue {
    /// Asks for buffers with so many memories each, and queues all of them.
    pub(crate) fn new(port: Port, count: u32, memories: usize) -> io::Result<MappedQueue> {
        let granted = port.request(Memory::Drivers, count)?.count as usize;
        let mut queue = MappedQueue { port, buffers: Vec::new() };
        for index in 0..granted {
            let mut planes = [zeroed::<sys::v4l2_plane>(); KERNEL_PLANES];
            queue.port.buffer_call(vidioc::VIDIOC_QUERYBUF, Memory::Drivers, index, &mut planes)?;
            let map = |plane: &sys::v4l2_plane| {
                Mapping::new(&queue.port, plane.length as usize, plane_offset(plane))
            };
            let mapped: io::Result<_> = planes.iter().take(memories.max(1)).map(map).collect();
            queue.buffers.push(mapped?);
            queue.give_back(index)?;
        }
        Ok(queue)
    }

    /// The device, to wait for it.
    pub(crate) fn port(&self) -> &Port {
        &self.port
    }

    /// Buffers that the driver granted.
    pub(crate) fn count(&self) -> usize {
        self.buffers.len()
    }

    /// Begins.
    pub(crate) fn start(&self) -> io::Result<()> {
        self.port.stream(true)
    }

    /// Shows the next filled buffer's memories to `look`, then gives it back; `None` when there is none yet.
    pub(crate) fn look<R>(&mut self, look: impl FnOnce(&Dequeued, &[&[u8]]) -> R) -> io::Result<Option<R>> {
        let Some(frame) = self.port.dequeue(Memory::Drivers)? else { return Ok(None) };
        let Some(buffer) = self.buffers.get(frame.index) else {
            return Err(io::Error::other(format!("the driver gave back buffer {}", frame.index)));
        };
        let mut memories: [&[u8]; MAX_PLANES] = [&[]; MAX_PLANES];
        for (memory, mapping) in memories.iter_mut().zip(buffer) {
            *memory = mapping.bytes();
        }
        let seen = look(&frame, &memories[..buffer.len().min(MAX_PLANES)]);
        self.give_back(frame.index)?;
        Ok(Some(seen))
    }

    fn give_back(&self, index: usize) -> io::Result<()> {
        let mut planes = [zeroed(); KERNEL_PLANES];
        self.port.buffer_call(vidioc::VIDIOC_QBUF, Memory::Drivers, index, &mut planes).map(drop)
    }
}

impl Drop for MappedQueue {
    fn drop(&mut self) {
        // On a device that has gone this fails, and closing it does the same.
        let _ = self.port.stream(false);
    }
}
