//! Pictures on disk, as luma.
//!
//! ```text
//! JPEG            its Y plane as stored, nothing converted
//! PNG, PNM, BMP   8-bit grey as it is; 16-bit grey: the high byte; colour: BT.601; alpha is ignored
//! ```
//!
//! The format is told by the content, not by the name. An EXIF rotation is ignored: corners are those of the stored picture.

use std::fmt;
use std::fs;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

pub use tagbus_message::frame::MAX_SIDE;

use crate::grey;
use crate::jpeg::{self, LumaDecoder, MarkerWalk, Walk};

/// Bytes of a file that are read before it is known what it is.
const READ_FIRST_BYTES: u64 = 1 << 16;

/// A grey picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width * height` grey values, row after row without gaps.
    pub luma: Vec<u8>,
}

/// Why a picture cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum PictureError {
    /// The file cannot be read.
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// The content is in none of the formats that are read.
    NotAPicture {
        /// The file.
        path: PathBuf,
    },
    /// Width or height is zero or above [`MAX_SIDE`].
    Size {
        /// The file.
        path: PathBuf,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The file ends before the picture does.
    Truncated {
        /// The file.
        path: PathBuf,
    },
    /// The content contradicts its format.
    Damaged {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: cannot be read: {error}", path.display()),
            Self::NotAPicture { path } => {
                write!(f, "{}: not a picture (JPEG, PNG, PNM and BMP are read)", path.display())
            }
            Self::Size { path, width, height } => {
                write!(
                    f,
                    "{}: {width}x{height} pixels, but 1 to {MAX_SIDE} a side are allowed",
                    path.display()
                )
            }
            Self::Truncated { path } => {
                write!(f, "{}: the file ends before the picture does", path.display())
            }
            Self::Damaged { path, reason } => write!(f, "{}: damaged picture: {reason}", path.display()),
        }
    }
}

impl std::error::Error for PictureError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            _ => None,
        }
    }
}

/// Reads a picture as luma.
///
/// # Errors
/// Unreadable, not a picture, zero or more than [`MAX_SIDE`] pixels a side, cut short, damaged.
pub fn load_grey(path: impl AsRef<Path>) -> Result<Picture, PictureError> {
    let mut reader = PictureReader::default();
    let (width, height) = reader.open(path.as_ref())?;
    let (width, height) = (width as usize, height as usize);
    let mut luma = vec![0; width * height];
    reader.decode(&mut luma)?;
    Ok(Picture { width, height, luma })
}

/// Width and height of a picture from its headers alone; only as much of the file is read as they take.
pub(crate) fn peek_size(path: &Path) -> Result<(u32, u32), PictureError> {
    let io_error = |error| PictureError::Io { path: path.into(), error };
    let mut file = io::BufReader::new(fs::File::open(path).map_err(io_error)?);
    let start = file.fill_buf().map_err(io_error)?;
    if start.starts_with(&jpeg::START) {
        return peek_jpeg_size(path, file);
    }
    let Some(format) = readable_format(start) else {
        return Err(PictureError::NotAPicture { path: path.into() });
    };
    ImageReader::with_format(file, format).into_dimensions().map_err(|error| refusal(path, error))
}

fn peek_jpeg_size(path: &Path, mut file: impl Read) -> Result<(u32, u32), PictureError> {
    let (mut bytes, mut walk) = (Vec::new(), MarkerWalk::default());
    loop {
        let read = file.by_ref().take(READ_FIRST_BYTES).read_to_end(&mut bytes);
        let read = read.map_err(|error| PictureError::Io { path: path.into(), error })?;
        let result = walk.advance(&bytes);
        match walk.size {
            Some(size) => return Ok(size),
            None if read == 0 => return Err(PictureError::Truncated { path: path.into() }),
            None if result == Walk::NeedsMore => {}
            None => {
                return Err(PictureError::Damaged {
                    path: path.into(),
                    reason: "no size in its headers".into(),
                });
            }
        }
    }
}

/// The format that the first bytes of a file show, if the image crate reads it for us.
fn readable_format(start: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(start).ok()?;
    [ImageFormat::Png, ImageFormat::Pnm, ImageFormat::Bmp].contains(&format).then_some(format)
}

fn refusal(path: &Path, error: image::ImageError) -> PictureError {
    match error {
        image::ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            PictureError::Truncated { path: path.into() }
        }
        error => PictureError::Damaged { path: path.into(), reason: error.to_string() },
    }
}

/// Reads one picture after the other, each straight into memory of the caller; keeps its file buffer.
#[derive(Debug, Default)]
pub(crate) struct PictureReader {
    path: PathBuf,
    bytes: Vec<u8>,
    jpeg: MarkerWalk,
    decoder: LumaDecoder,
}

