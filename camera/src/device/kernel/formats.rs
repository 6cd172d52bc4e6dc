//! Formats, sizes and rates of a device.

use std::io;

use tagbus_message::frame::{Fourcc, MAX_PLANES};
use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{
    call, capture_in, listed, one_interval, one_size, pix, pix_mp, range_of_intervals, range_of_sizes, text,
    zeroed,
};
use super::facts::{DriverFormat, Listed, MemoryPlane, Planes};
use super::port::Port;

impl Port {
    /// The format at a place of the driver's list, with its words for it.
    pub(crate) fn format_at(&self, index: u32) -> io::Result<Option<(Fourcc, String)>> {
        let mut entry = sys::v4l2_fmtdesc { index, type_: self.buffer_type(), ..zeroed() };
        let answer = call(&self.file, vidioc::VIDIOC_ENUM_FMT, &mut entry);
        Ok(listed(answer)?.map(|()| (Fourcc(entry.pixelformat), text(&entry.description))))
    }

    /// The size at a place of the driver's list for a format.
    pub(crate) fn size_at(&self, format: Fourcc, index: u32) -> io::Result<Option<Listed<[u32; 2]>>> {
        let mut entry = sys::v4l2_frmsizeenum { index, pixel_format: format.0, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_ENUM_FRAMESIZES, &mut entry))?.is_none() {
            return Ok(None);
        }
        if entry.type_ == sys::v4l2_frmsizetypes_V4L2_FRMSIZE_TYPE_DISCRETE {
            let one = one_size(&entry);
            return Ok(Some(Listed::One([one.width, one.height])));
        }
        let range = range_of_sizes(&entry);
        Ok(Some(Listed::Range {
            min: [range.min_width, range.min_height],
            max: [range.max_width, range.max_height],
            step: [range.step_width, range.step_height],
        }))
    }

    /// The frame interval, in seconds as numerator and denominator, at a place of the driver's list.
    pub(crate) fn interval_at(
        &self,
        format: Fourcc,
        [width, height]: [u32; 2],
        index: u32,
    ) -> io::Result<Option<Listed<[u32; 2]>>> {
        let mut entry = sys::v4l2_frmivalenum { index, pixel_format: format.0, width, height, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_ENUM_FRAMEINTERVALS, &mut entry))?.is_none() {
            return Ok(None);
        }
        let parts = |fraction: sys::v4l2_fract| [fraction.numerator, fraction.denominator];
        if entry.type_ == sys::v4l2_frmivaltypes_V4L2_FRMIVAL_TYPE_DISCRETE {
            return Ok(Some(Listed::One(parts(one_interval(&entry)))));
        }
        let range = range_of_intervals(&entry);
        Ok(Some(Listed::Range { min: parts(range.min), max: parts(range.max), step: parts(range.step) }))
    }

    /// The format that is in force.
    pub(crate) fn format(&self) -> io::Result<DriverFormat> {
        let mut format = sys::v4l2_format { type_: self.buffer_type(), ..zeroed() };
        call(&self.file, vidioc::VIDIOC_G_FMT, &mut format)?;
        Ok(self.stated(&format))
    }

    /// Asks for a format; the answer is what the driver made of it.
    pub(crate) fn set_format(&self, fourcc: Fourcc, width: u32, height: u32) -> io::Result<DriverFormat> {
        let mut format = sys::v4l2_format { type_: self.buffer_type(), ..zeroed() };
        let field = sys::v4l2_field_V4L2_FIELD_NONE;
        match self.planes {
            Planes::Single => {
                let pixelformat = fourcc.0;
                format.fmt.pix = sys::v4l2_pix_format { width, height, pixelformat, field, ..pix(&format) };
            }
            Planes::Multi => {
                let pixelformat = fourcc.0;
                format.fmt.pix_mp =
                    sys::v4l2_pix_format_mplane { width, height, pixelformat, field, ..pix_mp(&format) };
            }
        }
        call(&self.file, vidioc::VIDIOC_S_FMT, &mut format)?;
        Ok(self.stated(&format))
    }

    fn stated(&self, format: &sys::v4l2_format) -> DriverFormat {
        let none = sys::v4l2_field_V4L2_FIELD_NONE;
        let mut memories = [MemoryPlane::default(); MAX_PLANES];
        match self.planes {
            Planes::Single => {
                let pix = pix(format);
                memories[0] = MemoryPlane { stride: pix.bytesperline, bytes: pix.sizeimage };
                let (width, height) = (pix.width, pix.height);
                let (fourcc, progressive) = (Fourcc(pix.pixelformat), pix.field == none);
                DriverFormat { fourcc, width, height, progressive, count: 1, memories }
            }
            Planes::Multi => {
                let pix = pix_mp(format);
                let all = pix.plane_fmt;
                for (memory, said) in memories.iter_mut().zip(all) {
                    *memory = MemoryPlane { stride: said.bytesperline, bytes: said.sizeimage };
                }
                let (width, height) = (pix.width, pix.height);
                let (fourcc, progressive) = (Fourcc(pix.pixelformat), pix.field == none);
                DriverFormat { fourcc, width, height, progressive, count: pix.num_planes.into(), memories }
            }
        }
    }

    /// The time from frame to frame that is in force, in seconds as numerator and denominator; `None` where the driver has no say in it.
    pub(crate) fn frame_time(&self) -> io::Result<Option<[u32; 2]>> {
        let mut parameters = sys::v4l2_streamparm { type_: self.buffer_type(), ..zeroed() };
        let answer = listed(call(&self.file, vidioc::VIDIOC_G_PARM, &mut parameters))?;
        Ok(answer.map(|()| interval_in(&parameters)))
    }

    /// Asks for a time from frame to frame; the answer is what the driver made of it, `None` where it has no say in it.
    pub(crate) fn set_frame_time(&self, [numerator, denominator]: [u32; 2]) -> io::Result<Option<[u32; 2]>> {
        let mut parameters = sys::v4l2_streamparm { type_: self.buffer_type(), ..zeroed() };
        let timeperframe = sys::v4l2_fract { numerator, denominator };
        parameters.parm.capture = sys::v4l2_captureparm { timeperframe, ..capture_in(&parameters) };
        let answer = listed(call(&self.file, vidioc::VIDIOC_S_PARM, &mut parameters))?;
        Ok(answer.map(|()| interval_in(&parameters)))
    }
}

fn interval_in(parameters: &sys::v4l2_streamparm) -> [u32; 2] {
    let interval = capture_in(parameters).timeperframe;
    [interval.numerator, interval.denominator]
}
