//! The moving show: several tags on their orbits through a room.

use crate::blur::{Blur, BlurScratch};
use crate::camera::Camera;
use crate::canvas::{Canvas, Window};
use crate::coverage::Coverage;
use crate::elementary::sine_of_turns;
use crate::exposure::{Exposure, Light};
use crate::orbit::{Orbit, regions_for};
use crate::placement::{Paper, Print};
use crate::random::{Normals, Stream, key_for};
use crate::room::paint_room;
use crate::tag::{Tag, TagError, TrueTag};
use std::f64::consts::TAU;
use std::fmt;
use tagbus_family::{Family, UnknownFamily};

/// After this many seconds every tag is back where it started.
const ROUND_S: f64 = 24.0;
/// Horizontal field of view: 60 degrees.
const FIELD_OF_VIEW_RAD: f64 = TAU / 6.0;
/// Standard deviation of the lens blur in pixels.
const BLUR_SIGMA: f32 = 0.6;
/// Standard deviation of the noise in grey levels.
const NOISE_SIGMA: f32 = 2.0;
/// The smallest and the largest width and height.
const SIZES: std::ops::RangeInclusive<usize> = 16..=16_384;

/// What a scene shows, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneConfig {
    /// Width in pixels, 16..=16384. Default 640.
    pub width: usize,
    /// Height in pixels, 16..=16384. Default 480.
    pub height: usize,
    /// Frames a second. Tags move by the second, so a higher rate means smaller steps. Default 30.
    pub framerate: f64,
    /// Chooses the room, the ids and the ways of the tags. Default 1.
    pub seed: u64,
    /// One tag for each entry: the name of a published family, or several names joined by `/` for tags nested in each
    /// other, the outermost first. Default: two tag36h11, a tagStandard41h12, a tag25h9, a tagCircle21h7, and
    /// `tagCustom48h12/tagStandard41h12`.
    pub families: Vec<String>,
}

impl Default for SceneConfig {
    fn default() -> SceneConfig {
        let families = [
            "tagCustom48h12/tagStandard41h12",
            "tag36h11",
            "tagStandard41h12",
            "tag25h9",
            "tagCircle21h7",
            "tag36h11",
        ];
        let families = families.map(str::to_owned).to_vec();
        SceneConfig { width: 640, height: 480, framerate: 30.0, seed: 1, families }
    }
}

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// Width or height is out of range.
    Size {
        /// The width asked for, in pixels.
        width: usize,
        /// The height asked for, in pixels.
        height: usize,
    },
    /// The frame rate is not a positive number.
    Framerate(f64),
    /// A family does not exist.
    Family(UnknownFamily),
    /// Tags cannot be nested that way.
    Nest(TagError),
}

impl fmt::Display for SceneError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let (least, most) = (SIZES.start(), SIZES.end());
        match self {
            SceneError::Size { width, height } => {
                write!(formatter, "a scene of {width}x{height} pixels: width and height go from {least} to {most}")
            }
            SceneError::Framerate(framerate) => {
                write!(formatter, "a scene with {framerate} frames a second: give a positive number such as 30")
            }
            SceneError::Family(unknown) => unknown.fmt(formatter),
            SceneError::Nest(refused) => refused.fmt(formatter),
        }
    }
}

impl std::error::Error for SceneError {}

/// A tag with its way through the picture.
struct Actor {
    tag: Tag,
    orbit: Orbit,
    black: f32,
    white: f32,
}

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
        check(&config)?;
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
        assert_eq!(luma.len(), self.sharp_room.len(), "a frame has {}x{} bytes", self.frame.width, self.frame.height);
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
        let truth_of = |actor: &Actor| actor.tag.truth(&actor.orbit.homography(&self.camera, round), width, height);
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

fn check(config: &SceneConfig) -> Result<(), SceneError> {
    let SceneConfig { width, height, framerate, .. } = *config;
    if !SIZES.contains(&width) || !SIZES.contains(&height) {
        return Err(SceneError::Size { width, height });
    }
    if !framerate.is_finite() || framerate <= 0.0 {
        return Err(SceneError::Framerate(framerate));
    }
    Ok(())
}

/// Chooses the tags and gives each its region, its way and its grey levels.
fn cast(config: &SceneConfig) -> Result<Vec<Actor>, SceneError> {
    let mut stream = Stream::new(key_for(config.seed, 3));
    let mut taken = Vec::new();
    let tags = config.families.iter().map(|names| choose_tag(names, &mut stream, &mut taken));
    let tags = tags.collect::<Result<Vec<Tag>, SceneError>>()?;
    let regions = regions_for(&tags, config.width, config.height);
    let actors = tags.into_iter().zip(regions).map(|(tag, region)| Actor {
        orbit: Orbit::new(&tag, region, &mut stream),
        tag,
        black: stream.between(25.0, 45.0) as f32,
        white: stream.between(195.0, 220.0) as f32,
    });
    Ok(actors.collect())
}

/// A tag of the family named, or a nest of tags when there are several names.
fn choose_tag(names: &str, stream: &mut Stream, taken: &mut Vec<(String, u32)>) -> Result<Tag, SceneError> {
    let (outer, inner) = match names.split_once('/') {
        Some((outer, inner)) => (outer, Some(inner)),
        None => (names, None),
    };
    let family = Family::published(outer.trim()).map_err(SceneError::Family)?;
    let tag = Tag::new(&family, choose_id(&family, stream, taken)).map_err(SceneError::Nest)?;
    match inner {
        Some(inner) => tag.nest(choose_tag(inner, stream, taken)?).map_err(SceneError::Nest),
        None => Ok(tag),
    }
}

/// A random id that no other tag of the family has, as long as there are enough.
fn choose_id(family: &Family, stream: &mut Stream, taken: &mut Vec<(String, u32)>) -> u32 {
    let count = family.codes().len() as u32;
    let first = stream.below(u64::from(count)) as u32;
    let is_free = |id: &u32| !taken.iter().any(|(name, other)| name == family.name() && other == id);
    let id = (0..count).map(|step| (first + step) % count).find(is_free).unwrap_or(first);
    taken.push((family.name().to_owned(), id));
    id
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
