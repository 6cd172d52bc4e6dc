//! Random pictures of one tag each, whose corners are known.

use tagbus_family::Family;
use tagbus_scene::{
    Homography, Photo, Placement, Point, Stream, Tag, Tone, Turn, View, corners_of, homography_of, photograph,
};

/// A camera with a lens of normal width at 1280 pixels.
const FOCAL_PX: f64 = 800.0;

/// What pictures have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    pub(crate) pictures: u64,
    pub(crate) blur_sigma: f32,
    pub(crate) noise_sigma: f32,
    pub(crate) tone: Tone,
    /// How far black has spread into white, in cells.
    pub(crate) ink_spread_cells: f64,
    pub(crate) seed: u64,
}

/// A square picture of one tag.
pub(super) struct Picture {
    pub(super) luma: Vec<u8>,
    pub(super) side: usize,
    pub(super) id: u32,
    pub(super) truth: [Point; 4],
}

/// The pictures of a family at one size, one after the other.
pub(super) struct Pictures<'a> {
    conditions: &'a Conditions,
    family: &'a Family,
    cell_px: f64,
    random: Stream,
}

impl<'a> Pictures<'a> {
    pub(super) fn new(conditions: &'a Conditions, family: &'a Family, cell_px: f64) -> Self {
        Self { conditions, family, cell_px, random: Stream::new(conditions.seed ^ cell_px.to_bits()) }
    }

    pub(super) fn next(&mut self) -> Result<Picture, Box<dyn std::error::Error>> {
        let Conditions { blur_sigma, noise_sigma, tone, ink_spread_cells, .. } = *self.conditions;
        let side = (self.family.layout().total_width() as f64 * self.cell_px * 1.6) as usize + 60;
        let homography = self.place(side);
        let id = self.random.below(self.family.codes().len() as u64) as u32;
        let seed = self.random.bits();
        let photo =
            Photo { width: side, height: side, blur_sigma, noise_sigma, tone, seed, ..Photo::default() };
        let placement = Placement::new(Tag::new(self.family, id)?, homography);
        let luma = photograph(&photo, &[Placement { ink_spread_cells, ..placement }]);
        Ok(Picture { luma, side, id, truth: corners_of(&homography) })
    }

    fn place(&mut self, side: usize) -> Homography {
        let random = &mut self.random;
        let middle = side as f64 * 0.5;
        let centre = [middle + random.between(-2.0, 2.0), middle + random.between(-2.0, 2.0)];
        let turn = Turn {
            rotation_rad: random.between(0.0, std::f64::consts::TAU),
            tilt_rad: random.between(0.0, 30f64.to_radians()),
            tilt_direction_rad: random.between(0.0, std::f64::consts::TAU),
        };
        let view = View { centre, cell_px: self.cell_px, turn, focal_px: FOCAL_PX };
        homography_of(self.family.layout(), &view)
    }
}
