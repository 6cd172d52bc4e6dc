//! The moving show: several tags on their orbits through a room.

use crate::blur::{Blur, BlurScratch};
use crate::camera::Camera;
use crate::canvas::{Canvas, Window};
use crate::cast::{Actor, cast};
use crate::config::{SceneConfig, SceneError};
use crate::coverage::Coverage;
use crate::elementary::sine_of_turns;
use crate::exposure::{Exposure, Light};
use crate::placement::{Paper, Print};
use crate::random::{Normals, key_for};
use crate::room::paint_room;
use crate::tag::TrueTag;
use std::f64::consts::TAU;
use std::fmt;

/// After this many seconds every tag is back where it started.
const ROUND_S: f64 = 24.0;
/// Horizontal field of view: 60 degrees.
const FIELD_OF_VIEW_RAD: f64 = TAU / 6.0;
/// Standard deviation of the lens blur in pixels.
const BLUR_SIGMA: f32 = 0.6;
/// Standard deviation of the noise in grey levels.
const NOISE_SIGMA: f32 = 2.0;
/// Memory that rendering needs. Kept from one frame to the next, it spares every allocation after the first ones.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    canvas: Canvas,
    coverage: Coverage,
    blur: BlurScratch,
}

/// An endless show of moving tags with known truth; every frame is a pure function of the configuration and the
/// frame's number, the same on every machine.
pub struct Scene {
    config: SceneConfig,
    frame: Window,
    camera: Camera,
    actors: Vec<Actor>,
    /// The room as it is, and as the lens shows it, in whole grey levels (the noise hides the rounding). Where a tag
    /// is, tag and room are blurred together.
    sharp_room: Vec<u8>,
    blurred_room: Vec<u8>,
    blur: Blur,
    normals: Normals,
    noise_seed: u64,
}

impl fmt::Debug for Scene {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_struct("Scene").field("config", &self.config).finish_non_exhaustive()
    }
}

impl Scene {
    /// Chooses the tags and paints the room, which takes many times as long as a frame.
    ///
    /// # Errors
    /// [`SceneError`], when a size, the frame rate or a family is not what [`SceneConfig`] says.
    pub fn new(config: SceneConfig) -> Result<Scene, SceneError> {
        config.check()?;
        let (width, height) = (config.width, config.height);
        let frame = Window::whole(width, height);
        let blur = Blur::new(BLUR_SIGMA);
        let mut room = paint_room(frame, config.seed);
        let sharp_room = in_bytes(&room);
        blur.apply(&mut room, &mut BlurScratch::default());
        Ok(Scene {
            frame,
            camera: Camera::with_field_of_view(width, height, FIELD_OF_VIEW_RAD),
            actors: cast(&config)?,
            sharp_room,
            blurred_room: in_bytes(&room),
            blur,
            normals: Normals::new(),
            noise_seed: key_for(config.seed, 4),
            config,
        })
    }

    /// The configuration that the scene was made with.
    pub fn config(&self) -> &SceneConfig {
        &self.config
    }

    /// Renders a frame into `width * height` bytes, row after row.
    ///
    /// # Panics
    /// When `luma` has another length.
    pub fn render(&self, frame: u64, luma: &mut [u8]) {
        self.render_with(frame, &mut Scratch::default(), luma);
    }

    /// [`Scene::render`] with memory that is kept from frame to frame.
    ///
    /// # Panics
    /// When `luma` has another length than `width * height`.
    pub fn render_with(&self, frame: u64, scratch: &mut Scratch, luma: &mut [u8]) {
        assert_eq!(
            luma.len(),
            self.sharp_room.len(),
            "a frame has {}x{} bytes",
            self.frame.width,
            self.frame.height
        );
        let round = self.round_at(frame);
        let exposure = Exposure {
            light: light_at(round),
            noise_sigma: NOISE_SIGMA,
            noise_key: key_for(self.noise_seed, frame),
            normals: &self.normals,
            frame: self.frame,
        };
        self.render_room(&exposure, luma);
        for actor in &self.actors {
            self.render_tag(&self.print(actor, round), &exposure, scratch, luma);
        }
    }

