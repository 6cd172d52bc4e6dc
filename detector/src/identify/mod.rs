//! Phase 4: which quads are tags, and which.
//!
//! ```text
//! quad ─▶ border gate ─▶ decode ─▶ refine ─▶ border gate ─▶ decode ─▶ the better code ─▶ align ─▶ overlaps resolved
//!         most end here                                              refined corners     the whole tag
//! ```

mod align;
mod border;
mod decode;
mod homography;
mod overlap;
mod read;
mod reader;
mod refine;
mod sample;

pub(crate) use reader::Reader;

use crate::detection::{Detection, Flags};
use crate::fit::Quad;
use crate::numbered::Numbered;
use crate::settings::{Refinement, Settings};
use crate::simd::{Kernel, Level};
use crate::threads::Threads;
use crate::view::LumaView;
use align::Align;
use homography::Homography;
use read::{Attempt, Reading, Tag};
use sample::Frame;

/// What a quad's identification needs besides the quad.
pub(crate) struct Scene<'a> {
    pub(crate) view: &'a LumaView<'a>,
    pub(crate) readers: &'a [Reader],
    pub(crate) settings: &'a Settings,
}

/// Buffers of the identification.
pub(crate) struct Identify {
    /// One for each thread.
    scratches: Vec<Scratch>,
    found: Numbered<Detection>,
}

/// What a thread needs for one quad after the other.
#[derive(Default)]
// In cache lines of its own: its neighbours in a list belong to other threads.
#[repr(align(128))]
struct Scratch {
    cells: Vec<f32>,
    /// Families that may still read a quad, by their place.
    unread: Vec<usize>,
    align: Align,
}

impl Identify {
    /// Buffers for so many threads.
    pub(crate) fn new(threads: usize, readers: &[Reader], refinement: Refinement) -> Self {
        let mut scratches: Vec<Scratch> = (0..threads).map(|_| Scratch::default()).collect();
        if threads > 1 {
            // Who reads which tag is chance, and nobody is to allocate for one later.
            scratches.iter_mut().for_each(|scratch| scratch.reserve(readers, refinement));
        }
        Self { scratches, found: Numbered::default() }
    }
}

impl Scratch {
    /// Makes room for any tag of these families.
    fn reserve(&mut self, readers: &[Reader], refinement: Refinement) {
        let cells = readers.iter().map(|reader| reader.grid_width * reader.grid_width).max().unwrap_or(0);
        self.cells.reserve(cells);
        self.unread.reserve(readers.len());
        if refinement == Refinement::Tag {
            self.align.reserve(readers);
        }
    }
}

/// Fewer quads than this are looked at before another thread is awake.
fn least_to_deal(refinement: Refinement) -> usize {
    match refinement {
        Refinement::None | Refinement::Edges => 16,
        Refinement::Tag => 4,
    }
}

/// Adds a detection of every quad that is a tag to `detections`, which is empty, and resolves overlaps.
pub(crate) fn identify(
    level: Level,
    threads: &mut Threads,
    scene: &Scene,
    quads: &[Quad],
    identify: &mut Identify,
    detections: &mut Vec<Detection>,
) {
    if quads.is_empty() {
        return;
    }
    let Identify { scratches, found } = identify;
    if threads.count() == 1 || quads.len() < least_to_deal(scene.settings.refinement) {
        let found = |_, detection| detections.push(detection);
        level.run(IdentifyAll { level, scene, quads, first: 0, scratch: &mut scratches[0], found });
    } else {
        let length = threads.part_length(quads.len());
        threads.deal(scratches, quads.chunks(length).enumerate(), |scratch, (part, quads)| {
            let found = |number, detection| found.add(number, detection);
            level.run(IdentifyAll { level, scene, quads, first: part * length, scratch, found });
        });
        found.move_to(detections);
    }
    overlap::keep_the_better(scene.readers, detections);
}

/// Hands the detections of some quads to `found`, with the quads' numbers.
struct IdentifyAll<'a, 's, F> {
    level: Level,
    scene: &'a Scene<'s>,
    quads: &'a [Quad],
    /// The number of the first.
    first: usize,
    scratch: &'a mut Scratch,
    found: F,
}

impl<F: FnMut(usize, Detection)> Kernel for IdentifyAll<'_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { level, scene, quads, first, scratch, mut found } = self;
        let frame = Frame::new(level, scene.view);
        let mut attempt = Attempt { frame: &frame, settings: scene.settings, scratch };
        for (i, quad) in quads.iter().enumerate() {
            if let Some(Tag { reader, reading }) = attempt.read_quad(scene.readers, quad) {
                found(first + i, detection(scene, reader, &reading));
            }
        }
    }
}

/// The detection as it is reported: corners turned with the tag.
fn detection(scene: &Scene, reader: &Reader, reading: &Reading) -> Detection {
    let Reading { found, bits, .. } = reading;
    // `found.rotation` quarter turns counter-clockwise make the picture upright, so the upright tag's top-left corner is that
    // many corners further clockwise; reported are bottom-left, bottom-right, top-right, top-left.
    let corners: [[f64; 2]; 4] =
        std::array::from_fn(|k| reading.corners[(3 - k + found.rotation as usize) % 4]);
    let homography = Homography::of_tag(&corners);
    Detection {
        family: reader.family,
        id: found.id,
        hamming: found.hamming,
        margin: bits.margin,
        relative_margin: bits.relative_margin,
        center: homography.project([0.0, 0.0]),
        corners,
        homography: homography.to_array(),
        flags: flags(scene, reader, reading),
    }
}

/// Fewer grey levels than this between black and white are called dim.
const DIM_CONTRAST: f32 = 20.0;
/// Fewer pixels a cell than this are called small.
const SMALL_CELL: f64 = 2.0;

fn flags(scene: &Scene, reader: &Reader, reading: &Reading) -> Flags {
    let (width, height) = (scene.view.width() as f64, scene.view.height() as f64);
    let near_rim = |[x, y]: &[f64; 2]| *x < 1.0 || *y < 1.0 || *x > width - 1.0 || *y > height - 1.0;
    let shortest = (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (reading.corners[k], reading.corners[(k + 1) % 4]);
            (bx - ax).hypot(by - ay)
        })
        .fold(f64::MAX, f64::min);
    let set = |condition: bool, flag: Flags| if condition { flag.0 } else { 0 };
    Flags(
        set(reading.corners.iter().any(near_rim), Flags::TOUCHES_EDGE)
            | set(shortest < SMALL_CELL * reader.width, Flags::SMALL)
            | set(reading.border.contrast < DIM_CONTRAST, Flags::DIM)
            | set(reading.border.is_saturated(), Flags::SATURATED),
    )
}
