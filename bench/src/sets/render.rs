//! Frames of a data set.

use std::f64::consts::TAU;
use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder as _, ImageFormat};
use tagbus_camera::picture::Picture;
use tagbus_family::{Border, Family, Layout};
use tagbus_scene::{
    Glare, Motion, Paper, Photo, Placement, Stream, Tag, TrueTag, Turn, View, homography_of, photograph,
};

use super::recipe::{Bin, Card, Gloss, Ids, Recipe};

/// Printed size of a tag, measured across the outer limits of the print (paper, III-E).
const PRINT_CM: f64 = 4.0;
/// Grey levels that a mirrored lamp adds in its middle: enough to wash out all but the deepest black.
const LAMP: f32 = 220.0;

/// A frame with all that is known of it.
pub(crate) struct Frame {
    pub(crate) bin: Bin,
    pub(crate) picture: Picture,
    pub(crate) truth: Vec<TrueTag>,
}

impl Frame {
    /// FNV-1a over the pixels: enough to notice a change.
    pub(crate) fn hash(&self) -> u64 {
        let mix = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        self.picture.luma.iter().fold(0xcbf2_9ce4_8422_2325, mix)
    }
}

/// Renders the frames of one set and family.
pub(crate) struct Renderer {
    recipe: Recipe,
    family: Family,
    seed: u64,
}

/// What is chosen by chance for one frame, always in the same order, so that sets which differ in their light only show
/// the same tags in the same places.
struct Chances {
    id: u32,
    turn: Turn,
    place: [f64; 2],
    motion_rad: f64,
    lamp: [f64; 3],
    photo_seed: u64,
}

impl Renderer {
    pub(crate) fn new(recipe: Recipe, family: Family, seed: u64) -> Self {
        Self { recipe, family, seed }
    }

    pub(crate) fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    pub(crate) fn family(&self) -> &Family {
        &self.family
    }

    /// Frame `index`. Distances and tilts take turns, so that any first so many frames hold all of them alike.
    pub(crate) fn frame(&self, index: usize) -> Result<Frame, Box<dyn std::error::Error>> {
        let bins = self.recipe.bins();
        let bin = bins[index % bins.len()];
        let chances = self.chances(index, index / bins.len(), bin);
        let [width, height] = self.recipe.size;
        let placements = match self.recipe.ids {
            Ids::None => Vec::new(),
            Ids::Ten | Ids::Any => vec![self.placement(bin, &chances)?],
        };
        let truth = placements.iter().flat_map(|placement| placement.truth(width, height)).collect();
        let luma = photograph(&self.photo(&placements, &chances), &placements);
        let luma = match self.recipe.jpeg_quality {
            Some(quality) => through_jpeg(&luma, self.recipe.size, quality)?,
            None => luma,
        };
        Ok(Frame { bin, picture: Picture { width, height, luma }, truth })
    }

    fn chances(&self, index: usize, repetition: usize, bin: Bin) -> Chances {
        let codes = self.family.codes().len() as u64;
        let family_seed =
            self.family.name().bytes().fold(self.seed, |sum, byte| sum.wrapping_mul(31) + u64::from(byte));
        let mut random = Stream::new(Stream::new(family_seed.wrapping_add(index as u64)).bits());
        let any_id = random.below(codes) as u32;
        let one_of_ten = Stream::new(family_seed ^ (repetition as u64 % 10)).below(codes) as u32;
        Chances {
            id: if self.recipe.ids == Ids::Ten { one_of_ten } else { any_id },
            turn: Turn {
                rotation_rad: random.between(0.0, TAU),
                tilt_rad: f64::from(bin.tilt_deg).to_radians(),
                tilt_direction_rad: random.between(0.0, TAU),
            },
            place: [random.unit(), random.unit()],
            motion_rad: random.between(0.0, TAU),
            lamp: [random.between(-0.8, 0.8), random.between(-0.8, 0.8), random.between(0.15, 0.35)],
            photo_seed: random.bits(),
        }
    }

    /// The tag on its line of sight, at a place where the whole card is in the picture.
    fn placement(&self, bin: Bin, chances: &Chances) -> Result<Placement, Box<dyn std::error::Error>> {
        let layout = self.family.layout();
        let cell_cm = PRINT_CM / layout.total_width() as f64;
        let straight_on_px = self.recipe.focal_px * cell_cm / f64::from(bin.distance_cm);
        let room = self.room_px(straight_on_px * layout.total_width() as f64);
        let centre = [0, 1].map(|axis| {
            let side = self.recipe.size[axis] as f64;
            if side > 2.0 * room { room + chances.place[axis] * (side - 2.0 * room) } else { side / 2.0 }
        });
        let cell_px = straight_on_px * chances.turn.tilt_rad.cos().sqrt();
        let view = View { centre, cell_px, turn: chances.turn, focal_px: self.recipe.focal_px };
        let [black, white] = self.recipe.ink;
        let tag = Tag::new(&self.family, chances.id)?;
        let paper = paper(self.recipe.card, layout, cell_cm);
        let ink_spread_cells = self.recipe.ink_spread_cells;
        let placement = Placement::new(tag, homography_of(layout, &view));
        Ok(Placement { paper, black, white, ink_spread_cells, ..placement })
    }

