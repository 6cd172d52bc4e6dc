//! What a camera is told: source, size, rate, and where it publishes.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use tagbus_message::domain::Domain;
use tagbus_message::frame::Fourcc;

use crate::control::ControlSettings;

/// Frames a second when none are named.
pub const DEFAULT_FRAMERATE: f64 = 30.0;

/// The fastest rate that can be asked for, in frames a second.
pub const MAX_FRAMERATE: f64 = 10_000.0;

/// Seed of the built-in scene when none is named.
pub const DEFAULT_SEED: u64 = 1;

/// Where frames come from.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Source {
    /// The built-in scene with known tags: `scene` or `scene:SEED`.
    Scene {
        /// Equal seeds make equal pictures.
        seed: u64,
    },
    /// Files: `replay:PATH` with a picture, a folder of pictures, a video of JPEG frames (bare or AVI), or a raw file.
    Replay(PathBuf),
    /// A Video4Linux device: `v4l:/dev/video0`, or its path or id (`v4l:/dev/v4l/by-id/...`).
    V4l(PathBuf),
    /// A camera on the Raspberry Pi's ribbon connector: `rpicam`, or `rpicam:/path/of/a/program` that takes the options of rpicam-vid.
    Rpicam(Option<PathBuf>),
    /// A camera of the system's libcamera: `libcamera` for the first one, or `libcamera:ID`. Only in builds with the feature `libcamera`.
    Libcamera(Option<String>),
}

impl FromStr for Source {
    type Err = SourceTextError;

    fn from_str(text: &str) -> Result<Source, SourceTextError> {
        let unknown = || SourceTextError(text.to_string());
        match text.split_once(':') {
            None if text == "scene" => Ok(Source::Scene { seed: DEFAULT_SEED }),
            None if text == "rpicam" => Ok(Source::Rpicam(None)),
            None if text == "libcamera" => Ok(Source::Libcamera(None)),
            Some(("scene", seed)) => seed.parse().map(|seed| Source::Scene { seed }).map_err(|_| unknown()),
            Some(("replay", path)) if !path.is_empty() => Ok(Source::Replay(path.into())),
            Some(("v4l", path)) if !path.is_empty() => Ok(Source::V4l(path.into())),
            Some(("rpicam", path)) if path.starts_with('/') => Ok(Source::Rpicam(Some(path.into()))),
            Some(("libcamera", id)) if !id.is_empty() => Ok(Source::Libcamera(Some(id.into()))),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Source {
    /// The text from which the source is read back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene { seed: DEFAULT_SEED } => f.write_str("scene"),
            Self::Scene { seed } => write!(f, "scene:{seed}"),
            Self::Replay(path) => write!(f, "replay:{}", path.display()),
            Self::V4l(path) => write!(f, "v4l:{}", path.display()),
            Self::Rpicam(None) => f.write_str("rpicam"),
            Self::Rpicam(Some(program)) => write!(f, "rpicam:{}", program.display()),
            Self::Libcamera(None) => f.write_str("libcamera"),
            Self::Libcamera(Some(id)) => write!(f, "libcamera:{id}"),
        }
    }
}

/// A text that names no source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceTextError(pub String);

impl fmt::Display for SourceTextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "unknown source '{}': scene, scene:SEED, replay:PATH, v4l:/dev/videoN, rpicam or libcamera",
            self.0
        )?;
        match self.0.starts_with("/dev/") {
            true => write!(f, " (did you mean v4l:{}?)", self.0),
            false if std::path::Path::new(&self.0).exists() => {
                write!(f, " (did you mean replay:{}?)", self.0)
            }
            false => Ok(()),
        }
    }
}

impl std::error::Error for SourceTextError {}

/// How fast frames follow each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// So many frames a second.
    Framerate(f64),
    /// The next frame as soon as the last one is sent.
    AsFastAsPossible,
}

