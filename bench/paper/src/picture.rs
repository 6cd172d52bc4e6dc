//! A grey picture in memory of its own.

use std::fmt;

/// Larger sides would let the slope of eq. 2 reach its 2^16.
const MAX_SIDE: usize = 1 << 13;

/// Grey levels, row after row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    luma: Vec<u8>,
}

/// Why grey levels are no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureError {
    /// A side is 0 or too long.
    Side {
        /// Width and height that were given.
        size: [usize; 2],
    },
    /// More or fewer grey levels than pixels.
    Length {
        /// Grey levels that were given.
        seen: usize,
        /// Width times height.
        wanted: usize,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Side { size: [width, height] } => {
                write!(f, "a picture of {width}x{height} is not possible: use sides from 1 to {MAX_SIDE}")
            }
            Self::Length { seen, wanted } => {
                write!(f, "{seen} grey levels do not fill the picture: give {wanted}, one a pixel")
            }
        }
    }
}

impl std::error::Error for PictureError {}

impl Picture {
    /// A picture of `width * height` grey levels.
    ///
    /// # Errors
    /// [`PictureError`] when a side is 0 or longer than 8192, or the grey levels do not fill the picture.
    pub fn new(width: usize, height: usize, luma: Vec<u8>) -> Result<Picture, PictureError> {
        if [width, height].iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
            return Err(PictureError::Side { size: [width, height] });
        }
        match luma.len() == width * height {
            true => Ok(Picture { width, height, luma }),
            false => Err(PictureError::Length { seen: luma.len(), wanted: width * height }),
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    pub(crate) fn at(&self, x: usize, y: usize) -> u8 {
        self.luma[y * self.width + x]
    }

    /// A picture whose grey levels are computed; its sides come from those of another picture, so they are possible.
    pub(crate) fn computed(width: usize, height: usize, mut grey: impl FnMut(usize, usize) -> u8) -> Picture {
        let mut luma = Vec::with_capacity(width * height);
        for y in 0..height {
            luma.extend((0..width).map(|x| grey(x, y)));
        }
        Picture { width, height, luma }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_levels_that_do_not_fill_the_picture_are_refused() {
        let refused = Picture::new(4, 3, vec![0; 11]).unwrap_err();
        assert_eq!(refused.to_string(), "11 grey levels do not fill the picture: give 12, one a pixel");
        assert!(Picture::new(0, 3, Vec::new()).unwrap_err().to_string().contains("0x3"));
        assert!(Picture::new(MAX_SIDE + 1, 1, vec![0; MAX_SIDE + 1]).is_err());
    }

    #[test]
    fn rows_follow_each_other() {
        let picture = Picture::new(3, 2, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!((picture.at(2, 0), picture.at(0, 1)), (3, 4));
        assert_eq!(picture, Picture::computed(3, 2, |x, y| (1 + x + 3 * y) as u8));
    }
}
