//! What a quadrotor sees above its landing pad.

use std::f64::consts::TAU;

use tagbus_camera::picture::Picture;
use tagbus_family::Family;
use tagbus_scene::{Background, Camera, Photo, Placement, Pose, Stream, Tag, TrueTag, Turn, photograph};

use super::measure::Failure;

/// The family with a hole in its middle.
pub(super) const FAMILY: &str = "tagCustom48h12";
/// Width of the outermost print in metres (paper, IV-A). Each tag fills the hole of the one around it, a fifth of its
/// width: 90.2, 18.04 and 3.608 cm.
const PRINT_M: f64 = 0.902;
/// The Raspberry Pi camera V2 at the paper's resolution.
const SIZE: [usize; 2] = [640, 480];
const FIELD_OF_VIEW_DEG: f64 = 62.2;
/// Hovering is never quite level. More than that is not drawn at the nearest distance, where a corner of the print would
/// lie behind the camera.
const LARGEST_TILT_DEG: f64 = 5.0;
/// How far the print's middle may be from that of the picture, in pixels along either axis.
const DRIFT_PX: f64 = 40.0;

/// A picture, and the three tags from the outermost to the innermost.
pub(super) struct Frame {
    pub(super) picture: Picture,
    pub(super) truth: Vec<TrueTag>,
}

/// Renders the pad. Light, blur and noise are those of the textured set (`sets`).
pub(super) struct Landing {
    family: Family,
    camera: Camera,
}

impl Landing {
    pub(super) fn new() -> Result<Self, Failure> {
        let [width, height] = SIZE;
        Ok(Self {
            family: Family::published(FAMILY)?,
            camera: Camera::with_field_of_view(width, height, FIELD_OF_VIEW_DEG.to_radians()),
        })
    }

    /// The pad from this distance (from the camera to the plane through the print's middle, along the optical axis). A
    /// seed gives noise, room behind, ids, rotation, tilt and place.
    pub(super) fn frame(&self, distance_m: f64, seed: u64) -> Result<Frame, Failure> {
        let mut random = Stream::new(seed);
        let tag = self.nest(&mut random)?;
        let pose = self.pose(distance_m, &mut random);
        let layout = self.family.layout();
        let border_m = PRINT_M * layout.width_at_border() as f64 / layout.total_width() as f64;
        let placement = Placement::new(tag, self.camera.homography_of(&pose, border_m * 0.5));
        let [width, height] = SIZE;
        let photo = Photo {
            width,
            height,
            background: Background::FullRoom,
            blur_sigma: 0.6,
            vignetting: 0.25,
            noise_sigma: 2.5,
            seed: random.bits(),
            ..Photo::default()
        };
        let truth = placement.truth(width, height);
        Ok(Frame { picture: Picture { width, height, luma: photograph(&photo, &[placement]) }, truth })
    }

    /// Three tags with ids of their own.
    fn nest(&self, random: &mut Stream) -> Result<Tag, Failure> {
        let count = self.family.codes().len() as u64;
        let first = random.below(count);
        let tag = |step: u64| Tag::new(&self.family, ((first + step) % count) as u32);
        Ok(tag(0)?.nest(tag(1)?.nest(tag(2)?)?)?)
    }

    fn pose(&self, distance_m: f64, random: &mut Stream) -> Pose {
        let turn = Turn {
            rotation_rad: random.between(0.0, TAU),
            tilt_rad: random.between(0.0, LARGEST_TILT_DEG.to_radians()),
            tilt_direction_rad: random.between(0.0, TAU),
        };
        let place = self.camera.principal.map(|middle| middle + random.between(-DRIFT_PX, DRIFT_PX));
        let translation = self.camera.direction_of(place).map(|value| value * distance_m);
        Pose { rotation: turn.rotation(), translation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_tags_are_as_wide_as_they_were_printed() {
        let landing = Landing::new().unwrap();
        let truth = landing.frame(2.0, 7).unwrap().truth;
        let cells: Vec<f64> = truth.iter().map(|tag| tag.cell_px).collect();
        // 62.2 degrees over 640 pixels are a focal length of 530.5 px. A tilt takes off less than a hundredth each for
        // the slant and the farther side.
        for (cell_px, print_m) in cells.iter().zip([0.902, 0.1804, 0.03608]) {
            let straight_on = 530.5 * print_m / 10.0 / 2.0;
            assert!((0.95..1.001).contains(&(cell_px / straight_on)), "{cell_px} against {straight_on}");
        }
        assert_eq!(truth.len(), 3);
        assert_eq!(truth[1].id, (truth[0].id + 1) % landing.family.codes().len() as u32);
    }

    #[test]
    fn only_the_innermost_tag_is_whole_at_the_nearest_distance_and_the_print_is_drawn_there() {
        let landing = Landing::new().unwrap();
        for seed in 0..20 {
            let frame = landing.frame(0.08, seed).unwrap();
            let whole: Vec<bool> = frame.truth.iter().map(|tag| tag.visible).collect();
            assert_eq!(whole, [false, false, true], "seed {seed}");
            let dark = frame.picture.luma.iter().filter(|level| **level < 60).count();
            assert!(dark > 640 * 480 / 10, "seed {seed}: {dark} dark pixels");
        }
    }
}