impl Pace {
    /// A rate in frames a second.
    ///
    /// # Errors
    /// Zero, negative, above [`MAX_FRAMERATE`], or not a number.
    pub fn from_framerate(framerate: f64) -> Result<Pace, FramerateError> {
        match framerate > 0.0 && framerate <= MAX_FRAMERATE {
            true => Ok(Pace::Framerate(framerate)),
            false => Err(FramerateError(framerate)),
        }
    }

    /// Frames a second, where a rate was named.
    #[must_use]
    pub fn framerate(self) -> Option<f64> {
        match self {
            Self::Framerate(framerate) => Some(framerate),
            Self::AsFastAsPossible => None,
        }
    }
}

impl Default for Pace {
    fn default() -> Self {
        Self::Framerate(DEFAULT_FRAMERATE)
    }
}

/// A frame rate that cannot be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramerateError(pub f64);

impl fmt::Display for FramerateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frame rate {}: more than 0 and at most {MAX_FRAMERATE} frames a second are allowed",
            self.0
        )
    }
}

impl std::error::Error for FramerateError {}

/// What happens after the last frame of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repeat {
    /// The camera ends.
    Once,
    /// The first frame follows.
    #[default]
    Loop,
}

/// How frames are made from the source.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SourceOptions {
    /// Pixels a row: of the scene (default 640), of a raw file (must be named) or of a device (default: as it is set). Pictures and videos know their own size.
    pub width: Option<u32>,
    /// Rows: of the scene (default 480), of a raw file (must be named) or of a device (default: as it is set).
    pub height: Option<u32>,
    /// The format of a device's frames, or of a raw file; naming one makes a replayed file a raw file.
    pub format: Option<Fourcc>,
    /// Controls of a device, set whenever it is opened; of `rpicam` further options of the program. Other sources have none.
    pub controls: ControlSettings,
    /// How fast frames follow each other.
    pub pace: Pace,
    /// Whether a replay starts again after its end.
    pub repeat: Repeat,
    /// How long a frame of scene or replay is kept back before it is published: what shows whether latencies are measured right.
    pub delay: Duration,
}

/// Everything that [`run`](crate::run) has to know.
#[derive(Debug, Clone)]
pub struct CameraConfig {
    /// The bus on which the camera publishes.
    pub domain: Domain,
    /// The camera's name, `cam0` by custom; unique in its domain.
    pub camera: String,
    /// Where frames come from.
    pub source: Source,
    /// How frames are made from the source.
    pub options: SourceOptions,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_read_back_from_what_it_prints() {
        let texts = [
            "scene",
            "scene:7",
            "replay:/a b/c:d",
            "v4l:/dev/v4l/by-id/usb-x:y",
            "rpicam",
            "rpicam:/usr/bin/x",
            "libcamera",
            "libcamera:/base/soc/i2c0mux/i2c@1/imx219@10",
        ];
        for text in texts {
            assert_eq!(text.parse::<Source>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn texts_that_name_no_source_are_refused_with_what_is_allowed_and_what_was_probably_meant() {
        for text in ["", "scene:", "scene:-1", "replay:", "v4l:", "rpicam:0", "libcamera:", "webcam"] {
            let error = text.parse::<Source>().unwrap_err().to_string();
            assert!(error.contains(&format!("'{text}'")) && error.contains("replay:PATH"), "{error}");
        }
        let error = "/dev/video3".parse::<Source>().unwrap_err().to_string();
        assert!(error.contains("did you mean v4l:/dev/video3?"), "{error}");
        let error = "/tmp".parse::<Source>().unwrap_err().to_string();
        assert!(error.contains("did you mean replay:/tmp?"), "{error}");
    }

    #[test]
    fn rates_that_cannot_be_are_refused() {
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(Pace::from_framerate(rate).is_err(), "{rate}");
        }
        assert_eq!(Pace::from_framerate(30.0).ok(), Some(Pace::default()));
    }
}
