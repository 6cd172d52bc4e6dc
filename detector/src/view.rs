//! A frame's luma where it lies: geometry checked once, pixels never copied.

use std::fmt;

/// The widest and highest frame that is taken, in pixels.
pub const MAX_SIDE: usize = 16_384;
/// The smallest side that is taken: below this no tile fits.
pub const MIN_SIDE: usize = 4;

/// Where the luma of a frame lies in its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Geometry {
    /// First byte of the top-left pixel's luma.
    pub offset: usize,
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bytes from a pixel to the one below.
    pub row_stride: usize,
    /// Bytes from a pixel to the one on its right: 1 for GREY and NV12, 2 for YUYV.
    pub pixel_step: usize,
}

/// A checked view of 8-bit luma in somebody else's bytes.
#[derive(Clone, Copy)]
pub struct LumaView<'a> {
    bytes: &'a [u8],
    geometry: Geometry,
}

impl<'a> LumaView<'a> {
    /// A view of `bytes`; every pixel that `geometry` names must lie inside.
    pub fn new(bytes: &'a [u8], geometry: Geometry) -> Result<Self, ViewError> {
        let Geometry { offset, width, height, row_stride, pixel_step } = geometry;
        let sides = MIN_SIDE..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(ViewError::Size { width, height });
        }
        let row_bytes = (width - 1) * pixel_step + 1;
        if pixel_step == 0 || pixel_step > 8 || row_stride < row_bytes {
            return Err(ViewError::Stride { row_stride, row_bytes });
        }
        let needed = (height - 1)
            .checked_mul(row_stride)
            .and_then(|n| n.checked_add(row_bytes))
            .and_then(|n| n.checked_add(offset));
        match needed {
            Some(needed) if needed <= bytes.len() => Ok(Self { bytes, geometry }),
            needed => Err(ViewError::Bytes { needed: needed.unwrap_or(usize::MAX), have: bytes.len() }),
        }
    }

    /// A view of rows of 8-bit pixels that follow each other without gaps.
    pub fn grey(bytes: &'a [u8], width: usize, height: usize) -> Result<Self, ViewError> {
        Self::new(bytes, Geometry { offset: 0, width, height, row_stride: width, pixel_step: 1 })
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.geometry.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.geometry.height
    }

    /// Where the luma lies.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// The bytes the view was made of.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }
}

/// Why a frame was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ViewError {
    /// A side is too short or too long.
    Size {
        /// Pixels a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Rows overlap.
    Stride {
        /// Bytes from row to row.
        row_stride: usize,
        /// Bytes that one row takes.
        row_bytes: usize,
    },
    /// The bytes end before the picture does.
    Bytes {
        /// Bytes that the geometry asks for.
        needed: usize,
        /// Bytes that are there.
        have: usize,
    },
}

impl fmt::Display for ViewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height } => {
                write!(
                    f,
                    "a frame of {width}x{height} pixels cannot be searched: each side must be {MIN_SIDE} to {MAX_SIDE} pixels"
                )
            }
            Self::Stride { row_stride, row_bytes } => {
                write!(
                    f,
                    "rows are {row_stride} bytes apart but take {row_bytes} bytes: the stride must be at least that"
                )
            }
            Self::Bytes { needed, have } => {
                write!(f, "the picture needs {needed} bytes but only {have} are there")
            }
        }
    }
}

impl std::error::Error for ViewError {}
