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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;
    use tagbus_message::frame::{GREY, NV12};

    fn play(source: &mut RawSource, damage: &mut Damage, limit: usize) -> Vec<u8> {
        let mut frame = vec![0; source.largest().bytes()];
        let mut first_bytes = Vec::new();
        while first_bytes.len() < limit && source.next(&mut frame, damage).unwrap().is_some() {
            first_bytes.push(frame[0]);
        }
        first_bytes
    }

    #[test]
    fn frames_are_read_as_they_lie_and_a_cut_last_one_is_counted_in_each_pass() {
        let folder = TestFolder::new("raw");
        let content: Vec<u8> = (0..3 * 96 + 5).map(|index| (index / 96) as u8).collect();
        let path = folder.file("frames", content);
        let shape = FrameShape::new(NV12, 8, 8).unwrap();
        let mut damage = Damage::default();
        let mut once = RawSource::open(&path, shape, Repeat::Once).unwrap();
        assert_eq!((play(&mut once, &mut damage, 9), damage.count), (vec![0, 1, 2], 1));
        assert!(damage.last_reason.contains("5 of 96 bytes"), "{}", damage.last_reason);
        let mut looped = RawSource::open(&path, shape, Repeat::Loop).unwrap();
        assert_eq!((play(&mut looped, &mut damage, 7), damage.count), (vec![0, 1, 2, 0, 1, 2, 0], 3));
    }

    #[test]
    fn a_file_shorter_than_a_frame_is_refused_with_both_numbers() {
        let folder = TestFolder::new("raw");
        let path = folder.file("frames", [0; 63]);
        let refused =
            RawSource::open(&path, FrameShape::new(GREY, 8, 8).unwrap(), Repeat::Once).err().unwrap();
        assert!(
            refused.to_string().contains("63 bytes") && refused.to_string().contains("has 64"),
            "{refused}"
        );
    }

    #[test]
    fn a_file_that_shrinks_while_it_is_read_is_an_error() {
        let folder = TestFolder::new("raw");
        let path = folder.file("frames", [0; 128]);
        let mut source = RawSource::open(&path, FrameShape::new(GREY, 8, 8).unwrap(), Repeat::Loop).unwrap();
        folder.file("frames", [0; 10]);
        let error = source.next(&mut [0; 64], &mut Damage::default()).unwrap_err();
        assert!(matches!(error, FrameError::Io { .. }), "{error}");
    }
}
