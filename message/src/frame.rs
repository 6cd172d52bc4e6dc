//! What travels with a frame, and the check that it tells the truth about the bytes beside it.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

pub use crate::capture::{CaptureKind, ClockKind};
pub use crate::fourcc::{Fourcc, GREY, MJPG, NV12, NV21, UYVY, YU12, YUYV};
pub use crate::header_error::HeaderError;

/// The layout of [`FrameHeader`] that this code writes and reads.
pub const FRAME_SCHEMA: u32 = 1;
/// Planes that a header can describe.
pub const MAX_PLANES: usize = 4;
/// The shortest side that is taken, in pixels.
pub const MIN_SIDE: u32 = 4;
/// The longest side that is taken, in pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Pictures in a payload start at a multiple of this many bytes (one cache line); a loan has so much room to spare.
pub const PICTURE_ALIGNMENT: usize = 64;

/// One plane of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.Plane.v1")]
pub struct Plane {
    /// Bytes from [`FrameHeader::data_offset`] to the first byte of the plane.
    pub offset: u32,
    /// Bytes from one row of the plane to the next.
    pub stride: u32,
}

/// The user header of the frames topic; the payload is the bytes as captured.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("tagbus.FrameHeader.v1")]
pub struct FrameHeader {
    /// Always [`FRAME_SCHEMA`].
    pub schema: u32,
    /// Pixel format, a [`Fourcc`].
    pub fourcc: u32,
    /// Another number at each start of the camera; sequences of different epochs cannot be compared.
    pub epoch: u64,
    /// Number of the frame within its epoch; frames that the camera lost leave gaps.
    pub sequence: u64,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How far the picture must be turned clockwise to stand upright: 0, 90, 180 or 270 degrees.
    pub rotation_degrees: u32,
    /// Significant bits of a luma value.
    pub bit_depth: u8,
    /// Bits that a luma value takes in memory: 8 or 16.
    pub word_bits: u8,
    /// Where the value lies in its word: 0 in the low bits, 1 in the high bits.
    pub value_alignment: u8,
    /// Planes in use.
    pub plane_count: u8,
    /// Bytes of the picture, counted from `data_offset`.
    pub bytes_used: u64,
    /// Bytes from the start of the payload to the start of the picture.
    pub data_offset: u32,
    /// Copies that user space made of this frame between driver and payload: 0 or 1.
    pub copies: u32,
    /// Where each plane lies.
    pub planes: [Plane; MAX_PLANES],
    /// When the picture was taken, nanoseconds of the clock named by `capture_clock`; 0 when not known.
    pub capture_ns: u64,
    /// A [`ClockKind`] code.
    pub capture_clock: u32,
    /// A [`CaptureKind`] code: the moment that `capture_ns` marks.
    pub capture_kind: u32,
    /// When the camera process got the frame, `CLOCK_MONOTONIC` nanoseconds.
    pub dequeue_ns: u64,
    /// When the camera process published it, `CLOCK_MONOTONIC` nanoseconds.
    pub publish_ns: u64,
    /// Nominal time from frame to frame in nanoseconds; 0 when not known.
    pub frame_time_ns: u64,
    /// Exposure time in nanoseconds; 0 when not known.
    pub exposure_ns: u64,
    /// Total gain as a factor; 0 when not known.
    pub gain: f32,
    /// [`crate::info::CameraInfo::number`] of the camera information that applies.
    pub info_number: u32,
    /// Frames that the driver lost since the frame before this one.
    pub lost_in_driver: u32,
    /// Frames given up because no loan was free.
    pub lost_no_loan: u32,
    /// Frames given up because they were cut short or could not be decoded.
    pub lost_damaged: u32,
    /// Not used: zero.
    pub reserved: u32,
}

const _: () = {
    assert!(size_of::<Plane>() == 8);
    assert!(size_of::<FrameHeader>() == 160);
    assert!(offset_of!(FrameHeader, schema) == 0);
    assert!(offset_of!(FrameHeader, fourcc) == 4);
    assert!(offset_of!(FrameHeader, epoch) == 8);
    assert!(offset_of!(FrameHeader, sequence) == 16);
    assert!(offset_of!(FrameHeader, width) == 24);
    assert!(offset_of!(FrameHeader, height) == 28);
    assert!(offset_of!(FrameHeader, rotation_degrees) == 32);
    assert!(offset_of!(FrameHeader, bit_depth) == 36);
    assert!(offset_of!(FrameHeader, word_bits) == 37);
    assert!(offset_of!(FrameHeader, value_alignment) == 38);
    assert!(offset_of!(FrameHeader, plane_count) == 39);
    assert!(offset_of!(FrameHeader, bytes_used) == 40);
    assert!(offset_of!(FrameHeader, data_offset) == 48);
    assert!(offset_of!(FrameHeader, copies) == 52);
    assert!(offset_of!(FrameHeader, planes) == 56);
    assert!(offset_of!(FrameHeader, capture_ns) == 88);
    assert!(offset_of!(FrameHeader, capture_clock) == 96);
    assert!(offset_of!(FrameHeader, capture_kind) == 100);
    assert!(offset_of!(FrameHeader, dequeue_ns) == 104);
    assert!(offset_of!(FrameHeader, publish_ns) == 112);
    assert!(offset_of!(FrameHeader, frame_time_ns) == 120);
    assert!(offset_of!(FrameHeader, exposure_ns) == 128);
    assert!(offset_of!(FrameHeader, gain) == 136);
    assert!(offset_of!(FrameHeader, info_number) == 140);
    assert!(offset_of!(FrameHeader, lost_in_driver) == 144);
    assert!(offset_of!(FrameHeader, lost_no_loan) == 148);
    assert!(offset_of!(FrameHeader, lost_damaged) == 152);
    assert!(offset_of!(FrameHeader, reserved) == 156);
};