impl PictureReader {
    /// Reads the file and its headers; the answer is width and height in pixels, checked.
    pub(crate) fn open(&mut self, path: &Path) -> Result<(u32, u32), PictureError> {
        self.path.clear();
        self.path.push(path);
        self.bytes.clear();
        self.read(path).map_err(|error| PictureError::Io { path: path.into(), error })?;
        let (width, height) = if self.is_jpeg() { self.jpeg_size()? } else { self.other()?.dimensions() };
        match (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) {
            true => Ok((width, height)),
            false => Err(PictureError::Size { path: path.into(), width, height }),
        }
    }

    /// Reads the whole file if it starts like a picture; of any other, which may be huge, only the start.
    fn read(&mut self, path: &Path) -> io::Result<()> {
        let mut file = fs::File::open(path)?;
        file.by_ref().take(READ_FIRST_BYTES).read_to_end(&mut self.bytes)?;
        if self.is_jpeg() || readable_format(&self.bytes).is_some() {
            file.read_to_end(&mut self.bytes)?;
        }
        Ok(())
    }

    /// Decodes the opened picture into `luma` (width x height bytes); the answer is the number of passes over whole pictures that
    /// were made besides the decoding itself: 0 for JPEG, 1 else.
    pub(crate) fn decode(&mut self, luma: &mut [u8]) -> Result<u8, PictureError> {
        if self.is_jpeg() {
            let decoded = self.decoder.decode(&self.bytes, &self.jpeg, luma);
            return decoded.map(|()| 0).map_err(|error| self.damaged(&error));
        }
        let picture =
            DynamicImage::from_decoder(self.other()?).map_err(|error| refusal(&self.path, error))?;
        to_grey(picture, luma).map(|()| 1).ok_or_else(|| self.damaged(&"floating-point pixels are not read"))
    }

    fn is_jpeg(&self) -> bool {
        self.bytes.starts_with(&jpeg::START)
    }

    fn jpeg_size(&mut self) -> Result<(u32, u32), PictureError> {
        self.jpeg = MarkerWalk::default();
        match self.jpeg.advance(&self.bytes) {
            Walk::NeedsMore => Err(PictureError::Truncated { path: self.path.clone() }),
            Walk::Broken(at) => Err(self.damaged(&format!("no marker at byte {at}"))),
            Walk::Complete(length) => {
                self.bytes.truncate(length);
                self.jpeg.size.ok_or_else(|| self.damaged(&"no start-of-frame segment"))
            }
        }
    }

    /// A decoder of the image crate, which has read the headers.
    fn other(&self) -> Result<impl ImageDecoder + '_, PictureError> {
        let Some(format) = readable_format(&self.bytes) else {
            return Err(PictureError::NotAPicture { path: self.path.clone() });
        };
        let mut reader = ImageReader::with_format(io::Cursor::new(&self.bytes[..]), format);
        // The size is checked by `open`, with a message of our own.
        reader.no_limits();
        reader.into_decoder().map_err(|error| refusal(&self.path, error))
    }

    fn damaged(&self, reason: &dyn fmt::Display) -> PictureError {
        PictureError::Damaged { path: self.path.clone(), reason: reason.to_string() }
    }
}

/// Writes a decoded picture's grey values; `None` for pixel types that no format read here has.
fn to_grey(picture: DynamicImage, luma: &mut [u8]) -> Option<()> {
    let high = |value: u16| (value >> 8) as u8;
    let colour = |pixel: &[u8]| grey::bt601(pixel[0], pixel[1], pixel[2]);
    let deep_colour = |pixel: &[u16]| grey::bt601(high(pixel[0]), high(pixel[1]), high(pixel[2]));
    match picture {
        DynamicImage::ImageLuma8(p) => luma.copy_from_slice(&p),
        DynamicImage::ImageLumaA8(p) => map_pixels(&p, 2, luma, |pixel| pixel[0]),
        DynamicImage::ImageRgb8(p) => map_pixels(&p, 3, luma, colour),
        DynamicImage::ImageRgba8(p) => map_pixels(&p, 4, luma, colour),
        DynamicImage::ImageLuma16(p) => map_pixels(&p, 1, luma, |pixel| high(pixel[0])),
        DynamicImage::ImageLumaA16(p) => map_pixels(&p, 2, luma, |pixel| high(pixel[0])),
        DynamicImage::ImageRgb16(p) => map_pixels(&p, 3, luma, deep_colour),
        DynamicImage::ImageRgba16(p) => map_pixels(&p, 4, luma, deep_colour),
        _ => return None,
    }
    Some(())
}

