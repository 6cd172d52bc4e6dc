//! Phase 4: which quads are tags, and which.
//!
//! ```text
//! quad ─▶ border gate ─▶ decode ─▶ refine ─▶ border gate ─▶ decode ─▶ the better of both ─▶ overlaps resolved
//!         most end here                       with the corners that are reported
//! ```

mod border;
mod decode;
mod homography;
mod overlap;
mod reader;
mod refine;
mod sample;

pub(crate) use reader::Reader;

use crate::detection::{Detection, Flags};
use crate::fit::Quad;
use crate::settings::Settings;
use crate::simd::{Kernel, Level};
use crate::view::LumaView;
use border::Border;
use decode::Decoded;
use homography::Homography;
use sample::Frame;

/// Border scores (see [`border::Border::score`]) below which a quad is not refined, and not decoded. The 1 % quantile of
/// true tags lies above 2.2 even at ten grey levels of contrast; three quarters of the quads of natural pictures stay below.
const REFINE_SCORE: f32 = 1.5;
const DECODE_SCORE: f32 = 2.0;

/// What a quad's identification needs besides the quad.
pub(crate) struct Scene<'a> {
    pub(crate) view: &'a LumaView<'a>,
    pub(crate) readers: &'a [Reader],
    pub(crate) settings: &'a Settings,
}

/// Appends a detection for every quad that is a tag and resolves overlaps. `cells` is scratch.
pub(crate) fn identify(
    level: Level,
    scene: &Scene,
    quads: &[Quad],
    cells: &mut Vec<f32>,
    detections: &mut Vec<Detection>,
) {
    detections.clear();
    level.run(IdentifyAll { scene, quads, cells, detections: &mut *detections });
    overlap::keep_the_better(scene.readers, detections);
}

struct IdentifyAll<'a, 's> {
    scene: &'a Scene<'s>,
    quads: &'a [Quad],
    cells: &'a mut Vec<f32>,
    detections: &'a mut Vec<Detection>,
}

impl Kernel for IdentifyAll<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { scene, quads, cells, detections } = self;
        let frame = Frame::new(scene.view);
        for quad in quads {
            for reader in scene.readers.iter().filter(|reader| reader.border == quad.border) {
                if let Some(read) = read_quad(&frame, scene.settings, reader, quad, cells) {
                    detections.push(detection(scene, reader, &read));
                }
            }
        }
    }
}

/// A quad that was read as a tag.
struct Read {
    corners: [[f64; 2]; 4],
    decoded: Decoded,
    border: Border,
}

/// Reads a quad as a tag of one family: once with its corners as they are and once refined. Decoding before refining finds
/// tags whose refinement goes astray; refining before decoding finds those whose corners were cut off.
#[inline(always)]
fn read_quad(
    frame: &Frame,
    settings: &Settings,
    reader: &Reader,
    quad: &Quad,
    cells: &mut Vec<f32>,
) -> Option<Read> {
    let border = border::measure(frame, reader, &quad.corners)?;
    if border.score < REFINE_SCORE {
        return None;
    }
    let raw = read(frame, settings, reader, quad.corners, border, cells);
    if !settings.refine {
        return raw;
    }
    let Some(corners) = refine::refine(frame, reader, &quad.corners, settings.decimation.factor()) else {
        return raw;
    };
    let refined = border::measure(frame, reader, &corners)
        .and_then(|border| read(frame, settings, reader, corners, border, cells));
    match (raw, refined) {
        // Unrefined corners may give the better code, never the better corners.
        (Some(raw), Some(refined)) if raw.decoded.hamming < refined.decoded.hamming => {
            Some(Read { corners, ..raw })
        }
        (Some(raw), None) => Some(Read { corners, ..raw }),
        (_, refined) => refined,
    }
}

#[inline(always)]
fn read(
    frame: &Frame,
    settings: &Settings,
    reader: &Reader,
    corners: [[f64; 2]; 4],
    border: Border,
    cells: &mut Vec<f32>,
) -> Option<Read> {
    if border.score < DECODE_SCORE {
        return None;
    }
    let homography = Homography::from_square(&corners, reader.width)?;
    let decoded = decode::decode(frame, reader, &homography, &border, settings.sharpening, cells)?;
    (decoded.margin >= settings.min_margin).then_some(Read { corners, decoded, border })
}

/// The detection as it is reported: corners turned with the tag.
fn detection(scene: &Scene, reader: &Reader, read: &Read) -> Detection {
    let Decoded { id, hamming, rotation, margin, relative_margin } = read.decoded;
    // `rotation` quarter turns counter-clockwise make the picture upright, so the upright tag's top-left corner is that
    // many corners further clockwise; reported are bottom-left, bottom-right, top-right, top-left.
    let corners: [[f64; 2]; 4] = std::array::from_fn(|k| read.corners[(3 - k + rotation as usize) % 4]);
    let homography = Homography::of_tag(&corners);
    Detection {
        family: reader.family,
        id,
        hamming,
        margin,
        relative_margin,
        center: homography.project([0.0, 0.0]),
        corners,
        homography: homography.to_array(),
        flags: flags(scene, reader, read),
    }
}

/// Fewer grey levels than this between black and white are called dim.
const DIM_CONTRAST: f32 = 20.0;
/// Fewer pixels a cell than this are called small.
const SMALL_CELL: f64 = 2.0;

fn flags(scene: &Scene, reader: &Reader, read: &Read) -> Flags {
    let (width, height) = (scene.view.width() as f64, scene.view.height() as f64);
    let near_rim = |[x, y]: &[f64; 2]| *x < 1.0 || *y < 1.0 || *x > width - 1.0 || *y > height - 1.0;
    let shortest = (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (read.corners[k], read.corners[(k + 1) % 4]);
            (bx - ax).hypot(by - ay)
        })
        .fold(f64::MAX, f64::min);
    let set = |condition: bool, flag: Flags| if condition { flag.0 } else { 0 };
    Flags(
        set(read.corners.iter().any(near_rim), Flags::TOUCHES_EDGE)
            | set(shortest < SMALL_CELL * reader.width, Flags::SMALL)
            | set(read.border.contrast < DIM_CONTRAST, Flags::DIM)
            | set(read.border.is_saturated(), Flags::SATURATED),
    )
}
