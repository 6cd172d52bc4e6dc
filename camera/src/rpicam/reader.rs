//! Frames out of a stream of bytes, their luma read straight into its place.

use std::io::{self, Read};

use crate::format::FrameShape;

/// Chroma is read in pieces of this size and dropped.
const DROPPED_BYTES: usize = 1 << 16;

/// What reading came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// A whole frame has been read.
    Frame,
    /// The stream has no more bytes at the moment.
    NeedsMore,
    /// The stream has ended; so many bytes of an unfinished frame were read.
    Ended(usize),
}

/// Cuts a stream into frames of a luma plane and two chroma planes of half its width and height.
#[derive(Debug)]
pub(super) struct FrameReader {
    luma_bytes: usize,
    frame_bytes: usize,
    /// Bytes of the present frame that have been read.
    at: usize,
    dropped: Vec<u8>,
}

impl FrameReader {
    pub(super) fn new(shape: FrameShape) -> FrameReader {
        let (width, height) = (shape.width() as usize, shape.height() as usize);
        let frame_bytes = width * height + 2 * width.div_ceil(2) * height.div_ceil(2);
        FrameReader { luma_bytes: width * height, frame_bytes, at: 0, dropped: vec![0; DROPPED_BYTES] }
    }

    /// Reads on; `luma` has to be the same memory until the frame is whole.
    pub(super) fn read(&mut self, stream: &mut impl Read, luma: &mut [u8]) -> io::Result<Progress> {
        while self.at < self.frame_bytes {
            let into = match luma[..self.luma_bytes].get_mut(self.at..) {
                Some(rest) if !rest.is_empty() => rest,
                _ => {
                    let rest = (self.frame_bytes - self.at).min(DROPPED_BYTES);
                    &mut self.dropped[..rest]
                }
            };
            match stream.read(into) {
                Ok(0) => return Ok(Progress::Ended(std::mem::take(&mut self.at))),
                Ok(read) => self.at += read,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(Progress::NeedsMore),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.at = 0;
        Ok(Progress::Frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out at most so many bytes at once, and has none every second time.
    struct Dribble<'a>(&'a [u8], usize, bool);

    impl Read for Dribble<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            self.2 = !self.2;
            if self.2 {
                return Err(io::ErrorKind::WouldBlock.into());
            }
            let count = into.len().min(self.1);
            self.0.read(&mut into[..count])
        }
    }

    #[test]
    fn frames_are_whole_and_chroma_is_dropped_however_the_bytes_arrive() {
        let shape = FrameShape::grey(7, 5).unwrap();
        let frame = |value: u8| [vec![value; 35], vec![200 + value; 24]].concat();
        let stream = [frame(1), frame(2), vec![3; 40]].concat();
        for piece in [1, 2, 7, 34, 35, 36, 59, 1000] {
            let (mut reader, mut luma) = (FrameReader::new(shape), vec![0; 35]);
            let mut dribble = Dribble(&stream, piece, false);
            let mut seen = Vec::new();
            let ended = loop {
                match reader.read(&mut dribble, &mut luma).unwrap() {
                    Progress::Frame => seen.push(luma.clone()),
                    Progress::NeedsMore => {}
                    Progress::Ended(bytes) => break bytes,
                }
            };
            assert_eq!((seen, ended), (vec![vec![1; 35], vec![2; 35]], 40), "{piece}");
        }
    }
}
