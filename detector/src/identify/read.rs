//! Reading one quad as a tag of one family.

use super::Scratch;
use super::border::{self, Border};
use super::decode::{self, Decoded};
use super::homography::Homography;
use super::reader::Reader;
use super::refine;
use super::sample::Frame;
use crate::fit::Quad;
use crate::settings::{Refinement, Settings};

/// Border scores (see [`Border::score`]) below which a quad is not refined, and not decoded. The 1 % quantile of true tags
/// lies above 2.2 even at ten grey levels of contrast; three quarters of the quads of natural pictures stay below.
const REFINE_SCORE: f32 = 1.5;
const DECODE_SCORE: f32 = 2.0;

/// A quad that was read as a tag.
pub(super) struct Reading {
    pub(super) corners: [[f64; 2]; 4],
    pub(super) decoded: Decoded,
    pub(super) border: Border,
}

/// A frame to read from.
pub(super) struct Attempt<'a> {
    pub(super) frame: &'a Frame<'a>,
    pub(super) settings: &'a Settings,
    pub(super) scratch: &'a mut Scratch,
}

impl Attempt<'_> {
    /// Reads a quad as a tag of `reader`'s family. `None` when it is none.
    #[inline(always)]
    pub(super) fn read_quad(&mut self, reader: &Reader, quad: &Quad) -> Option<Reading> {
        let border = border::measure(self.frame, reader, &quad.corners)?;
        if border.score < REFINE_SCORE {
            return None;
        }
        let raw = self.read_at(reader, quad.corners, border);
        let reading = match self.settings.refinement {
            Refinement::None => raw?,
            Refinement::Edges => self.refined(reader, quad, raw)?,
            Refinement::Tag => {
                let refined = self.refined(reader, quad, raw)?;
                self.aligned(reader, refined)
            }
        };
        (reading.decoded.margin >= self.settings.min_margin).then_some(reading)
    }

    /// The better of what the quad's own corners gave and what refined ones give. Decoding before refining finds tags whose
    /// refinement goes astray; decoding after it finds those whose corners were cut off.
    #[inline(always)]
    fn refined(&mut self, reader: &Reader, quad: &Quad, raw: Option<Reading>) -> Option<Reading> {
        let factor = self.settings.decimation.factor();
        let Some(corners) = refine::refine(self.frame, reader, &quad.corners, factor) else {
            return raw;
        };
        let refined = border::measure(self.frame, reader, &corners)
            .and_then(|border| self.read_at(reader, corners, border));
        match (raw, refined) {
            // Unrefined corners may give the better code, never the better corners.
            (Some(raw), Some(refined)) if raw.decoded.found.hamming < refined.decoded.found.hamming => {
                Some(Reading { corners, ..raw })
            }
            (Some(raw), None) => Some(Reading { corners, ..raw }),
            (_, refined) => refined,
        }
    }

    /// The reading with its corners where the whole tag fits best, if that gives the same tag again.
    #[inline(always)]
    fn aligned(&mut self, reader: &Reader, reading: Reading) -> Reading {
        let code = reader.code_as_read(&reading.decoded.found);
        let Scratch { align, .. } = &mut *self.scratch;
        let Some(corners) = align.align(self.frame, reader, code, &reading.corners, &reading.border) else {
            return reading;
        };
        let again = border::measure(self.frame, reader, &corners)
            .and_then(|border| self.read_at(reader, corners, border));
        let same = |again: &Reading| {
            let (a, b) = (again.decoded.found, reading.decoded.found);
            a.id == b.id && a.rotation == b.rotation
        };
        again.filter(same).unwrap_or(reading)
    }

    #[inline(always)]
    fn read_at(&mut self, reader: &Reader, corners: [[f64; 2]; 4], border: Border) -> Option<Reading> {
        if border.score < DECODE_SCORE {
            return None;
        }
        let homography = Homography::from_square(&corners, reader.width)?;
        let sharpening = self.settings.sharpening;
        let cells = &mut self.scratch.cells;
        let decoded = decode::decode(self.frame, reader, &homography, &border, sharpening, cells)?;
        Some(Reading { corners, decoded, border })
    }
}