fn map_pixels<T>(pixels: &[T], channels: usize, luma: &mut [u8], grey: impl Fn(&[T]) -> u8) {
    for (out, pixel) in luma.iter_mut().zip(pixels.chunks_exact(channels)) {
        *out = grey(pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::{TestFolder, real_data};
    use image::{ColorType, ExtendedColorType, ImageEncoder};

    const WIDTH: u32 = 21;
    const HEIGHT: u32 = 13;

    /// Bytes that differ from pixel to pixel and from channel to channel.
    fn pattern(bytes: usize) -> Vec<u8> {
        (0..bytes).map(|index| (index * 37 + index / 11) as u8).collect()
    }

    fn png(pixels: &[u8], color: ColorType) -> Vec<u8> {
        let mut file = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut file);
        encoder.write_image(pixels, WIDTH, HEIGHT, color.into()).unwrap();
        file
    }

    fn pgm(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
        [format!("P5\n{width} {height}\n255\n").as_bytes(), pixels].concat()
    }

    fn jpeg(pixels: &[u8], color: ExtendedColorType) -> Vec<u8> {
        let mut file = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, 100);
        encoder.write_image(pixels, WIDTH, HEIGHT, color).unwrap();
        file
    }

    fn load(content: &[u8]) -> Result<Picture, PictureError> {
        let folder = TestFolder::new("picture");
        // The name lies: the content decides.
        let path = folder.file("picture.txt", content);
        let loaded = load_grey(&path);
        if let Ok(picture) = &loaded {
            let size = (picture.width as u32, picture.height as u32);
            assert_eq!(peek_size(&path).unwrap(), size, "headers alone say the same");
        }
        loaded
    }

    fn load_luma(content: &[u8]) -> Vec<u8> {
        let picture = load(content).unwrap();
        assert_eq!((picture.width, picture.height), (WIDTH as usize, HEIGHT as usize));
        picture.luma
    }

    const PIXELS: usize = (WIDTH * HEIGHT) as usize;

    #[test]
    fn grey_png_and_pgm_keep_every_value() {
        let pixels = pattern(PIXELS);
        assert_eq!(load_luma(&png(&pixels, ColorType::L8)), pixels);
        assert_eq!(load_luma(&pgm(WIDTH, HEIGHT, &pixels)), pixels);
    }

    #[test]
    fn alpha_is_ignored() {
        let pixels = pattern(PIXELS * 2);
        let grey: Vec<u8> = pixels.iter().copied().step_by(2).collect();
        assert_eq!(load_luma(&png(&pixels, ColorType::La8)), grey);
        let pixels = pattern(PIXELS * 4);
        let opaque: Vec<u8> =
            pixels.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        assert_eq!(load_luma(&png(&pixels, ColorType::Rgba8)), load_luma(&png(&opaque, ColorType::Rgb8)));
    }

    #[test]
    fn colour_is_weighed_by_bt601_in_every_format() {
        let pixels = pattern(PIXELS * 3);
        let grey: Vec<u8> =
            pixels.chunks_exact(3).map(|pixel| grey::bt601(pixel[0], pixel[1], pixel[2])).collect();
        assert_eq!(load_luma(&png(&pixels, ColorType::Rgb8)), grey);
        let ppm = [format!("P6\n{WIDTH} {HEIGHT}\n255\n").as_bytes(), &pixels].concat();
        assert_eq!(load_luma(&ppm), grey);
        let mut bmp = Vec::new();
        let encoder = image::codecs::bmp::BmpEncoder::new(&mut bmp);
        encoder.write_image(&pixels, WIDTH, HEIGHT, ExtendedColorType::Rgb8).unwrap();
        assert_eq!(load_luma(&bmp), grey);
    }

    #[test]
    fn of_sixteen_bits_the_high_byte_counts() {
        let pixels: Vec<u8> = pattern(PIXELS * 2);
        let high: Vec<u8> = pixels
            .chunks_exact(2)
            .map(|word| u16::from_ne_bytes([word[0], word[1]]).to_be_bytes()[0])
            .collect();
        assert_eq!(load_luma(&png(&pixels, ColorType::L16)), high);
    }

    #[test]
    fn grey_and_colour_jpeg_give_the_y_plane() {
        let smooth: Vec<u8> = (0..PIXELS).map(|index| (index % WIDTH as usize * 9) as u8).collect();
        let colour: Vec<u8> = smooth.iter().flat_map(|&value| [value, 255 - value, value / 2]).collect();
        let expected: Vec<u8> =
            colour.chunks_exact(3).map(|pixel| grey::bt601(pixel[0], pixel[1], pixel[2])).collect();
        let difference = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        // At quality 100 the codec rounds by a few grey levels at most.
        assert!(difference(&load_luma(&jpeg(&smooth, ExtendedColorType::L8)), &smooth) <= 3);
        assert!(difference(&load_luma(&jpeg(&colour, ExtendedColorType::Rgb8)), &expected) <= 3);
    }

    #[test]
    fn jpeg_whose_colour_is_halved_in_height_only_gives_the_y_plane() {
        // Made from red 8x+y, green 4x+3y, blue 200-2x-2y at quality 95, from top to bottom and from coarse to fine.
        let files: [&[u8]; 2] = [
            include_bytes!("../tests/pictures/tall_chroma.jpg"),
            include_bytes!("../tests/pictures/tall_chroma_progressive.jpg"),
        ];
        for file in files {
            let picture = load(file).unwrap();
            assert_eq!((picture.width, picture.height), (24, 40));
            for (index, value) in picture.luma.iter().enumerate() {
                let (x, y) = ((index % 24) as u8, (index / 24) as u8);
                let expected = grey::bt601(8 * x + y, 4 * x + 3 * y, 200 - 2 * x - 2 * y);
                assert!(value.abs_diff(expected) <= 4, "({x},{y}): {value} for {expected}");
            }
        }
    }

    #[test]
    fn one_pixel_is_a_picture() {
        assert_eq!(load(&pgm(1, 1, &[77])).unwrap(), Picture { width: 1, height: 1, luma: vec![77] });
    }

    #[test]
    fn no_pixel_and_more_than_16384_a_side_are_refused_with_the_size() {
        let wide = load(&pgm(16_385, 1, &vec![0; 16_385])).unwrap_err();
        assert!(matches!(wide, PictureError::Size { width: 16_385, height: 1, .. }), "{wide}");
        assert!(wide.to_string().contains("16385x1") && wide.to_string().contains("16384"), "{wide}");
        assert!(load(&pgm(16_384, 1, &vec![0; 16_384])).is_ok());
        let empty = load(&pgm(0, 0, &[])).unwrap_err().to_string();
        assert!(empty.contains("picture.txt"), "{empty}");
        let mut no_rows = jpeg(&pattern(PIXELS), ExtendedColorType::L8);
        let frame = no_rows.windows(2).position(|pair| pair == [0xFF, 0xC0]).unwrap();
        no_rows[frame + 5..frame + 9].fill(0);
        assert!(matches!(load(&no_rows).unwrap_err(), PictureError::Size { width: 0, height: 0, .. }));
        no_rows[frame + 5..frame + 9].copy_from_slice(&[0x40, 0x01, 0x00, 0x10]);
        assert!(matches!(load(&no_rows).unwrap_err(), PictureError::Size { width: 16, height: 16_385, .. }));
    }

    #[test]
    fn every_way_to_cut_a_picture_short_is_an_error() {
        let pixels = pattern(PIXELS);
        for whole in
            [png(&pixels, ColorType::L8), pgm(WIDTH, HEIGHT, &pixels), jpeg(&pixels, ExtendedColorType::L8)]
        {
            // The last 12 bytes of a PNG are its end mark, which holds no pixels.
            for length in 0..whole.len() - 12 {
                assert!(load(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
            }
        }
        let cut = load(&jpeg(&pixels, ExtendedColorType::L8)[..400]).unwrap_err();
        assert!(matches!(cut, PictureError::Truncated { .. }), "{cut}");
    }

    #[test]
    fn other_files_are_told_from_pictures() {
        for content in [b"".as_slice(), b"hello", b"GIF89a", &[0; 100]] {
            assert!(matches!(load(content).unwrap_err(), PictureError::NotAPicture { .. }));
        }
        let missing = load_grey("/no/such/file.png").unwrap_err();
        assert!(
            matches!(missing, PictureError::Io { .. }) && missing.to_string().contains("/no/such/file.png")
        );
    }

    #[test]
    fn a_webcam_frame_without_huffman_tables_is_read() {
        let Some(path) = real_data("raw/mjpeg__mjpeg.jpg") else { return };
        let picture = load_grey(path).unwrap();
        assert_eq!((picture.width, picture.height), (960, 720));
        assert!(looks_like_a_photograph(&picture), "grey or torn");
    }

    #[test]
    fn a_webcam_frame_with_neither_tables_nor_the_avi1_mark_is_read_alike() {
        let Some(path) = real_data("raw/mjpeg__mjpeg.jpg") else { return };
        let content = fs::read(&path).unwrap();
        assert_eq!(content[2..4], [0xFF, 0xE0]);
        let mark = 2 + usize::from(u16::from_be_bytes([content[4], content[5]]));
        let bare = [&content[..2], &content[2 + mark..]].concat();
        assert_eq!(load(&bare).unwrap(), load_grey(&path).unwrap());
    }

    /// Neighbours resemble each other, and yet there are many grey values.
    fn looks_like_a_photograph(picture: &Picture) -> bool {
        let steps: u64 = picture.luma.windows(2).map(|pair| u64::from(pair[0].abs_diff(pair[1]))).sum();
        let values: std::collections::HashSet<u8> = picture.luma.iter().copied().collect();
        values.len() > 100 && (steps as f64 / picture.luma.len() as f64) < 10.0
    }
}
