//! An open device.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{call, text, zeroed};
use super::facts::{About, Planes};
use crate::readiness::Readiness;

/// An open device.
#[derive(Debug)]
pub(crate) struct Port {
    pub(super) file: File,
    pub(super) planes: Planes,
}

impl Port {
    /// Opens a device for reading and writing; no call on it waits.
    pub(crate) fn open(path: &Path) -> io::Result<Port> {
        let nonblocking = rustix::fs::OFlags::NONBLOCK.bits() as i32;
        let file = OpenOptions::new().read(true).write(true).custom_flags(nonblocking).open(path)?;
        Ok(Port { file, planes: Planes::Single })
    }

    /// What wakes a wait set when a frame is filled or the device has gone.
    pub(crate) fn readiness(&self) -> io::Result<Readiness> {
        Readiness::of(&self.file)
    }

    /// What the device is. From here on formats and buffers are described its way.
    pub(crate) fn about(&mut self) -> io::Result<About> {
        let mut said: sys::v4l2_capability = zeroed();
        call(&self.file, vidioc::VIDIOC_QUERYCAP, &mut said)?;
        // A driver with several nodes says what this node can apart from what all can.
        let own = said.capabilities & sys::V4L2_CAP_DEVICE_CAPS != 0;
        let can = if own { said.device_caps } else { said.capabilities };
        let captures = match () {
            () if can & sys::V4L2_CAP_VIDEO_CAPTURE != 0 => Some(Planes::Single),
            () if can & sys::V4L2_CAP_VIDEO_CAPTURE_MPLANE != 0 => Some(Planes::Multi),
            () => None,
        };
        self.planes = captures.unwrap_or(Planes::Single);
        Ok(About {
            driver: text(&said.driver),
            card: text(&said.card),
            captures,
            streams: can & sys::V4L2_CAP_STREAMING != 0,
        })
    }

    /// How the kernel calls buffers of this device.
    pub(super) fn buffer_type(&self) -> u32 {
        match self.planes {
            Planes::Single => sys::v4l2_buf_type_V4L2_BUF_TYPE_VIDEO_CAPTURE,
            Planes::Multi => sys::v4l2_buf_type_V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE,
        }
    }
}
