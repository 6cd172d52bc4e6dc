//! Format, size and bytes of a frame.

use std::fmt;

use tagbus_message::frame::{
    Fourcc, FrameHeader, GREY, HeaderError, MAX_PLANES, MJPG, NV12, NV21, Plane, UYVY, YU12, YUYV,
};

/// The raw formats that can be published, by the names that Video4Linux and the command line use.
pub const RAW_FORMATS: [Fourcc; 6] = [GREY, NV12, NV21, YU12, YUYV, UYVY];

const fn code(name: &[u8; 4]) -> Fourcc {
    Fourcc::new(*name)
}

/// The formats that devices may be asked for: raw ones, also with planes apart; luma of 10, 12 and 16 bits; JPEG pictures; Bayer
/// mosaics.
pub const FORMATS: [Fourcc; 18] = [
    GREY,
    NV12,
    NV21,
    YU12,
    YUYV,
    UYVY,
    code(b"NM12"),
    code(b"NM21"),
    code(b"YM12"),
    code(b"Y10 "),
    code(b"Y10P"),
    code(b"Y12 "),
    code(b"Y16 "),
    MJPG,
    code(b"GRBG"),
    code(b"GBRG"),
    code(b"RGGB"),
    code(b"BA81"),
];

/// Reads the name of a format, in upper or lower case.
///
/// # Errors
/// No format has this name.
pub fn parse_format(name: &str) -> Result<Fourcc, UnknownFormat> {
    let found = FORMATS.into_iter().find(|format| format.to_string().eq_ignore_ascii_case(name));
    found.ok_or_else(|| UnknownFormat(name.to_string()))
}

/// A pixel format that is not known, by the name that was given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownFormat(pub String);

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown pixel format '{}': one of", self.0)?;
        FORMATS.iter().try_for_each(|format| write!(f, " {format}"))
    }
}

impl std::error::Error for UnknownFormat {}

/// Format and size of a frame and where its planes lie, checked when it is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameShape {
    format: Fourcc,
    width: u32,
    height: u32,
    bytes: usize,
    planes: [Plane; MAX_PLANES],
}

impl FrameShape {
    /// A frame of `width` x `height` pixels whose rows follow each other without gaps.
    ///
    /// # Errors
    /// A side that is too short or too long, or a format that is not raw.
    pub fn new(format: Fourcc, width: u32, height: u32) -> Result<FrameShape, HeaderError> {
        let header = FrameHeader::packed(format, width, height)?;
        Ok(FrameShape { format, width, height, bytes: header.bytes_used as usize, planes: header.planes })
    }

    /// A frame whose planes lie where a device puts them, in `bytes` bytes.
    ///
    /// # Errors
    /// A side that is too short or too long, a format that is not raw, or a plane that does not lie inside.
    #[cfg(feature = "v4l")]
    pub(crate) fn placed(
        format: Fourcc,
        [width, height]: [u32; 2],
        planes: [Plane; MAX_PLANES],
        bytes: usize,
    ) -> Result<FrameShape, HeaderError> {
        let shape = FrameShape { format, width, height, bytes, planes };
        FrameHeader::packed(format, width, height)?;
        shape.header().validate(bytes).map(|_| shape)
    }

    /// A grey frame.
    ///
    /// # Errors
    /// A side that is too short or too long.
    pub fn grey(width: u32, height: u32) -> Result<FrameShape, HeaderError> {
        FrameShape::new(GREY, width, height)
    }

    /// The pixel format.
    #[must_use]
    pub fn format(self) -> Fourcc {
        self.format
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(self) -> u32 {
        self.height
    }

    /// Bytes of the whole frame, all planes.
    #[must_use]
    pub fn bytes(self) -> usize {
        self.bytes
    }

    /// A header that describes a frame of this shape; epoch, sequence and stamps are 0.
    pub(crate) fn header(self) -> FrameHeader {
        // The shape was checked by this very function when it was made.
        let packed = FrameHeader::packed(self.format, self.width, self.height).unwrap_or_default();
        FrameHeader { bytes_used: self.bytes as u64, planes: self.planes, ..packed }
    }
}

impl fmt::Display for FrameShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{} {}", self.width, self.height, self.format)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_read_back_from_its_name_in_any_case() {
        for format in FORMATS {
            assert_eq!(parse_format(&format.to_string()), Ok(format));
            assert_eq!(parse_format(&format.to_string().to_lowercase()), Ok(format));
        }
        let error = parse_format("H264").unwrap_err().to_string();
        assert!(error.contains("'H264'") && error.contains("NV12"), "{error}");
    }

    #[test]
    fn frames_of_0x0_1x1_and_16385_pixels_are_refused() {
        for (width, height) in [(0, 0), (1, 1), (16_385, 16), (16, 16_385)] {
            assert!(FrameShape::grey(width, height).is_err(), "{width}x{height}");
        }
    }

    #[test]
    fn the_bytes_of_a_frame_follow_from_its_format() {
        let bytes = |format| FrameShape::new(format, 320, 240).unwrap().bytes();
        assert_eq!([bytes(GREY), bytes(NV12), bytes(YUYV)], [76_800, 115_200, 153_600]);
    }
}
