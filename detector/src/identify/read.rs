//! Reading one quad as a tag of one family.

use tagbus_family::Found;

use super::Scratch;
use super::border::{self, Border};
use super::decode::{self, Bits};
use super::homography::Homography;
use super::reader::Reader;
use super::refine::{self, Effort};
use super::sample::Frame;
use crate::fit::Quad;
use crate::settings::{Refinement, Settings};

/// Border scores (see [`Border::score`]) below which a quad is not refined, and not decoded. The 1 % quantile of true tags
/// lies above 2.2 even at ten grey levels of contrast; three quarters of the quads of natural pictures stay below.
const REFINE_SCORE: f32 = 1.5;
const DECODE_SCORE: f32 = 2.0;

/// Bits that refining the corners may put right, beyond those that are corrected. Of natural quads with the right border a
/// tenth come so near to some tag of 41h12.
const BITS_TO_GAIN: u32 = 6;
/// Bits that may be wrong where corners come from a decimated search, before anything is refined.
const BITS_TO_GAIN_DECIMATED: u32 = 8;

/// A quad that was read as a tag.
pub(super) struct Reading {
    pub(super) corners: [[f64; 2]; 4],
    pub(super) found: Found,
    pub(super) bits: Bits,
    pub(super) border: Border,
}

impl Reading {
    fn is_surer_than(&self, other: &Reading) -> bool {
        self.found.hamming < other.found.hamming
    }
}

/// What refinement gave.
struct Refined {
    reading: Reading,
    /// Whether the corners are the quad's, because refined ones gave no tag or a less sure one.
    is_astray: bool,
}

impl Refined {
    fn astray(reading: Reading) -> Self {
        Self { reading, is_astray: true }
    }

    /// With the corners that long sides give with more profiles than reading it took.
    #[inline(always)]
    fn with_long_sides(self, frame: &Frame, reader: &Reader) -> Reading {
        let corners = self.reading.corners;
        if self.is_astray || !Effort::is_worth_it(&corners) {
            return self.reading;
        }
        let refined = refine::refine(frame, reader, &corners, &Effort::to_report());
        Reading { corners: refined.unwrap_or(corners), ..self.reading }
    }
}

/// A reading and the family that it belongs to.
pub(super) struct Tag<'r> {
    pub(super) reader: &'r Reader,
    pub(super) reading: Reading,
}

impl Tag<'_> {
    /// Logarithm of the number of such readings that random bits would give.
    fn chance(&self) -> f64 {
        self.reader.chance(self.reading.found.hamming)
    }
}

fn surer<'r>(a: Option<Tag<'r>>, b: Option<Tag<'r>>) -> Option<Tag<'r>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.chance() < a.chance() { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// A reading that random bits give more rarely than this needs no second opinion: all of 36h11, 41h12 and larger
/// families; of smaller ones only those without corrected bits, and none of 16h5.
const SURE_CHANCE: f64 = 1e-4;

/// Whether better corners may make a tag of these bits.
#[inline(always)]
fn is_near_a_tag(reader: &Reader, bits: &Bits) -> bool {
    reader.bits_from_nearest(bits.code) <= reader.index.hamming() + BITS_TO_GAIN
}

/// What a quad's corners gave.
enum First {
    /// No tag, whatever is done to its corners.
    Hopeless,
    /// No tag yet.
    Unread,
    Tag(Reading),
}

/// A frame to read from.
pub(super) struct Attempt<'a> {
    pub(super) frame: &'a Frame<'a>,
    pub(super) settings: &'a Settings,
    pub(super) scratch: &'a mut Scratch,
}

