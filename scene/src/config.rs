//! What a scene is asked to be, and why it may be refused.

use crate::tag::TagError;
use std::fmt;
use tagbus_family::UnknownFamily;

/// The smallest and the largest width and height.
const SIZES: std::ops::RangeInclusive<usize> = 16..=16_384;

/// What a scene shows, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneConfig {
    /// Width in pixels, 16..=16384. Default 640.
    pub width: usize,
    /// Height in pixels, 16..=16384. Default 480.
    pub height: usize,
    /// Frames a second. Tags move by the second, so a higher rate means smaller steps. Default 30.
    pub framerate: f64,
    /// Chooses the room, the ids and the ways of the tags. Default 1.
    pub seed: u64,
    /// One tag for each entry: the name of a published family, or several names joined by `/` for tags nested in each
    /// other, the outermost first. Default: two tag36h11, a tagStandard41h12, a tag25h9, a tagCircle21h7, and
    /// `tagCustom48h12/tagStandard41h12`.
    pub families: Vec<String>,
}

impl Default for SceneConfig {
    fn default() -> SceneConfig {
        let families = [
            "tagCustom48h12/tagStandard41h12",
            "tag36h11",
            "tagStandard41h12",
            "tag25h9",
            "tagCircle21h7",
            "tag36h11",
        ];
        let families = families.map(str::to_owned).to_vec();
        SceneConfig { width: 640, height: 480, framerate: 30.0, seed: 1, families }
    }
}

impl SceneConfig {
    /// Refuses sizes and rates out of range; families are looked up where the tags are chosen.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let SceneConfig { width, height, framerate, .. } = *self;
        if !SIZES.contains(&width) || !SIZES.contains(&height) {
            return Err(SceneError::Size { width, height });
        }
        if !framerate.is_finite() || framerate <= 0.0 {
            return Err(SceneError::Framerate(framerate));
        }
        Ok(())
    }
}

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// Width or height is out of range.
    Size {
        /// The width asked for, in pixels.
        width: usize,
        /// The height asked for, in pixels.
        height: usize,
    },
    /// The frame rate is not a positive number.
    Framerate(f64),
    /// A family does not exist.
    Family(UnknownFamily),
    /// A tag cannot be made, or cannot be nested in the one named before it.
    Tag(TagError),
}

impl fmt::Display for SceneError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let (least, most) = (SIZES.start(), SIZES.end());
        match self {
            SceneError::Size { width, height } => {
                write!(
                    formatter,
                    "a scene of {width}x{height} pixels: width and height go from {least} to {most}"
                )
            }
            SceneError::Framerate(framerate) => {
                write!(
                    formatter,
                    "a scene with {framerate} frames a second: give a positive number such as 30"
                )
            }
            SceneError::Family(unknown) => unknown.fmt(formatter),
            SceneError::Tag(refused) => refused.fmt(formatter),
        }
    }
}

impl std::error::Error for SceneError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_out_of_range_are_refused() {
        for (width, height) in [(15, 480), (640, 0), (16_385, 480), (640, usize::MAX)] {
            let config = SceneConfig { width, height, ..SceneConfig::default() };
            assert_eq!(config.check().unwrap_err(), SceneError::Size { width, height });
        }
        let message = SceneError::Size { width: 1, height: 2 }.to_string();
        assert_eq!(message, "a scene of 1x2 pixels: width and height go from 16 to 16384");
    }

    #[test]
    fn framerates_that_are_not_positive_numbers_are_refused() {
        for framerate in [0.0, -30.0, f64::NAN, f64::INFINITY] {
            let refused = SceneConfig { framerate, ..SceneConfig::default() }.check().unwrap_err();
            assert!(matches!(refused, SceneError::Framerate(_)), "{refused:?}");
        }
    }
}
