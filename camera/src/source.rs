//! What a source of frames is, and how one is opened.
//!
//! A source is asked for one frame after the other and writes each once, straight into the memory that is going to be published:
//!
//! ```text
//! run ── loan ──▶ &mut [u8] ──▶ FrameSource::next ──▶ Filled { shape, copies } ──▶ header, send, notify
//! ```
//!
//! A device that fills memory on its own is no `FrameSource`: it takes several loans into its queue and hands each back
//! filled (`device/`). It meets this way at the loan, which owns its memory and moves, and behind it at header, send and notify.
//! Everything here is always streaming; the states waiting and lost are a device's.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use tagbus_message::frame::{Fourcc, GREY, HeaderError};
use tagbus_scene::SceneError;

use crate::config::{Repeat, Source, SourceOptions};
use crate::folder::FolderSource;
use crate::format::FrameShape;
use crate::mjpeg::{self, MjpegSource};
use crate::picture::PictureError;
use crate::raw::RawSource;
use crate::still::StillSource;
use crate::synthetic::SceneSource;

/// What lies in the memory after a source has written a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filled {
    /// Format and true size of this frame; its bytes are the first `shape.bytes()`.
    pub shape: FrameShape,
    /// Passes over this frame by this process after it existed in memory: 0 when it was rendered, decoded or read by the
    /// kernel straight into its place, or the decoding itself is its one pass; see each source.
    pub copies: u8,
}

/// Frames that were skipped because they could not be used.
#[derive(Debug, Default)]
pub struct Damage {
    /// How many in all.
    pub count: u64,
    /// Why the last one was skipped.
    pub last_reason: String,
}

impl Damage {
    /// Counts one frame and keeps the reason.
    pub(crate) fn note(&mut self, reason: impl fmt::Display) {
        self.count += 1;
        self.last_reason = reason.to_string();
    }
}

/// A source of frames that are made when they are asked for.
pub trait FrameSource {
    /// Format and size of the largest frame, which the memory is made for.
    fn largest(&self) -> FrameShape;

    /// What the source is, in a few words.
    fn description(&self) -> &'static str;

    /// The format in which the source holds its frames; MJPG where they are decoded on their way.
    fn stored_format(&self) -> Fourcc {
        self.largest().format()
    }

    /// Writes the next frame into `into` (at least `largest().bytes()` bytes); `None` after the last one.
    ///
    /// Frames that cannot be used are noted in `damage` and passed over.
    ///
    /// # Errors
    /// The input became unreadable, or holds no usable frame any more.
    fn next(&mut self, into: &mut [u8], damage: &mut Damage) -> Result<Option<Filled>, FrameError>;
}

/// Why there are no further frames.
#[derive(Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// The input cannot be read any more.
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// A whole pass over the input brought no usable frame.
    NothingUsable {
        /// The file or folder.
        path: PathBuf,
        /// Why the last frame was skipped.
        reason: String,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: cannot be read any more: {error}", path.display()),
            Self::NothingUsable { path, reason } => {
                write!(f, "{}: no frame in it can be used; the last reason: {reason}", path.display())
            }
        }
    }
}

impl std::error::Error for FrameError {}