impl Attempt<'_> {
    /// Reads a quad as a tag of one of the families that have its border. `None` when it is none.
    ///
    /// First with its corners as they are, for every family: where that gives a sure tag, only that family is followed up.
    #[inline(always)]
    pub(super) fn read_quad<'r>(&mut self, readers: &'r [Reader], quad: &Quad) -> Option<Tag<'r>> {
        let mut best: Option<Tag> = None;
        self.scratch.unread.clear();
        for (place, reader) in readers.iter().enumerate().filter(|(_, reader)| reader.border == quad.border) {
            match self.first_look(reader, quad) {
                First::Hopeless => {}
                First::Unread => self.scratch.unread.push(place),
                First::Tag(reading) => best = surer(best, Some(Tag { reader, reading })),
            }
        }
        let best = best.and_then(|Tag { reader, reading }| {
            let reading = self.finish(reader, quad, Some(reading))?;
            Some(Tag { reader, reading })
        });
        if best.as_ref().is_some_and(|best| best.chance() < SURE_CHANCE.ln()) {
            return best;
        }
        self.read_unread(readers, quad, best)
    }

    /// The surest of `best` and what refined corners give in the families that could not be read at once.
    #[inline(always)]
    fn read_unread<'r>(
        &mut self,
        readers: &'r [Reader],
        quad: &Quad,
        best: Option<Tag<'r>>,
    ) -> Option<Tag<'r>> {
        let unread = std::mem::take(&mut self.scratch.unread);
        // A loop, since a closure would be compiled without the level's instructions.
        let mut surest = best;
        for place in &unread {
            let reader = &readers[*place];
            surest = surer(surest, self.finish(reader, quad, None).map(|reading| Tag { reader, reading }));
        }
        self.scratch.unread = unread;
        surest
    }

    /// What comes after the first look: corners refined as the settings say, and the last test.
    #[inline(always)]
    fn finish(&mut self, reader: &Reader, quad: &Quad, raw: Option<Reading>) -> Option<Reading> {
        let reading = match self.settings.refinement {
            Refinement::None => raw?,
            Refinement::Edges => self.refined(reader, quad, raw)?.with_long_sides(self.frame, reader),
            Refinement::Tag => {
                let refined = self.refined(reader, quad, raw)?;
                match self.aligned(reader, &refined.reading) {
                    Some(aligned) => aligned,
                    None => refined.with_long_sides(self.frame, reader),
                }
            }
        };
        (reading.bits.margin >= self.settings.min_margin).then_some(reading)
    }

    /// Reads a quad with its corners as they are.
    #[inline(always)]
    fn first_look(&mut self, reader: &Reader, quad: &Quad) -> First {
        let Some(homography) = Homography::from_square(&quad.corners, reader.width) else {
            return First::Hopeless;
        };
        let Some(border) = border::measure(self.frame, reader, &homography) else { return First::Hopeless };
        if border.score < REFINE_SCORE {
            return First::Hopeless;
        }
        if border.score < DECODE_SCORE {
            return First::Unread;
        }
        let bits = self.bits_at(reader, &homography, &border);
        let is_decimated = self.settings.decimation.factor() > 1.0;
        let to_gain = if is_decimated { BITS_TO_GAIN_DECIMATED } else { BITS_TO_GAIN };
        if !reader.may_hold(bits.code, reader.index.hamming() + to_gain) {
            return First::Hopeless;
        }
        match bits.look_up(reader) {
            Some(found) => First::Tag(Reading { corners: quad.corners, found, bits, border }),
            // The corners of a decimated search may be so far off that the bits say nothing yet.
            None if is_decimated || is_near_a_tag(reader, &bits) => First::Unread,
            None => First::Hopeless,
        }
    }

    /// The better of what the quad's own corners gave and what refined ones give. Decoding before refining finds tags whose
    /// refinement goes astray; decoding after it finds those whose corners were cut off.
    #[inline(always)]
    fn refined(&mut self, reader: &Reader, quad: &Quad, raw: Option<Reading>) -> Option<Refined> {
        let factor = self.settings.decimation.factor();
        if raw.is_none() && !self.is_promising(reader, quad, factor) {
            return None;
        }
        let mut refined = self.read_refined(reader, quad, &Effort::to_read(factor));
        if refined.is_none() && raw.is_some() && factor > 1.0 {
            refined = self.read_refined(reader, quad, &Effort::to_read_from_afar(factor));
        }
        // Refinement that loses the tag, or turns it into a less sure one, went astray.
        let Some(refined) = refined else { return raw.map(Refined::astray) };
        let corners = refined.corners;
        let reading = match raw {
            Some(raw) if raw.is_surer_than(&refined) => {
                if raw.found.id != refined.found.id {
                    return Some(Refined::astray(raw));
                }
                // Unrefined corners may give the better code, never the better corners.
                Reading { corners, ..raw }
            }
            _ => refined,
        };
        Some(Refined { reading, is_astray: false })
    }

    /// Whether a quad that was not read comes near to a tag once its corners are roughly refined: what most quads cost that are
    /// no tags.
    #[inline(always)]
    fn is_promising(&mut self, reader: &Reader, quad: &Quad, factor: f64) -> bool {
        let Some(corners) = refine::refine(self.frame, reader, &quad.corners, &Effort::to_try(factor)) else {
            return false;
        };
        let Some(homography) = Homography::from_square(&corners, reader.width) else { return false };
        let Some(border) = border::measure(self.frame, reader, &homography) else { return false };
        border.score >= REFINE_SCORE && is_near_a_tag(reader, &self.bits_at(reader, &homography, &border))
    }

    /// What the quad's corners give once they are moved to the edges.
    #[inline(always)]
    fn read_refined(&mut self, reader: &Reader, quad: &Quad, effort: &Effort) -> Option<Reading> {
        let corners = refine::refine(self.frame, reader, &quad.corners, effort)?;
        self.read_at(reader, corners)
    }

    /// The reading with its corners where the whole tag fits best; `None` if that does not give the same tag again.
    #[inline(always)]
    fn aligned(&mut self, reader: &Reader, reading: &Reading) -> Option<Reading> {
        let code = reader.code_as_read(&reading.found);
        let align = &mut self.scratch.align;
        let corners = align.align(self.frame, reader, code, &reading.corners, &reading.border)?;
        let same = |again: &Reading| {
            again.found.id == reading.found.id && again.found.rotation == reading.found.rotation
        };
        self.read_at(reader, corners).filter(same)
    }

    #[inline(always)]
    fn read_at(&mut self, reader: &Reader, corners: [[f64; 2]; 4]) -> Option<Reading> {
        let homography = Homography::from_square(&corners, reader.width)?;
        let border = border::measure(self.frame, reader, &homography)?;
        if border.score < DECODE_SCORE {
            return None;
        }
        let bits = self.bits_at(reader, &homography, &border);
        Some(Reading { corners, found: bits.look_up(reader)?, bits, border })
    }

    #[inline(always)]
    fn bits_at(&mut self, reader: &Reader, homography: &Homography, border: &Border) -> Bits {
        let sharpening = self.settings.sharpening;
        decode::sample(self.frame, reader, homography, border, sharpening, &mut self.scratch.cells)
    }
}