/// Where the luma of a checked frame lies in its payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameLayout {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Byte of the payload with the luma of the top-left pixel.
    pub offset: usize,
    /// Bytes from a pixel to the one below.
    pub row_stride: usize,
    /// Bytes from a pixel to the one on its right.
    pub pixel_step: usize,
}

impl FrameHeader {
    /// A header of a picture whose rows and planes follow each other without gaps. Stamps, epoch and sequence are 0.
    ///
    /// Errors name the side or the format that is not possible.
    pub fn packed(fourcc: Fourcc, width: u32, height: u32) -> Result<Self, HeaderError> {
        check_sides(width, height)?;
        let shapes = fourcc.planes(width as usize, height as usize).ok_or(HeaderError::Format(fourcc))?;
        let mut planes = [Plane::default(); MAX_PLANES];
        let mut end = 0;
        for (plane, shape) in planes.iter_mut().zip(shapes.iter()) {
            *plane = Plane { offset: end, stride: shape.row_bytes as u32 };
            end += (shape.row_bytes * shape.rows) as u32;
        }
        Ok(Self {
            schema: FRAME_SCHEMA,
            fourcc: fourcc.0,
            width,
            height,
            bit_depth: 8,
            word_bits: 8,
            plane_count: shapes.len() as u8,
            bytes_used: u64::from(end),
            planes,
            ..Self::default()
        })
    }

    /// The pixel format.
    #[must_use]
    pub fn format(&self) -> Fourcc {
        Fourcc(self.fourcc)
    }

    /// Checks the header against a payload of `payload_len` bytes and says where the luma lies.
    ///
    /// A header in shared memory can change while it is read: copy it out, check the copy and use the copy only.
    pub fn validate(&self, payload_len: usize) -> Result<FrameLayout, HeaderError> {
        if self.schema != FRAME_SCHEMA {
            return Err(HeaderError::Schema { seen: self.schema, known: FRAME_SCHEMA });
        }
        check_sides(self.width, self.height)?;
        self.check_values()?;
        self.check_picture(payload_len)?;
        self.check_planes()?;
        Ok(self.layout())
    }

    fn check_values(&self) -> Result<(), HeaderError> {
        if !matches!(self.rotation_degrees, 0 | 90 | 180 | 270) {
            return Err(HeaderError::Rotation(self.rotation_degrees));
        }
        if self.bit_depth != 8 || self.word_bits != 8 {
            return Err(HeaderError::Depth { bit_depth: self.bit_depth, word_bits: self.word_bits });
        }
        Ok(())
    }

    fn check_picture(&self, payload_len: usize) -> Result<(), HeaderError> {
        // A sum that passes 64 bits fits no payload, not even one of which that many bytes are said.
        let end = u64::from(self.data_offset).checked_add(self.bytes_used);
        if end.is_none_or(|end| end > payload_len as u64) {
            let (data_offset, bytes_used) = (self.data_offset, self.bytes_used);
            return Err(HeaderError::Picture { data_offset, bytes_used, payload_len });
        }
        Ok(())
    }

    fn check_planes(&self) -> Result<(), HeaderError> {
        let format = self.format();
        let shapes =
            format.planes(self.width as usize, self.height as usize).ok_or(HeaderError::Format(format))?;
        if usize::from(self.plane_count) != shapes.len() {
            return Err(HeaderError::Planes { seen: self.plane_count, needed: shapes.len() });
        }
        for (number, (plane, shape)) in self.planes.iter().zip(shapes.iter()).enumerate() {
            if (plane.stride as usize) < shape.row_bytes {
                return Err(HeaderError::Stride {
                    plane: number,
                    stride: plane.stride,
                    row_bytes: shape.row_bytes,
                });
            }
            // Each factor is below 2^32 and the row below 2^17: the sum cannot overflow 64 bits.
            let last_row = u64::from(plane.stride) * (shape.rows as u64 - 1);
            let end = u64::from(plane.offset) + last_row + shape.row_bytes as u64;
            if end > self.bytes_used {
                return Err(HeaderError::Plane { plane: number, end, bytes_used: self.bytes_used });
            }
        }
        Ok(())
    }

