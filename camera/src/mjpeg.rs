//! Video of JPEG frames: bare (one frame behind the other) or in an AVI file.
//!
//! ```text
//! bytes ──▶ Splitter: finds SOI, walks the markers to EOI ──▶ one frame ──▶ luma, decoded straight into its place
//!                 │ between frames: AVI chunk names, padding, noise are passed over
//!                 └ a frame that breaks off is counted, and the search goes on behind its start
//! ```

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};

use tagbus_message::frame::{Fourcc, MJPG};

use crate::config::Repeat;
use crate::format::FrameShape;
use crate::jpeg::{self, LumaDecoder, MarkerWalk, Walk};
use crate::source::{Damage, Filled, FrameError, FrameSource};

/// Bytes that are asked for at once.
const READ_BYTES: usize = 1 << 18;

/// No JPEG frame is longer: twice the raw bytes of 8 megapixels in full colour. It keeps noise from filling the memory.
const MAX_FRAME_BYTES: usize = 48 << 20;

/// So many pieces of a file are looked at to tell a video from a picture; some may be damaged.
const PIECES_TO_LOOK_AT: usize = 16;

/// What the next stretch of the stream is.
#[derive(Debug)]
enum Piece<'a> {
    /// A whole frame, and what the walk over it found.
    Frame(&'a [u8], &'a MarkerWalk),
    /// A frame that breaks off, or is none.
    Damaged,
}

/// Cuts a stream of bytes into JPEG frames. The buffer grows to the longest frame and is kept.
struct Splitter<R> {
    input: R,
    buffer: Vec<u8>,
    /// Bytes at the start of the buffer that are done with.
    done: usize,
    walk: MarkerWalk,
}

impl<R: Read> Splitter<R> {
    fn new(input: R) -> Splitter<R> {
        Splitter { input, buffer: Vec::new(), done: 0, walk: MarkerWalk::default() }
    }

    /// The next frame; `None` at the end of the stream.
    fn next(&mut self) -> io::Result<Option<Piece<'_>>> {
        self.buffer.drain(..self.done);
        self.done = 0;
        if !self.find_start()? {
            return Ok(None);
        }
        self.walk = MarkerWalk::default();
        loop {
            match self.walk.advance(&self.buffer) {
                Walk::Complete(length) => {
                    self.done = length;
                    return Ok(Some(Piece::Frame(&self.buffer[..length], &self.walk)));
                }
                Walk::NeedsMore if self.buffer.len() < MAX_FRAME_BYTES && self.read_more()? => {}
                _ => break,
            }
        }
        self.look_again();
        Ok(Some(Piece::Damaged))
    }

    /// Goes back to just behind the start of the last piece. To be called when it is damaged: where a segment was cut, its
    /// length leads the walk into the next frame, which then lies within this piece.
    fn look_again(&mut self) {
        self.done = 2;
    }

    /// Drops everything before the next start of a frame; `false` when none comes any more.
    fn find_start(&mut self) -> io::Result<bool> {
        loop {
            if let Some(start) = self.buffer.windows(jpeg::START.len()).position(|bytes| bytes == jpeg::START)
            {
                self.buffer.drain(..start);
                return Ok(true);
            }
            // The last two bytes may be the beginning of a start.
            let keep = self.buffer.len().min(jpeg::START.len() - 1);
            self.buffer.drain(..self.buffer.len() - keep);
            if !self.read_more()? {
                return Ok(false);
            }
        }
    }

    /// Appends bytes of the input; `false` at its end.
    fn read_more(&mut self) -> io::Result<bool> {
        let read = self.input.by_ref().take(READ_BYTES as u64).read_to_end(&mut self.buffer)?;
        Ok(read > 0)
    }
}

impl<R: Read + Seek> Splitter<R> {
    fn rewind(&mut self) -> io::Result<()> {
        self.buffer.clear();
        self.done = 0;
        self.input.rewind()
    }
}

