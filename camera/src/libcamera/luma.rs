//! Where luma lies in the formats of libcamera, and its one copy.
//!
//! ```text
//! R8, NV12, NV21, YUV420, YUV422    Y Y Y Y ...           the first plane
//! YUYV, UYVY                        Y . Y .   . Y . Y     every second byte
//! RGB888, BGR888                    . G . . G .           green, the nearest there is
//! XRGB8888, XBGR8888                . G . . . G . .
//! ```
#![cfg_attr(not(feature = "libcamera"), allow(dead_code, reason = "its tests run in every build"))]

/// Where the luma of a pixel lies in a row of the first plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Luma {
    /// Bytes from pixel to pixel.
    pub(super) step: usize,
    /// Bytes before the first.
    pub(super) first: usize,
}

/// The formats that can be used, by their codes (those of the kernel's graphics, `drm_fourcc.h`); best first.
pub(super) const USABLE: [([u8; 4], Luma); 11] = [
    (*b"R8  ", Luma { step: 1, first: 0 }),
    (*b"NV12", Luma { step: 1, first: 0 }),
    (*b"NV21", Luma { step: 1, first: 0 }),
    (*b"YU12", Luma { step: 1, first: 0 }),
    (*b"YU16", Luma { step: 1, first: 0 }),
    (*b"YUYV", Luma { step: 2, first: 0 }),
    (*b"UYVY", Luma { step: 2, first: 1 }),
    (*b"RG24", Luma { step: 3, first: 1 }),
    (*b"BG24", Luma { step: 3, first: 1 }),
    (*b"XR24", Luma { step: 4, first: 1 }),
    (*b"XB24", Luma { step: 4, first: 1 }),
];

impl Luma {
    /// Bytes of a row, from the first to behind the last that is read.
    pub(super) fn row_bytes(self, width: usize) -> usize {
        self.first + self.step * (width - 1) + 1
    }

    /// Bytes of a plane, from the first to behind the last that is read.
    pub(super) fn plane_bytes(self, [width, height]: [usize; 2], stride: usize) -> usize {
        stride * (height - 1) + self.row_bytes(width)
    }

    /// Writes rows of `width` bytes to `to`, out of rows that lie `stride` bytes apart in `from`.
    pub(super) fn copy(self, from: &[u8], stride: usize, width: usize, to: &mut [u8]) {
        for (row, to) in from.chunks(stride).zip(to.chunks_exact_mut(width)) {
            let row = &row[self.first..self.row_bytes(width)];
            match self.step {
                1 => to.copy_from_slice(row),
                step => to.iter_mut().zip(row.iter().step_by(step)).for_each(|(to, luma)| *to = *luma),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luma_of_every_order_of_bytes_is_found_and_padding_is_left_out() {
        for (code, luma) in USABLE {
            let (width, height, stride) = (3, 2, 16);
            let mut plane = vec![255; luma.plane_bytes([width, height], stride)];
            for (pixel, value) in [10, 11, 12, 20, 21, 22].into_iter().enumerate() {
                plane[stride * (pixel / width) + luma.first + luma.step * (pixel % width)] = value;
            }
            let mut seen = vec![0; width * height];
            luma.copy(&plane, stride, width, &mut seen);
            assert_eq!(seen, [10, 11, 12, 20, 21, 22], "{}", String::from_utf8_lossy(&code));
        }
    }
}