    /// Only right once everything above was checked.
    fn layout(&self) -> FrameLayout {
        let (shift, pixel_step) = self.format().luma_step().unwrap_or((0, 1));
        FrameLayout {
            width: self.width as usize,
            height: self.height as usize,
            offset: self.data_offset as usize + self.planes[0].offset as usize + shift,
            row_stride: self.planes[0].stride as usize,
            pixel_step,
        }
    }
}

fn check_sides(width: u32, height: u32) -> Result<(), HeaderError> {
    let sides = MIN_SIDE..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(HeaderError::Size { width, height })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const FORMATS: [Fourcc; 6] = [GREY, NV12, NV21, YU12, YUYV, UYVY];

    #[test]
    fn a_packed_header_fits_exactly_its_own_bytes() {
        let mut random = Random::new(1);
        for format in FORMATS {
            for _ in 0..50 {
                let (width, height) = (4 + random.below(200) as u32, 4 + random.below(200) as u32);
                let header = FrameHeader::packed(format, width, height).unwrap();
                assert!(header.validate(header.bytes_used as usize).is_ok());
                assert!(header.validate(header.bytes_used as usize - 1).is_err());
            }
        }
    }

    #[test]
    fn luma_of_packed_colour_is_every_second_byte() {
        let layout = |format| FrameHeader::packed(format, 8, 4).unwrap().validate(1000).unwrap();
        assert_eq!((layout(YUYV).offset, layout(YUYV).pixel_step), (0, 2));
        assert_eq!((layout(UYVY).offset, layout(UYVY).pixel_step), (1, 2));
        assert_eq!((layout(NV12).offset, layout(NV12).pixel_step), (0, 1));
    }

    /// Whatever the numbers are: a header that passes names only bytes of its payload.
    #[test]
    fn a_header_that_passes_never_points_outside() {
        let mut random = Random::new(2);
        let mut passed = 0;
        for _ in 0..200_000 {
            let header = mangled(&mut random);
            let payload_len = random.below(30_000) as usize;
            let Ok(layout) = header.validate(payload_len) else { continue };
            passed += 1;
            let last = layout.offset
                + (layout.height - 1) * layout.row_stride
                + (layout.width - 1) * layout.pixel_step;
            assert!(last < payload_len, "{header:?} in {payload_len}");
        }
        assert!(passed > 1000, "only {passed} headers passed: the test tests nothing");
    }

    /// A right header with up to two fields replaced by something nasty.
    fn mangled(random: &mut Random) -> FrameHeader {
        let format = FORMATS[random.below(6) as usize];
        let side = |random: &mut Random| 4 + random.below(90) as u32;
        let mut header = FrameHeader::packed(format, side(random), side(random)).unwrap();
        for _ in 0..random.below(3) {
            let nasty = [0, 1, 3, 63, 1 << 16, u32::MAX, u32::MAX - 7, random.below(9000) as u32];
            let value = nasty[random.below(8) as usize];
            match random.below(9) {
                0 => header.width = value,
                1 => header.height = value,
                2 => header.data_offset = value,
                3 => header.bytes_used = u64::from(value) << random.below(33),
                4 => header.planes[random.below(4) as usize].offset = value,
                5 => header.planes[random.below(4) as usize].stride = value,
                6 => header.plane_count = value as u8,
                7 => header.fourcc = FORMATS[random.below(6) as usize].0,
                _ => header.rotation_degrees = value,
            }
        }
        header
    }

    #[test]
    fn each_lie_is_named_with_its_value() {
        let good = FrameHeader::packed(GREY, 64, 48).unwrap();
        let says = |header: FrameHeader| header.validate(64 * 48).unwrap_err().to_string();
        assert!(says(FrameHeader { width: 0, ..good }).contains("0x48"));
        assert!(says(FrameHeader { width: 16_385, ..good }).contains("16385x48"));
        assert!(says(FrameHeader { height: 49, ..good }).contains("3136"));
        assert!(says(FrameHeader { fourcc: MJPG.0, ..good }).contains("MJPG"));
        assert!(says(FrameHeader { data_offset: u32::MAX, ..good }).contains("4294967295"));
        assert!(says(FrameHeader { bytes_used: u64::MAX, ..good }).contains("18446744073709551615"));
        assert!(says(FrameHeader { schema: 9, ..good }).contains("version 9"));
        assert!(says(FrameHeader { bit_depth: 10, ..good }).contains("10 bits"));
        assert!(says(FrameHeader { plane_count: 2, ..good }).contains("2 planes"));
        assert!(says(FrameHeader { rotation_degrees: 45, ..good }).contains("45"));
    }
}