/// Whether a file starts like an AVI file, or holds more than one JPEG picture.
pub(crate) fn holds_video(path: &Path) -> io::Result<bool> {
    let mut splitter = Splitter::new(File::open(path)?);
    splitter.read_more()?;
    if splitter.buffer.starts_with(b"RIFF") {
        return Ok(splitter.buffer.get(8..12) == Some(b"AVI ".as_slice()));
    }
    if !splitter.buffer.starts_with(&jpeg::START) {
        return Ok(false);
    }
    let mut first_size = None;
    for _ in 0..PIECES_TO_LOOK_AT {
        match splitter.next()? {
            None => return Ok(false),
            // Another size is a preview or a gain map that a telephone appended, not the next frame.
            Some(Piece::Frame(_, walk)) if first_size.is_some() && first_size == walk.size => {
                return Ok(true);
            }
            Some(Piece::Frame(_, walk)) => first_size = first_size.or(walk.size),
            Some(Piece::Damaged) => {}
        }
    }
    Ok(false)
}

/// A file of JPEG frames of one size. Decoding is the one pass over a frame and goes straight into its place: 0 copies.
///
/// The decoder crate allocates its working rows anew for each frame; nothing else is allocated once buffers have grown.
pub(crate) struct MjpegSource<R = File> {
    path: PathBuf,
    frames: Splitter<R>,
    decoder: LumaDecoder,
    shape: FrameShape,
    repeat: Repeat,
    /// Frames that the present pass has brought.
    used: u64,
}

impl MjpegSource<File> {
    /// Opens a file; the first whole frame decides about the size.
    pub(crate) fn open(path: &Path, repeat: Repeat) -> Result<MjpegSource, FrameError> {
        let file = File::open(path).map_err(|error| FrameError::Io { path: path.into(), error })?;
        MjpegSource::new(path, file, repeat)
    }
}

impl<R: Read + Seek> MjpegSource<R> {
    fn new(path: &Path, input: R, repeat: Repeat) -> Result<MjpegSource<R>, FrameError> {
        let mut frames = Splitter::new(input);
        let shape = first_shape(&mut frames).and_then(|shape| frames.rewind().map(|()| shape));
        let shape = shape.map_err(|error| FrameError::Io { path: path.into(), error })?;
        let shape = shape.ok_or_else(|| FrameError::NothingUsable {
            path: path.into(),
            reason: "no whole JPEG frame of an allowed size was found".into(),
        })?;
        Ok(MjpegSource { path: path.into(), frames, decoder: LumaDecoder::default(), shape, repeat, used: 0 })
    }

    /// The next frame that can be used in this pass.
    fn next_in_pass(&mut self, into: &mut [u8], damage: &mut Damage) -> io::Result<Option<Filled>> {
        while let Some(piece) = self.frames.next()? {
            let Piece::Frame(bytes, walk) = piece else {
                damage.note("a JPEG frame breaks off");
                continue;
            };
            if walk.size != Some((self.shape.width(), self.shape.height())) {
                damage.note(format_args!("a JPEG frame is not {} like the first", self.shape));
                continue;
            }
            match self.decoder.decode(bytes, walk, &mut into[..self.shape.bytes()]) {
                Ok(()) => return Ok(Some(Filled { shape: self.shape, copies: 0 })),
                Err(error) => {
                    damage.note(format_args!("damaged JPEG frame: {error}"));
                    self.frames.look_again();
                }
            }
        }
        Ok(None)
    }
}

impl<R: Read + Seek> FrameSource for MjpegSource<R> {
    fn largest(&self) -> FrameShape {
        self.shape
    }

    fn description(&self) -> &'static str {
        "video of JPEG frames"
    }

    fn stored_format(&self) -> Fourcc {
        MJPG
    }

    fn next(&mut self, into: &mut [u8], damage: &mut Damage) -> Result<Option<Filled>, FrameError> {
        loop {
            let filled = self.next_in_pass(into, damage);
            if let Some(filled) = filled.map_err(|error| FrameError::Io { path: self.path.clone(), error })? {
                self.used += 1;
                return Ok(Some(filled));
            }
            if self.used == 0 {
                let reason = damage.last_reason.clone();
                return Err(FrameError::NothingUsable { path: self.path.clone(), reason });
            }
            if self.repeat == Repeat::Once {
                return Ok(None);
            }
            self.used = 0;
            self.frames.rewind().map_err(|error| FrameError::Io { path: self.path.clone(), error })?;
        }
    }
}