    /// Half the diagonal of a card and a little more.
    fn room_px(&self, print_px: f64) -> f64 {
        let margin = match self.recipe.card {
            Card::Margin { width_cm } => 2.0 * width_cm / PRINT_CM,
            Card::Narrow { .. } => 0.0,
        };
        print_px * (1.0 + margin) * std::f64::consts::FRAC_1_SQRT_2 * 1.1 + 4.0
    }

    fn photo(&self, placements: &[Placement], chances: &Chances) -> Photo {
        let recipe = &self.recipe;
        let [width, height] = recipe.size;
        Photo {
            width,
            height,
            background: recipe.background,
            blur_sigma: recipe.blur_sigma,
            motion: Motion { length_px: recipe.motion_px, direction_rad: chances.motion_rad },
            glare: self.glare(placements, chances.lamp),
            vignetting: recipe.vignetting,
            tone: recipe.tone,
            noise_sigma: recipe.noise_sigma,
            seed: chances.photo_seed,
            ..Photo::default()
        }
    }

    /// A lamp whose mirror image lies somewhere within the tag's border and is a part of it wide.
    fn glare(&self, placements: &[Placement], [x, y, share]: [f64; 3]) -> Option<Glare> {
        let placement = placements.first().filter(|_| self.recipe.gloss == Gloss::Glossy)?;
        let corners = tagbus_scene::corners_of(&placement.homography);
        let side = (corners[1][0] - corners[0][0]).hypot(corners[1][1] - corners[0][1]);
        let centre = tagbus_scene::project(&placement.homography, [x, y]);
        Some(Glare { centre, radius_px: share * side, strength: LAMP })
    }
}

fn paper(card: Card, layout: &Layout, cell_cm: f64) -> Paper {
    match (card, layout.border()) {
        (Card::Margin { width_cm }, _) => Paper::Sheet { margin_cells: width_cm / cell_cm },
        // The print itself ends one white cell outside of the border edge.
        (Card::Narrow { cells }, Border::Normal) => Paper::Trimmed { cut_cells: 1.0 - cells },
        (Card::Narrow { cells: 0.0 }, Border::Reversed) => Paper::CutOut,
        (Card::Narrow { cells }, Border::Reversed) => Paper::Sheet { margin_cells: cells },
    }
}

/// The grey levels after encoding and decoding.
fn through_jpeg(luma: &[u8], [width, height]: [usize; 2], quality: u8) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    encoder.write_image(luma, width as u32, height as u32, ExtendedColorType::L8)?;
    let decoded = image::ImageReader::with_format(Cursor::new(bytes), ImageFormat::Jpeg).decode()?;
    Ok(decoded.into_luma8().into_raw())
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::{NAMES, named};
    use super::*;

    fn renderer(set: &str, family: &str) -> Renderer {
        Renderer::new(named(set).unwrap(), Family::published(family).unwrap(), 1)
    }

    #[test]
    fn the_calibrated_set_is_frozen() {
        let of = |family: &str| {
            let renderer = renderer("textured", family);
            [0, 19].map(|index| renderer.frame(index).unwrap().hash())
        };
        assert_eq!(of("tag36h11"), [15_543_516_160_110_302_204, 4_549_326_420_423_532_525]);
        assert_eq!(of("tagStandard41h12"), [8_242_942_013_723_214_157, 5_843_921_543_898_240_692]);
    }

    #[test]
    fn frames_of_every_set_hold_their_tag_whole_and_are_always_the_same() {
        for name in NAMES {
            for family in ["tag36h11", "tagStandard41h12"] {
                let renderer = renderer(name, family);
                let index = renderer.recipe().bins().len() - 1;
                let [one, other] = [0, 1].map(|_| renderer.frame(index).unwrap());
                assert_eq!(one.picture.luma, other.picture.luma, "{name}");
                let expected = usize::from(renderer.recipe().ids != Ids::None);
                assert_eq!(one.truth.len(), expected, "{name}");
                assert!(one.truth.iter().all(|tag| tag.visible), "{name}");
            }
        }
    }

    #[test]
    fn tags_are_as_large_as_their_distance_says() {
        let renderer = renderer("textured", "tag36h11");
        for index in 0..10 {
            let frame = renderer.frame(index).unwrap();
            let expected = renderer.recipe().focal_px * 0.4 / f64::from(frame.bin.distance_cm);
            assert!((frame.truth[0].cell_px / expected - 1.0).abs() < 1e-6, "{:?}", frame.bin);
        }
    }

    #[test]
    fn the_papers_set_shows_the_same_ten_tags_at_every_distance() {
        let renderer = renderer("paper", "tag36h11");
        let id = |index: usize| renderer.frame(index).unwrap().truth[0].id;
        assert_eq!(id(0), id(15));
        assert_ne!(id(0), id(16));
        assert_eq!(id(0), id(160));
    }
}
