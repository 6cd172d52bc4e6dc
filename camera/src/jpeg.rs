//! One JPEG picture in memory: where it ends, how large it is, and its luma.
//!
//! ```text
//! FFD8 | FFE1 len ... | FFDB len ... | FFC0 len .. h w .. | FFC4 len ... | FFDA len ... entropy data ... | FFD9
//! SOI    APPn (may      DQT            SOFn: the size       DHT            SOS  FF00 = data, FFD0-7 =      EOI
//!        hold a whole                                       (MJPEG may          restart marks
//!        thumbnail)                                         leave it out)
//! ```
//!
//! The end is found by walking from marker to marker. A search for `FFD9` would stop inside the thumbnail of an APP segment.

use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;
use zune_jpeg::{JpegDecoder, SampleRatios};

use crate::grey;

/// The first bytes of every JPEG picture: start of image, then the next marker's first byte.
pub(crate) const START: [u8; 3] = [0xFF, 0xD8, 0xFF];

/// An APP0 segment with the name `AVI1`: it tells the decoder to use the standard Huffman tables (ITU T.81, tables K.3
/// to K.6) for those that the picture does not bring. Webcams leave both the tables and this segment out.
const STANDARD_TABLES: [u8; 9] = [0xFF, 0xE0, 0x00, 0x07, b'A', b'V', b'I', b'1', 0x00];

/// Length of the marker that ends a picture.
const END_MARK_BYTES: usize = 2;

/// Bytes that the decoder may read ahead of the last block: up to 8 in its bit buffer and 4 in one step.
const READ_AHEAD: [u8; 16] = [0; 16];

/// How far a walk over the markers came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Walk {
    /// The bytes so far are in order, but the picture goes on.
    NeedsMore,
    /// The picture is complete and has this many bytes.
    Complete(usize),
    /// No valid picture can go on at this byte; a new picture may start there.
    Broken(usize),
}

/// A walk over the markers of one picture, which can be continued when more bytes have arrived.
#[derive(Debug, Default, Clone)]
pub(crate) struct MarkerWalk {
    at: usize,
    in_entropy_data: bool,
    /// Width and height in pixels, once the start-of-frame segment has been passed.
    pub(crate) size: Option<(u32, u32)>,
    /// Whether the picture brings Huffman tables of its own.
    pub(crate) has_huffman_tables: bool,
    /// Scans that have begun; more than one where the picture is stored from coarse to fine or plane by plane.
    scans: u32,
}

impl MarkerWalk {
    /// Goes on over `bytes`, which start with the picture's first byte at every call and may only grow between calls.
    pub(crate) fn advance(&mut self, bytes: &[u8]) -> Walk {
        loop {
            let step =
                if self.in_entropy_data { self.skip_entropy_data(bytes) } else { self.pass_marker(bytes) };
            if let Some(result) = step {
                return result;
            }
        }
    }

    /// Moves to the next marker that is neither a stuffed data byte nor a restart mark.
    fn skip_entropy_data(&mut self, bytes: &[u8]) -> Option<Walk> {
        loop {
            let rest = bytes.get(self.at..).unwrap_or_default();
            let Some(distance) = rest.iter().position(|&byte| byte == 0xFF) else {
                self.at = self.at.max(bytes.len());
                return Some(Walk::NeedsMore);
            };
            self.at += distance;
            match bytes.get(self.at + 1) {
                None => return Some(Walk::NeedsMore),
                Some(0x00 | 0xD0..=0xD7) => self.at += 2,
                Some(0xFF) => self.at += 1,
                Some(_) => break,
            }
        }
        self.in_entropy_data = false;
        None
    }

    fn pass_marker(&mut self, bytes: &[u8]) -> Option<Walk> {
        let (Some(&mark), Some(&marker)) = (bytes.get(self.at), bytes.get(self.at + 1)) else {
            return Some(Walk::NeedsMore);
        };
        if mark != 0xFF {
            return Some(Walk::Broken(self.at));
        }
        match marker {
            0xD8 if self.at == 0 => self.at = 2,
            0xD9 if self.at != 0 => return Some(Walk::Complete(self.at + 2)),
            _ if self.at == 0 => return Some(Walk::Broken(0)),
            0xD8 | 0x00 => return Some(Walk::Broken(self.at)),
            0xFF => self.at += 1,
            0x01 | 0xD0..=0xD7 => self.at += 2,
            _ => return self.pass_segment(marker, bytes),
        }
        None
    }

    /// Passes a marker that is followed by a two-byte length and that many bytes (the length counts itself).
    fn pass_segment(&mut self, marker: u8, bytes: &[u8]) -> Option<Walk> {
        let segment = &bytes[self.at..];
        let &[_, _, high, low, ..] = segment else { return Some(Walk::NeedsMore) };
        let length = usize::from(u16::from_be_bytes([high, low]));
        match marker {
            _ if length < 2 => return Some(Walk::Broken(self.at)),
            0xC4 => self.has_huffman_tables = true,
            0xC0..=0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF => {
                // length (2), bits per sample (1), height (2), width (2)
                let &[_, _, _, _, _, h1, h0, w1, w0, ..] = segment else { return Some(Walk::NeedsMore) };
                self.size = Some((u16::from_be_bytes([w1, w0]).into(), u16::from_be_bytes([h1, h0]).into()));
            }
            0xDA => {
                self.scans += 1;
                self.in_entropy_data = true;
            }
            _ => {}
        }
        self.at += 2 + length;
        None
    }
}

/// Decodes luma only, into memory of the caller; keeps the buffer in which pictures are made ready.
#[derive(Debug, Default)]
pub(crate) struct LumaDecoder {
    ready: Vec<u8>,
}