    /// What is to be found in a frame: every tag, nested ones after the tag around them.
    pub fn truth(&self, frame: u64) -> Vec<TrueTag> {
        let round = self.round_at(frame);
        let (width, height) = (self.frame.width, self.frame.height);
        let truth_of =
            |actor: &Actor| actor.tag.truth(&actor.orbit.homography(&self.camera, round), width, height);
        self.actors.iter().flat_map(truth_of).collect()
    }

    /// How many rounds have passed when a frame is taken.
    fn round_at(&self, frame: u64) -> f64 {
        frame as f64 / self.config.framerate / ROUND_S
    }

    fn print<'a>(&self, actor: &'a Actor, round: f64) -> Print<'a> {
        Print {
            tag: &actor.tag,
            homography: actor.orbit.homography(&self.camera, round),
            paper: Paper::CutOut,
            black: actor.black,
            white: actor.white,
            ink_spread_cells: 0.0,
        }
    }

    /// The whole frame, as if no tag were there.
    fn render_room(&self, exposure: &Exposure, luma: &mut [u8]) {
        let width = self.frame.width;
        let rows = self.blurred_room.chunks_exact(width).zip(luma.chunks_exact_mut(width));
        for (y, (room, bytes)) in rows.enumerate() {
            exposure.develop(y, 0, room.iter().copied().map(f32::from), bytes);
        }
    }

    /// The pixels that a tag changes: those it touches, and around them as far as the blur reaches. For the blur of
    /// the outermost of these the room is needed once more as far.
    fn render_tag(&self, print: &Print, exposure: &Exposure, scratch: &mut Scratch, luma: &mut [u8]) {
        let touched = print.window(&self.frame);
        if touched.is_empty() {
            return;
        }
        let changed = touched.grown(self.blur.reach(), &self.frame);
        scratch.canvas.move_to(changed.grown(self.blur.reach(), &self.frame));
        self.copy_room(&mut scratch.canvas);
        print.paint(&mut scratch.canvas, &mut scratch.coverage);
        self.blur.apply(&mut scratch.canvas, &mut scratch.blur);
        for y in changed.rows() {
            let levels = scratch.canvas.row(y, changed.columns()).iter().copied();
            let bytes = &mut luma[y * self.frame.width..][changed.columns()];
            exposure.develop(y, changed.left, levels, bytes);
        }
    }

    fn copy_room(&self, canvas: &mut Canvas) {
        let window = canvas.window;
        for y in window.rows() {
            let room = &self.sharp_room[y * self.frame.width..][window.columns()];
            for (pixel, &level) in canvas.row_mut(y, window.columns()).iter_mut().zip(room) {
                *pixel = f32::from(level);
            }
        }
    }
}

/// The light changes slowly, in strength and in direction.
fn light_at(round: f64) -> Light {
    Light {
        gain: (1.0 + 0.08 * sine_of_turns(2.0 * round)) as f32,
        slope_x: (0.15 * sine_of_turns(round + 0.2)) as f32,
        slope_y: (0.10 * sine_of_turns(3.0 * round + 0.6)) as f32,
    }
}