/// Size of the first whole frame.
fn first_shape<R: Read>(frames: &mut Splitter<R>) -> io::Result<Option<FrameShape>> {
    while let Some(piece) = frames.next()? {
        if let Piece::Frame(_, MarkerWalk { size: Some((width, height)), .. }) = piece
            && let Ok(shape) = FrameShape::grey(*width, *height)
        {
            return Ok(Some(shape));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::{TestFolder, real_data};
    use image::{ExtendedColorType, ImageEncoder};
    use std::fs;
    use std::io::Cursor;

    /// A frame of 32x16 pixels of one grey value.
    fn frame(value: u8) -> Vec<u8> {
        sized_frame(value, 32, 16)
    }

    fn sized_frame(value: u8, width: u32, height: u32) -> Vec<u8> {
        let mut file = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, 90);
        let pixels = vec![value; (width * height) as usize];
        encoder.write_image(&pixels, width, height, ExtendedColorType::L8).unwrap();
        file
    }

    /// Grey value of each frame of a stream that is played once, and the count of damaged ones.
    fn play(stream: Vec<u8>) -> (Vec<u8>, u64) {
        let mut source = MjpegSource::new(Path::new("stream"), Cursor::new(stream), Repeat::Once).unwrap();
        let (mut values, mut damage) = (Vec::new(), Damage::default());
        let mut luma = vec![0; source.largest().bytes()];
        while let Some(filled) = source.next(&mut luma, &mut damage).unwrap() {
            assert_eq!((filled.shape, filled.copies), (source.largest(), 0));
            assert!(luma.iter().all(|value| value.abs_diff(luma[0]) <= 1), "torn");
            values.push(luma[0]);
        }
        (values, damage.count)
    }

    #[test]
    fn frames_come_in_order_with_noise_between_them_passed_over() {
        let stream =
            [b"00dc\x12\x34".as_slice(), &frame(50), b"\0\0", &frame(100), &frame(200), b"idx1\xff\xd8"]
                .concat();
        assert_eq!(play(stream), (vec![50, 100, 200], 0));
    }

    #[test]
    fn a_frame_cut_at_any_byte_is_counted_and_its_neighbours_arrive() {
        let (before, cut, after) = (frame(50), frame(100), frame(200));
        // From 3 bytes on there is a frame to be damaged; without its last byte it has no end mark.
        let mut unnoticed = 0;
        for length in 3..cut.len() {
            let (values, damaged) = play([&before, &cut[..length], &after[..]].concat());
            assert_eq!(values, [50, 200], "cut after {length} bytes");
            unnoticed += u64::from(damaged == 0);
        }
        // A cut two bytes before the end of a segment lets it swallow the next frame's start mark, and that frame go on in this one.
        assert!(unnoticed <= 8, "{unnoticed}");
    }

    #[test]
    fn a_stream_that_ends_within_a_frame_counts_it() {
        let cut = frame(100);
        for length in 3..cut.len() {
            let (values, damaged) = play([&frame(50), &cut[..length]].concat());
            assert_eq!(values, [50]);
            assert!(damaged >= 1, "cut after {length} bytes");
        }
    }

    #[test]
    fn a_frame_of_another_size_is_counted_as_damaged() {
        let stream = [frame(50), sized_frame(100, 32, 24), frame(200)].concat();
        assert_eq!(play(stream), (vec![50, 200], 1));
    }

    #[test]
    fn entropy_data_that_ends_early_in_a_whole_frame_is_damage_too() {
        let mut short = sized_frame(100, 640, 480);
        let end = short.len() - 2;
        short.drain(end - 60..end);
        let stream = [sized_frame(50, 640, 480), short, sized_frame(200, 640, 480)].concat();
        assert_eq!(play(stream), (vec![50, 200], 1));
    }

    #[test]
    fn a_loop_starts_again_and_ends_when_nothing_can_be_used_any_more() {
        let stream = [frame(50), frame(100)].concat();
        let mut source = MjpegSource::new(Path::new("stream"), Cursor::new(stream), Repeat::Loop).unwrap();
        let mut luma = vec![0; source.largest().bytes()];
        let mut damage = Damage::default();
        let mut next = || {
            source.next(&mut luma, &mut damage).unwrap().unwrap();
            luma[0]
        };
        assert_eq!([next(), next(), next(), next(), next()], [50, 100, 50, 100, 50]);
    }

    #[test]
    fn a_stream_without_a_whole_frame_is_refused() {
        for stream in
            [Vec::new(), b"no frame at all".to_vec(), frame(9)[..100].to_vec(), sized_frame(9, 1, 1)]
        {
            let refused = MjpegSource::new(Path::new("stream"), Cursor::new(stream), Repeat::Loop);
            assert!(matches!(refused, Err(FrameError::NothingUsable { .. })));
        }
    }

    #[test]
    fn a_video_is_told_from_one_picture_and_from_a_picture_with_a_preview() {
        let folder = TestFolder::new("video");
        let holds = |content: Vec<u8>| holds_video(&folder.file("file", content)).unwrap();
        assert!(holds([frame(1), frame(2)].concat()));
        assert!(holds([&frame(1)[..200], &frame(2)[..], &frame(3)[..]].concat()));
        assert!(!holds(frame(1)));
        assert!(!holds(frame(1)[..200].to_vec()));
        assert!(!holds([frame(1), sized_frame(2, 16, 8)].concat()));
        assert!(!holds(b"P5 1 1 255\n0".to_vec()) && !holds(Vec::new()));
        assert!(holds(b"RIFF\0\0\0\0AVI LIST".to_vec()) && !holds(b"RIFF\0\0\0\0WEBPVP8 ".to_vec()));
    }

    /// Peak signal-to-noise ratio of `b` against `a`, in decibels.
    fn psnr(a: &[u8], b: &[u8]) -> f64 {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
        10.0 * (255.0 * 255.0 * a.len() as f64 / squares.max(1e-9)).log10()
    }

    #[test]
    fn luma_of_a_video_resembles_the_luma_of_the_same_clip_in_raw_form() {
        let (Some(video), Some(raw)) =
            (real_data("raw/libvpl__cars_320x240.mjpeg"), real_data("raw/libvpl__cars_320x240.nv12"))
        else {
            return;
        };
        assert!(holds_video(&video).unwrap());
        let mut source = MjpegSource::open(&video, Repeat::Once).unwrap();
        let raw = fs::read(raw).unwrap();
        let mut luma = vec![0; 320 * 240];
        let (mut frames, mut damage) = (0, Damage::default());
        let raw_frames: Vec<Vec<u8>> = raw
            .chunks_exact(320 * 360)
            .map(|frame| frame[..320 * 240].iter().copied().map(full_range).collect())
            .collect();
        while source.next(&mut luma, &mut damage).unwrap().is_some() {
            let likeness: Vec<f64> = raw_frames.iter().map(|raw| psnr(raw, &luma)).collect();
            let best = (0..likeness.len()).max_by(|&a, &b| likeness[a].total_cmp(&likeness[b])).unwrap();
            assert!(best == frames, "frame {frames} resembles raw frame {best} more");
            assert!(likeness[frames] > MIN_PSNR_DB, "frame {frames}: {:.1} dB", likeness[frames]);
            frames += 1;
        }
        assert_eq!((frames, damage.count), (30, 0));
    }

    /// The raw clip has black at 16 and white at 235, as television does; JPEG uses all values.
    fn full_range(value: u8) -> u8 {
        ((f64::from(value) - 16.0) * 255.0 / 219.0).round().clamp(0.0, 255.0) as u8
    }

    /// The two codings of the clip are 29.9 to 44.9 dB apart, a frame and its neighbours 18 to 21.
    const MIN_PSNR_DB: f64 = 28.0;

    #[test]
    fn an_avi_file_gives_its_frames() {
        let Some(path) = real_data("raw/wpical__short.avi") else { return };
        assert!(holds_video(&path).unwrap());
        let mut source = MjpegSource::open(&path, Repeat::Once).unwrap();
        let mut luma = vec![0; source.largest().bytes()];
        let (mut frames, mut damage) = (0, Damage::default());
        while let Some(filled) = source.next(&mut luma, &mut damage).unwrap() {
            assert_eq!((filled.shape.width(), filled.shape.height()), (1920, 1080));
            frames += 1;
        }
        assert_eq!((frames, damage.count), (3, 0));
    }
}
