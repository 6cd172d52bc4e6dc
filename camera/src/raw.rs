//! A file of frames as a camera writes them: no header, one frame behind the other.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};

use crate::config::Repeat;
use crate::format::FrameShape;
use crate::source::{Damage, Filled, FrameError, FrameSource, OpenError};

/// A raw file. The kernel writes each frame straight into its place: 0 copies.
pub(crate) struct RawSource {
    path: PathBuf,
    file: File,
    shape: FrameShape,
    repeat: Repeat,
    /// Whole frames in the file, and how many of them have been read in this pass.
    frames: u64,
    read: u64,
    /// Bytes behind the last whole frame.
    remainder: u64,
}

impl RawSource {
    /// Opens a file of frames of a checked shape.
    pub(crate) fn open(path: &Path, shape: FrameShape, repeat: Repeat) -> Result<RawSource, OpenError> {
        let opened = File::open(path).and_then(|file| file.metadata().map(|about| (file, about.len())));
        let (file, length) = opened.map_err(|error| OpenError::Io { path: path.into(), error })?;
        let frame_bytes = shape.bytes() as u64;
        let (frames, remainder) = (length / frame_bytes, length % frame_bytes);
        if frames == 0 {
            return Err(OpenError::TooShort { path: path.into(), length, shape });
        }
        Ok(RawSource { path: path.into(), file, shape, repeat, frames, read: 0, remainder })
    }

    /// After the last frame: to the start again, or `false`. What is left of a cut frame is noted.
    fn turn_back(&mut self, damage: &mut Damage) -> io::Result<bool> {
        if self.remainder > 0 {
            let wanted = self.shape.bytes();
            damage.note(format_args!(
                "{}: last frame has {} of {wanted} bytes",
                self.path.display(),
                self.remainder
            ));
        }
        self.read = 0;
        self.file.rewind()?;
        Ok(self.repeat == Repeat::Loop)
    }

    fn read_frame(&mut self, into: &mut [u8], damage: &mut Damage) -> io::Result<Option<Filled>> {
        if self.read == self.frames && !self.turn_back(damage)? {
            return Ok(None);
        }
        self.file.read_exact(&mut into[..self.shape.bytes()])?;
        self.read += 1;
        Ok(Some(Filled { shape: self.shape, copies: 0 }))
    }
}

impl FrameSource for RawSource {
    fn largest(&self) -> FrameShape {
        self.shape
    }

    fn description(&self) -> &'static str {
        "raw file"
    }

    fn next(&mut self, into: &mut [u8], damage: &mut Damage) -> Result<Option<Filled>, FrameError> {
        let filled = self.read_frame(into, damage);
        filled.map_err(|error| FrameError::Io { path: self.path.clone(), error })
    }
}
