//! A file of frames as a camera writes them: no header, one frame behind the other.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};

use tagbus_message::frame::{Fourcc, GREY};

use crate::config::Repeat;
use crate::format::FrameShape;
use crate::source::{Damage, Filled, FrameError, FrameSource, OpenError};
use crate::unpack::Unpack;

/// A raw file. The kernel writes each frame straight into its place: 0 copies. Frames that are deeper, packed or a mosaic come
/// through a buffer, from which their luma is unpacked: 1 copy.
pub(crate) struct RawSource {
    path: PathBuf,
    file: File,
    stored_format: Fourcc,
    /// What is published.
    shape: FrameShape,
    packed: Option<Packed>,
    repeat: Repeat,
    /// Whole frames in the file, and how many of them have been read in this pass.
    frames: u64,
    read: u64,
    /// Bytes behind the last whole frame.
    remainder: u64,
}

/// One frame as it lies in the file, and how its luma is got.
struct Packed {
    unpack: Unpack,
    bytes: Vec<u8>,
}

impl RawSource {
    /// Opens a file of frames of this format and size, rows without gaps.
    pub(crate) fn open(
        path: &Path,
        stored_format: Fourcc,
        [width, height]: [u32; 2],
        repeat: Repeat,
    ) -> Result<RawSource, OpenError> {
        let unpack = Unpack::of(stored_format);
        let shape = FrameShape::new(if unpack.is_some() { GREY } else { stored_format }, width, height)
            .map_err(|error| OpenError::Shape { path: path.into(), error })?;
        let frame_bytes = match unpack {
            Some(unpack) => unpack.row_bytes(width as usize) * height as usize,
            None => shape.bytes(),
        };
        let opened = File::open(path).and_then(|file| file.metadata().map(|about| (file, about.len())));
        let (file, length) = opened.map_err(|error| OpenError::Io { path: path.into(), error })?;
        let (frames, remainder) = (length / frame_bytes as u64, length % frame_bytes as u64);
        if frames == 0 {
            let frame = format!("{width}x{height} {stored_format}");
            return Err(OpenError::TooShort { path: path.into(), length, frame, needed: frame_bytes });
        }
        let packed = unpack.map(|unpack| Packed { unpack, bytes: vec![0; frame_bytes] });
        let path = path.into();
        Ok(RawSource { path, file, stored_format, shape, packed, repeat, frames, read: 0, remainder })
    }

    fn frame_bytes(&self) -> usize {
        self.packed.as_ref().map_or(self.shape.bytes(), |packed| packed.bytes.len())
    }

    /// After the last frame: to the start again, or `false`. What is left of a cut frame is noted.
    fn turn_back(&mut self, damage: &mut Damage) -> io::Result<bool> {
        if self.remainder > 0 {
            let wanted = self.frame_bytes();
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
        let into = &mut into[..self.shape.bytes()];
        let copies = match &mut self.packed {
            None => {
                self.file.read_exact(into)?;
                0
            }
            Some(Packed { unpack, bytes }) => {
                self.file.read_exact(bytes)?;
                let width = self.shape.width() as usize;
                unpack.unpack(bytes, unpack.row_bytes(width), width, into);
                1
            }
        };
        self.read += 1;
        Ok(Some(Filled { shape: self.shape, copies }))
    }
}

impl FrameSource for RawSource {
    fn largest(&self) -> FrameShape {
        self.shape
    }

    fn description(&self) -> &'static str {
        "raw file"
    }

    fn stored_format(&self) -> Fourcc {
        self.stored_format
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
    use tagbus_message::frame::NV12;

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
        let mut damage = Damage::default();
        let mut once = RawSource::open(&path, NV12, [8, 8], Repeat::Once).unwrap();
        assert_eq!((play(&mut once, &mut damage, 9), damage.count), (vec![0, 1, 2], 1));
        assert!(damage.last_reason.contains("5 of 96 bytes"), "{}", damage.last_reason);
        let mut looped = RawSource::open(&path, NV12, [8, 8], Repeat::Loop).unwrap();
        assert_eq!((play(&mut looped, &mut damage, 7), damage.count), (vec![0, 1, 2, 0, 1, 2, 0], 3));
    }

    #[test]
    fn a_file_shorter_than_a_frame_is_refused_with_both_numbers() {
        let folder = TestFolder::new("raw");
        let path = folder.file("frames", [0; 63]);
        let refused = RawSource::open(&path, GREY, [8, 8], Repeat::Once).err().unwrap();
        assert!(
            refused.to_string().contains("63 bytes") && refused.to_string().contains("has 64"),
            "{refused}"
        );
    }

    #[test]
    fn packed_frames_are_unpacked_one_after_the_other_and_a_cut_one_is_counted_by_its_own_size() {
        let folder = TestFolder::new("raw");
        // Four values of ten bits in five bytes, the fifth of which holds the low bits.
        let frame = |value: u8| [value, value, value, value, 0b11_01_00_10].repeat(2 * 8);
        let path = folder.file("frames", [frame(7), frame(9), vec![1; 79]].concat());
        let y10p = Fourcc::new(*b"Y10P");
        let (mut damage, mut into) = (Damage::default(), [0; 64]);
        let mut source = RawSource::open(&path, y10p, [8, 8], Repeat::Once).unwrap();
        assert_eq!((source.largest().to_string(), source.stored_format()), ("8x8 GREY".to_string(), y10p));
        for value in [7, 9] {
            let filled = source.next(&mut into, &mut damage).unwrap().unwrap();
            assert_eq!((filled.copies, into), (1, [value; 64]));
        }
        assert!(source.next(&mut into, &mut damage).unwrap().is_none());
        assert!(damage.last_reason.contains("79 of 80 bytes"), "{}", damage.last_reason);
        let short = RawSource::open(&path, y10p, [800, 8], Repeat::Once).err().unwrap().to_string();
        assert!(short.contains("239 bytes, but one frame of 800x8 Y10P has 8000"), "{short}");
    }

    #[test]
    fn a_file_that_shrinks_while_it_is_read_is_an_error() {
        let folder = TestFolder::new("raw");
        let path = folder.file("frames", [0; 128]);
        let mut source = RawSource::open(&path, GREY, [8, 8], Repeat::Loop).unwrap();
        folder.file("frames", [0; 10]);
        let error = source.next(&mut [0; 64], &mut Damage::default()).unwrap_err();
        assert!(matches!(error, FrameError::Io { .. }), "{error}");
    }
}
