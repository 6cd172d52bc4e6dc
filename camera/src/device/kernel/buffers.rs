//! Buffers of a device: asked for, handed over, taken back.

use std::io;
use std::os::raw::{c_int, c_ulong};

use tagbus_message::frame::{CaptureKind, MAX_PLANES};
use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{KERNEL_PLANES, buffer_place, call, plane_address, zeroed};
use super::facts::{Dequeued, Memory, Planes};
use super::port::Port;
use crate::stamps::DriverStamp;

impl Port {
    /// Whether the driver writes into memory of ours.
    pub(crate) fn takes_our_memory(&self) -> io::Result<bool> {
        let said = self.request(Memory::Drivers, 0)?.capabilities;
        if said != 0 {
            return Ok(said & sys::V4L2_BUF_CAP_SUPPORTS_USERPTR != 0);
        }
        // Kernels before 4.20 do not say; asking for none of such buffers is an error where there can be none.
        Ok(self.request(Memory::Ours, 0).is_ok())
    }

    /// Asks for buffers; none is a question, too.
    pub(super) fn request(&self, memory: Memory, count: u32) -> io::Result<sys::v4l2_requestbuffers> {
        let type_ = self.buffer_type();
        let mut buffers = sys::v4l2_requestbuffers { count, type_, memory: memory.code(), ..zeroed() };
        call(&self.file, vidioc::VIDIOC_REQBUFS, &mut buffers)?;
        Ok(buffers)
    }

    /// Begins or ends streaming.
    pub(super) fn stream(&self, on: bool) -> io::Result<()> {
        let mut kind = self.buffer_type() as c_int;
        call(&self.file, if on { vidioc::VIDIOC_STREAMON } else { vidioc::VIDIOC_STREAMOFF }, &mut kind)
    }

    /// A call about one buffer. With several planes their descriptions lie in `planes`, which outlives the call.
    pub(super) fn buffer_call(
        &self,
        request: c_ulong,
        memory: Memory,
        index: usize,
        planes: &mut [sys::v4l2_plane; KERNEL_PLANES],
    ) -> io::Result<sys::v4l2_buffer> {
        let mut buffer: sys::v4l2_buffer = zeroed();
        buffer.index = index as u32;
        buffer.type_ = self.buffer_type();
        buffer.memory = memory.code();
        match self.planes {
            Planes::Single => {
                buffer.length = planes[0].length;
                // An address where the memory is ours; where it is the driver's this is 0 and not read.
                buffer.m.userptr = plane_address(&planes[0]);
            }
            Planes::Multi => {
                buffer.length = KERNEL_PLANES as u32;
                // The kernel reads and writes as many descriptions as `length` says, and so many there are.
                buffer.m.planes = planes.as_mut_ptr();
            }
        }
        call(&self.file, request, &mut buffer)?;
        if self.planes == Planes::Single {
            // The kernel fills in an offset or leaves the address.
            planes[0].m.userptr = buffer_place(&buffer);
            (planes[0].length, planes[0].bytesused) = (buffer.length, buffer.bytesused);
        }
        Ok(buffer)
    }

    /// The next filled buffer; `None` when there is none yet.
    pub(super) fn dequeue(&self, memory: Memory) -> io::Result<Option<Dequeued>> {
        let mut planes = [zeroed(); KERNEL_PLANES];
        match self.buffer_call(vidioc::VIDIOC_DQBUF, memory, 0, &mut planes) {
            Ok(buffer) => Ok(Some(dequeued(&buffer, &planes))),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn dequeued(buffer: &sys::v4l2_buffer, planes: &[sys::v4l2_plane; KERNEL_PLANES]) -> Dequeued {
    let mut bytes_used = [0; MAX_PLANES];
    for (used, plane) in bytes_used.iter_mut().zip(planes) {
        *used = plane.bytesused;
    }
    let seconds = u64::try_from(buffer.timestamp.tv_sec).unwrap_or(0);
    let micros = u64::try_from(buffer.timestamp.tv_usec).unwrap_or(0);
    let clock = buffer.flags & sys::V4L2_BUF_FLAG_TIMESTAMP_MASK;
    let source = buffer.flags & sys::V4L2_BUF_FLAG_TSTAMP_SRC_MASK;
    let stamp = DriverStamp {
        sequence: buffer.sequence,
        stamp_ns: seconds.saturating_mul(1_000_000_000).saturating_add(micros.saturating_mul(1000)),
        monotonic: clock == sys::V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC,
        kind: if source == sys::V4L2_BUF_FLAG_TSTAMP_SRC_SOE {
            CaptureKind::StartOfExposure
        } else {
            CaptureKind::EndOfFrame
        },
    };
    let damaged = buffer.flags & sys::V4L2_BUF_FLAG_ERROR != 0;
    Dequeued { index: buffer.index as usize, bytes_used, damaged, stamp }
}
