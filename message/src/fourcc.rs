//! Pixel formats by their V4L2 four-character code, and where their luma lies.

use std::fmt;
use std::ops::Deref;

/// A pixel format: four ASCII letters, the first in the lowest byte, as V4L2 writes it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Fourcc(pub u32);

/// 8-bit luma and nothing else.
pub const GREY: Fourcc = Fourcc::new(*b"GREY");
/// 8-bit luma plane, then one plane of U and V in turn at half width and half height.
pub const NV12: Fourcc = Fourcc::new(*b"NV12");
/// As [`NV12`] with V before U.
pub const NV21: Fourcc = Fourcc::new(*b"NV21");
/// 8-bit luma plane, then a U and a V plane of half width and half height.
pub const YU12: Fourcc = Fourcc::new(*b"YU12");
/// Packed Y0 U Y1 V: luma is every second byte, from byte 0.
pub const YUYV: Fourcc = Fourcc::new(*b"YUYV");
/// Packed U Y0 V Y1: luma is every second byte, from byte 1.
pub const UYVY: Fourcc = Fourcc::new(*b"UYVY");
/// A JPEG picture a frame. Named by [`crate::info::CameraInfo`]; never published as a frame.
pub const MJPG: Fourcc = Fourcc::new(*b"MJPG");

/// How one plane's size follows from the frame's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneShape {
    /// Bytes that one row of the plane takes, without padding.
    pub row_bytes: usize,
    /// Rows of the plane.
    pub rows: usize,
}

/// The planes of one picture in order, without a list on the heap: they are asked for with every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneShapes {
    all: [PlaneShape; PlaneShapes::MOST],
    count: usize,
}

impl PlaneShapes {
    /// Planes that a format can have.
    const MOST: usize = 3;

    fn of<const COUNT: usize>(planes: [PlaneShape; COUNT]) -> Self {
        let mut all = [PlaneShape { row_bytes: 0, rows: 0 }; Self::MOST];
        all[..COUNT].copy_from_slice(&planes);
        Self { all, count: COUNT }
    }
}

impl Deref for PlaneShapes {
    type Target = [PlaneShape];

    fn deref(&self) -> &[PlaneShape] {
        &self.all[..self.count]
    }
}

impl Fourcc {
    /// The code of four letters.
    #[must_use]
    pub const fn new(letters: [u8; 4]) -> Self {
        Self(u32::from_le_bytes(letters))
    }

    /// The planes of a raw picture of this format in order; `None` for a format that is not raw or not known.
    #[must_use]
    pub fn planes(self, width: usize, height: usize) -> Option<PlaneShapes> {
        let luma = PlaneShape { row_bytes: width, rows: height };
        let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
        match self {
            GREY => Some(PlaneShapes::of([luma])),
            NV12 | NV21 => {
                let chroma = PlaneShape { row_bytes: 2 * half_width, rows: half_height };
                Some(PlaneShapes::of([luma, chroma]))
            }
            YU12 => {
                let chroma = PlaneShape { row_bytes: half_width, rows: half_height };
                Some(PlaneShapes::of([luma, chroma, chroma]))
            }
            YUYV | UYVY => Some(PlaneShapes::of([PlaneShape { row_bytes: 4 * half_width, rows: height }])),
            _ => None,
        }
    }

    /// Bytes from the start of plane 0 to the first luma value, and bytes from one luma value to the next.
    pub(crate) fn luma_step(self) -> Option<(usize, usize)> {
        match self {
            GREY | NV12 | NV21 | YU12 => Some((0, 1)),
            YUYV => Some((0, 2)),
            UYVY => Some((1, 2)),
            _ => None,
        }
    }
}

impl fmt::Display for Fourcc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.0.to_le_bytes();
        // Short names such as Y10 end with blanks.
        let letters = all.trim_ascii_end();
        if !letters.is_empty() && letters.iter().all(u8::is_ascii_graphic) {
            letters.iter().try_for_each(|&letter| write!(f, "{}", char::from(letter)))
        } else {
            write!(f, "0x{:08x}", self.0)
        }
    }
}

impl fmt::Debug for Fourcc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_printed_as_its_letters_and_garbage_as_a_number() {
        assert_eq!(YUYV.to_string(), "YUYV");
        assert_eq!(Fourcc::new(*b"Y10 ").to_string(), "Y10");
        assert_eq!(Fourcc(1).to_string(), "0x00000001");
    }

    #[test]
    fn odd_sizes_round_chroma_up() {
        let planes = YU12.planes(5, 3).unwrap();
        assert_eq!(planes[0], PlaneShape { row_bytes: 5, rows: 3 });
        assert_eq!(planes[1], PlaneShape { row_bytes: 3, rows: 2 });
        assert_eq!(YUYV.planes(5, 3).unwrap()[0], PlaneShape { row_bytes: 12, rows: 3 });
        assert!(MJPG.planes(4, 4).is_none());
    }
}