/// Grey levels, rounded.
fn in_bytes(canvas: &Canvas) -> Vec<u8> {
    canvas.pixels.iter().map(|&level| (level + 0.5) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::homography::project;
    use tagbus_family::{Border, Family};

    fn scene(width: usize, height: usize, seed: u64) -> Scene {
        Scene::new(SceneConfig { width, height, seed, ..SceneConfig::default() }).unwrap()
    }

    fn rendered(scene: &Scene, frame: u64) -> Vec<u8> {
        let mut luma = vec![0; scene.config().width * scene.config().height];
        scene.render(frame, &mut luma);
        luma
    }

    /// FNV-1a, 64 bits.
    fn hash(bytes: &[u8]) -> u64 {
        bytes
            .iter()
            .fold(0xCBF2_9CE4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
    }

    #[test]
    fn a_frame_has_the_same_bytes_on_every_machine() {
        const PINNED: u64 = 8_207_133_061_601_489_265;
        assert_eq!(hash(&rendered(&scene(160, 120, 1), 1000)), PINNED);
    }

    #[test]
    fn frames_follow_from_seed_and_number_alone() {
        let [one, same, other] = [1, 1, 2].map(|seed| scene(160, 120, seed));
        let mut scratch = Scratch::default();
        let mut luma = vec![0; 160 * 120];
        for frame in [7, 3, 7, u64::MAX] {
            one.render_with(frame, &mut scratch, &mut luma);
            assert_eq!(luma, rendered(&same, frame));
        }
        assert_ne!(rendered(&one, 7), rendered(&other, 7));
        assert_ne!(rendered(&one, 7), rendered(&one, 8));
    }

    #[test]
    fn half_the_framerate_makes_twice_the_steps() {
        let slow = Scene::new(SceneConfig { framerate: 15.0, ..SceneConfig::default() }).unwrap();
        assert_eq!(slow.truth(50), scene(640, 480, 1).truth(100));
    }

    #[test]
    fn every_tag_of_the_default_scene_is_visible_and_most_cells_have_five_pixels() {
        let scene = scene(640, 480, 1);
        let truth: Vec<TrueTag> = (0..72).flat_map(|step| scene.truth(10 * step)).collect();
        assert_eq!(truth.len(), 72 * 7);
        assert!(truth.iter().all(|tag| tag.visible && tag.cell_px > 3.5));
        let large = truth.iter().filter(|tag| tag.cell_px >= 5.0).count();
        assert!(large * 3 > truth.len() * 2, "{large} of {}", truth.len());
    }

    #[test]
    fn black_and_white_cells_are_where_truth_says() {
        let scene = scene(640, 480, 3);
        for frame in [0, 100, 500] {
            let luma = rendered(&scene, frame);
            for tag in scene.truth(frame) {
                let family = Family::published(&tag.family).unwrap();
                let dark_ring = match family.layout().border() {
                    Border::Normal => 1.0 - 1.0 / family.layout().width_at_border() as f64,
                    Border::Reversed => 1.0 + 1.0 / family.layout().width_at_border() as f64,
                };
                let level = |radius: f64| {
                    let [x, y] = project(&tag.homography, [-radius, 0.1]);
                    luma[y as usize * 640 + x as usize]
                };
                let (dark, light) = (level(dark_ring), level(2.0 - dark_ring));
                assert!(light > dark + 100, "{} {}: {dark} against {light}", tag.family, tag.id);
            }
        }
    }

    #[test]
    fn the_room_stands_still_behind_the_noise() {
        let scene = Scene::new(SceneConfig { families: Vec::new(), ..SceneConfig::default() }).unwrap();
        assert!(scene.truth(5).is_empty());
        // A round later the light is the same, so only the noise differs.
        let (one, other) = (rendered(&scene, 0), rendered(&scene, 720));
        let squares =
            one.iter().zip(&other).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum::<f64>();
        let sigma = (squares / one.len() as f64 / 2.0).sqrt();
        // Rounding adds a twelfth to the variance.
        let expected = (f64::from(NOISE_SIGMA).powi(2) + 1.0 / 12.0).sqrt();
        assert!((sigma / expected - 1.0).abs() < 0.03, "sigma {sigma}");
    }

    #[test]
    fn the_smallest_scene_renders() {
        assert_eq!(rendered(&scene(16, 16, 1), 5).len(), 256);
        assert_eq!(rendered(&scene(16_384, 16, 1), 5).len(), 16_384 * 16);
    }
}