impl LumaDecoder {
    /// Writes the Y plane of `jpeg` (exactly one picture, walked by `walk` to its end) into the first width x height
    /// bytes of `luma`.
    ///
    /// A picture that is not YCbCr or grey (RGB or CMYK in a JPEG) is converted by BT.601 through a buffer of its own.
    ///
    /// # Errors
    /// What the decoder says about a damaged picture; `luma` then holds a part of it and must not be published.
    pub(crate) fn decode(
        &mut self,
        jpeg: &[u8],
        walk: &MarkerWalk,
        luma: &mut [u8],
    ) -> Result<(), DecodeErrors> {
        self.make_ready(jpeg, walk);
        // Strict: a picture that ends early is an error, instead of being filled up with grey.
        let options =
            DecoderOptions::default().set_strict_mode(true).jpeg_set_out_colorspace(ColorSpace::Luma);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&self.ready), options);
        decoder.decode_headers()?;
        let tall_chroma = decoder.info().is_some_and(|info| info.sample_ratio == SampleRatios::V);
        match decoder.input_colorspace() {
            // Where chroma is halved in height only, zune-jpeg 0.5 counts rows wrongly when it leaves the chroma out.
            Some(ColorSpace::YCbCr) if tall_chroma => {
                decode_colour(&self.ready, ColorSpace::YCbCr, |pixel| pixel[0], luma)
            }
            Some(ColorSpace::YCbCr | ColorSpace::Luma) => decoder.decode_into(luma),
            _ => decode_colour(
                &self.ready,
                ColorSpace::RGB,
                |pixel| grey::bt601(pixel[0], pixel[1], pixel[2]),
                luma,
            ),
        }
    }

    /// Copies the compressed bytes, with two changes that the decoder needs. (A hundredth of the time that decoding takes.)
    fn make_ready(&mut self, jpeg: &[u8], walk: &MarkerWalk) {
        let (start, rest) = jpeg.split_at(2.min(jpeg.len()));
        self.ready.clear();
        self.ready.extend_from_slice(start);
        if !walk.has_huffman_tables {
            self.ready.extend_from_slice(&STANDARD_TABLES);
        }
        self.ready.extend_from_slice(rest);
        if walk.scans == 1 {
            // Behind an end mark zune-jpeg 0.5 goes on with zeros, also in strict mode: a picture that lost a part of its
            // data would come out torn. Behind the last byte of its input it reports the loss.
            self.ready.truncate(self.ready.len() - END_MARK_BYTES);
            self.ready.extend_from_slice(&READ_AHEAD);
        }
    }
}

/// Decodes into a buffer with three bytes a pixel, then makes luma of it.
fn decode_colour(
    jpeg: &[u8],
    space: ColorSpace,
    to_luma: impl Fn(&[u8]) -> u8,
    luma: &mut [u8],
) -> Result<(), DecodeErrors> {
    let options = DecoderOptions::default().set_strict_mode(true).jpeg_set_out_colorspace(space);
    let pixels = JpegDecoder::new_with_options(ZCursor::new(jpeg), options).decode()?;
    for (out, pixel) in luma.iter_mut().zip(pixels.chunks_exact(3)) {
        *out = to_luma(pixel);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture whose APP1 segment holds a whole thumbnail, and whose entropy data holds stuffing, a restart and fill.
    fn picture_with_thumbnail() -> Vec<u8> {
        let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xE1, 0x00, 0x08, 0xFF, 0xD8, 0xFF, 0xD9, 0xFF, 0xD9];
        bytes.extend([0xFF, 0xFF, 0xC0, 0x00, 0x0B, 8, 0x00, 0x11, 0x01, 0x02, 1, 1, 0x11, 0]);
        bytes.extend([
            0xFF, 0xDA, 0x00, 0x08, 1, 1, 0, 0, 63, 0, 0x12, 0xFF, 0x00, 0x34, 0xFF, 0xD0, 0x56, 0xFF, 0xFF,
            0xD9,
        ]);
        bytes
    }

    #[test]
    fn the_end_is_found_behind_thumbnail_stuffing_and_restart_marks() {
        let mut bytes = picture_with_thumbnail();
        let length = bytes.len();
        bytes.extend([0xFF, 0xD8, 0xFF, 0xD9]);
        let mut walk = MarkerWalk::default();
        assert_eq!(walk.advance(&bytes), Walk::Complete(length));
        assert_eq!(walk.size, Some((0x0102, 0x0011)));
        assert!(!walk.has_huffman_tables);
    }

    #[test]
    fn a_walk_that_gets_its_bytes_one_by_one_ends_like_one_that_gets_them_at_once() {
        let bytes = picture_with_thumbnail();
        let mut walk = MarkerWalk::default();
        for end in 0..bytes.len() {
            assert_eq!(walk.advance(&bytes[..end]), Walk::NeedsMore, "after {end} bytes");
        }
        assert_eq!(walk.advance(&bytes), Walk::Complete(bytes.len()));
        assert_eq!(walk.size, Some((0x0102, 0x0011)));
    }

    #[test]
    fn a_picture_that_is_cut_by_the_next_one_is_broken_where_that_starts() {
        let whole = picture_with_thumbnail();
        let mut bytes = whole[..whole.len() - 4].to_vec();
        let cut = bytes.len();
        bytes.extend(&whole);
        assert_eq!(MarkerWalk::default().advance(&bytes), Walk::Broken(cut));
    }

    #[test]
    fn bytes_that_are_no_jpeg_are_broken_at_their_start() {
        assert_eq!(MarkerWalk::default().advance(b"RIFF"), Walk::Broken(0));
        assert_eq!(MarkerWalk::default().advance(&[0xFF, 0xD9]), Walk::Broken(0));
    }
}