/// Why a source cannot be opened.
#[derive(Debug)]
#[non_exhaustive]
pub enum OpenError {
    /// File or folder cannot be read.
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// The folder holds no picture.
    NoPictures {
        /// The folder.
        path: PathBuf,
        /// How many files it holds that are no pictures.
        other_files: usize,
    },
    /// The file's content is not recognised, and no raw format was given.
    Unrecognised {
        /// The file.
        path: PathBuf,
    },
    /// A raw format was given without the frame's size.
    SizeMissing {
        /// The file.
        path: PathBuf,
    },
    /// The raw file is shorter than one frame.
    TooShort {
        /// The file.
        path: PathBuf,
        /// Bytes in the file.
        length: u64,
        /// Size and format that were given.
        frame: String,
        /// Bytes of such a frame.
        needed: usize,
    },
    /// The source does not make frames of the format that was given.
    Format {
        /// The source.
        source: String,
        /// The format.
        format: Fourcc,
    },
    /// Frames of this size or format cannot be published.
    Shape {
        /// The file, or the name of the source.
        path: PathBuf,
        /// What is allowed.
        error: HeaderError,
    },
    /// The one picture cannot be used.
    Picture(PictureError),
    /// No frame of the video can be used.
    Frame(FrameError),
    /// The built-in scene refuses its configuration.
    Scene(SceneError),
    /// The video device cannot be used; the text says why and what helps.
    Device(String),
    /// A source that this version does not have; the text says what to use.
    NotAvailable(&'static str),
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: cannot be read: {error}", path.display()),
            Self::NoPictures { path, other_files } => {
                write!(f, "{}: no picture in this folder ({other_files} other files)", path.display())
            }
            Self::Unrecognised { path } => write!(
                f,
                "{}: neither a picture (JPEG, PNG, PNM, BMP) nor a video of JPEG frames; a raw file needs --format, --width and --height",
                path.display()
            ),
            Self::SizeMissing { path } => {
                write!(f, "{}: a raw file needs --width and --height beside --format", path.display())
            }
            Self::TooShort { path, length, frame, needed } => {
                write!(f, "{}: {length} bytes, but one frame of {frame} has {needed}", path.display())
            }
            Self::Format { source, format } => {
                write!(f, "{source}: makes GREY frames, not {format}; --format is for raw files and devices")
            }
            Self::Shape { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Picture(error) => error.fmt(f),
            Self::Frame(error) => error.fmt(f),
            Self::Scene(error) => error.fmt(f),
            Self::Device(text) => f.write_str(text),
            Self::NotAvailable(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for OpenError {}

impl From<PictureError> for OpenError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}

impl From<FrameError> for OpenError {
    fn from(error: FrameError) -> Self {
        Self::Frame(error)
    }
}

/// Opens a source; pictures of a folder that cannot be used are noted in `damage`.
///
/// # Errors
/// See [`OpenError`].
pub fn open(
    source: &Source,
    options: &SourceOptions,
    damage: &mut Damage,
) -> Result<Box<dyn FrameSource>, OpenError> {
    match source {
        Source::Scene { seed } => {
            only_grey(source, options)?;
            Ok(Box::new(SceneSource::open(*seed, options)?))
        }
        Source::Replay(path) if path.is_dir() => {
            only_grey(source, options)?;
            Ok(Box::new(FolderSource::open(path, options.repeat, damage)?))
        }
        Source::Replay(path) => open_file(path, options),
        Source::V4l(_) | Source::Rpicam(_) | Source::Libcamera(_) => {
            Err(OpenError::NotAvailable("a device is not asked for frames: it delivers them"))
        }
    }
}

/// A stated format means raw; otherwise the content decides.
fn open_file(path: &Path, options: &SourceOptions) -> Result<Box<dyn FrameSource>, OpenError> {
    if let Some(format) = options.format {
        let (Some(width), Some(height)) = (options.width, options.height) else {
            return Err(OpenError::SizeMissing { path: path.into() });
        };
        return Ok(Box::new(RawSource::open(path, format, [width, height], options.repeat)?));
    }
    if mjpeg::holds_video(path).map_err(|error| OpenError::Io { path: path.into(), error })? {
        return Ok(Box::new(MjpegSource::open(path, options.repeat)?));
    }
    open_picture(path, options.repeat)
}

fn open_picture(path: &Path, repeat: Repeat) -> Result<Box<dyn FrameSource>, OpenError> {
    match StillSource::open(path, repeat) {
        Ok(still) => Ok(Box::new(still)),
        Err(OpenError::Picture(PictureError::NotAPicture { path })) => Err(OpenError::Unrecognised { path }),
        Err(error) => Err(error),
    }
}

fn only_grey(source: &Source, options: &SourceOptions) -> Result<(), OpenError> {
    match options.format {
        None | Some(GREY) => Ok(()),
        Some(format) => Err(OpenError::Format { source: source.to_string(), format }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::{TestFolder, real_data};
    use tagbus_message::frame::{NV12, YUYV};

    fn refusal(source: &str, options: &SourceOptions) -> String {
        let source: Source = source.parse().unwrap();
        open(&source, options, &mut Damage::default()).err().unwrap().to_string()
    }

    fn sized(width: u32, height: u32, format: Option<Fourcc>) -> SourceOptions {
        SourceOptions { width: Some(width), height: Some(height), format, ..SourceOptions::default() }
    }

    #[test]
    fn every_kind_of_file_is_known_by_its_content_and_a_raw_file_by_its_format() {
        let kinds = [
            ("tags", SourceOptions::default(), "folder of pictures"),
            ("raw/mjpeg__mjpeg.jpg", SourceOptions::default(), "one picture"),
            ("raw/libvpl__cars_320x240.mjpeg", SourceOptions::default(), "video of JPEG frames"),
            ("raw/wpical__short.avi", SourceOptions::default(), "video of JPEG frames"),
            ("raw/libvpl__cars_320x240.nv12", sized(320, 240, Some(NV12)), "raw file"),
        ];
        for (file, options, description) in kinds {
            let Some(path) = real_data(file) else { return };
            let source = open(&Source::Replay(path), &options, &mut Damage::default()).unwrap();
            assert_eq!(source.description(), description, "{file}");
        }
    }

    #[test]
    fn the_scene_comes_in_the_size_that_is_asked_for() {
        let source = "scene:5".parse().unwrap();
        let mut scene = open(&source, &sized(320, 200, None), &mut Damage::default()).unwrap();
        assert_eq!(scene.largest(), FrameShape::grey(320, 200).unwrap());
        let mut frames = [vec![0; 64_000], vec![0; 64_000]];
        for frame in &mut frames {
            let filled = scene.next(frame, &mut Damage::default()).unwrap().unwrap();
            assert_eq!((filled.shape, filled.copies), (scene.largest(), 0));
        }
        assert_ne!(frames[0], frames[1]);
    }

    #[test]
    fn what_cannot_be_opened_is_refused_with_the_reason_and_the_way_out() {
        let none = SourceOptions::default();
        let folder = TestFolder::new("source");
        let text = folder.file("text", "hello").display().to_string();
        let one_pixel = folder.file("one.pgm", b"P5 1 1 255\n\0").display().to_string();
        let cases = [
            ("replay:/no/such/path".to_string(), &none, "/no/such/path: cannot be read: No such file"),
            (format!("replay:{}", folder.path().join("x").display()), &none, "No such file"),
            (format!("replay:{text}"), &none, "a raw file needs --format, --width and --height"),
            (
                format!("replay:{text}"),
                &SourceOptions { format: Some(YUYV), ..none.clone() },
                "needs --width and --height",
            ),
            (format!("replay:{text}"), &sized(0, 0, Some(YUYV)), "frame of 0x0 pixels"),
            (
                format!("replay:{text}"),
                &sized(640, 480, Some(YUYV)),
                "5 bytes, but one frame of 640x480 YUYV has 614400",
            ),
            (format!("replay:{one_pixel}"), &none, "frame of 1x1 pixels"),
            ("scene".to_string(), &sized(16_385, 480, None), "frame of 16385x480 pixels"),
            ("scene".to_string(), &sized(640, 480, Some(NV12)), "scene: makes GREY frames, not NV12"),
        ];
        for (source, options, expected) in cases {
            let refused = refusal(&source, options);
            assert!(refused.contains(expected), "{source}: {refused}");
        }
    }
}
