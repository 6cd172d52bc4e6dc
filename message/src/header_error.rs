//! The ways in which a frame header can lie.

use std::fmt;

use crate::fourcc::Fourcc;
use crate::frame::{MAX_SIDE, MIN_SIDE};

/// What a frame header says that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HeaderError {
    /// The header is of another version.
    Schema {
        /// The version that the header names.
        seen: u32,
        /// The version that this code reads.
        known: u32,
    },
    /// A side is too short or too long.
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A pixel format that is not raw or not known.
    Format(Fourcc),
    /// Not a quarter turn.
    Rotation(u32),
    /// Luma that is not 8 bits in 8 bits.
    Depth {
        /// Significant bits.
        bit_depth: u8,
        /// Bits in memory.
        word_bits: u8,
    },
    /// The picture ends behind its payload.
    Picture {
        /// Where the picture begins.
        data_offset: u32,
        /// Bytes that it takes.
        bytes_used: u64,
        /// Bytes that are there.
        payload_len: usize,
    },
    /// Another number of planes than the format has.
    Planes {
        /// Planes that the header names.
        seen: u8,
        /// Planes of the format.
        needed: usize,
    },
    /// Rows of a plane overlap.
    Stride {
        /// Number of the plane.
        plane: usize,
        /// Bytes from row to row.
        stride: u32,
        /// Bytes that one row takes.
        row_bytes: usize,
    },
    /// A plane ends behind its picture.
    Plane {
        /// Number of the plane.
        plane: usize,
        /// First byte behind the plane.
        end: u64,
        /// Bytes of the picture.
        bytes_used: u64,
    },
}

impl fmt::Display for HeaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Schema { seen, known } => {
                write!(f, "frame header of version {seen}, but this program reads version {known}")
            }
            Self::Size { width, height } => {
                write!(f, "frame of {width}x{height} pixels: each side must be {MIN_SIDE} to {MAX_SIDE}")
            }
            Self::Format(fourcc) => {
                write!(f, "pixel format {fourcc} is not one of GREY, NV12, NV21, YU12, YUYV and UYVY")
            }
            Self::Rotation(degrees) => write!(f, "rotation of {degrees} degrees: use 0, 90, 180 or 270"),
            Self::Depth { bit_depth, word_bits } => {
                write!(f, "luma of {bit_depth} bits in {word_bits}: only 8 in 8 is supported")
            }
            Self::Picture { data_offset, bytes_used, payload_len } => write!(
                f,
                "picture of {bytes_used} bytes from byte {data_offset} does not fit a payload of {payload_len} bytes"
            ),
            Self::Planes { seen, needed } => write!(f, "{seen} planes, but the format has {needed}"),
            Self::Stride { plane, stride, row_bytes } => {
                write!(f, "rows of plane {plane} are {stride} bytes apart but take {row_bytes} bytes")
            }
            Self::Plane { plane, end, bytes_used } => {
                write!(f, "plane {plane} ends at byte {end}, but the picture has {bytes_used} bytes")
            }
        }
    }
}

impl std::error::Error for HeaderError {}
