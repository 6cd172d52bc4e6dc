//! Template alignment: the whole decoded tag is laid over its pixels.
//!
//! Four edges see only the border. Once the code is known, every edge between a black and a white cell is known too, and
//! the homography that explains all of them at once is several times more accurate and free of the bias that blur, gamma
//! or spread ink give to single edges. Each pixel is modelled as
//!
//! ```text
//! offset(x, y) + gain(x, y) * (T + bloom |grad T|),     T = cell pattern blurred by a Gaussian, at the pixel's place
//! ```
//!
//! with eight parameters of the map from pixels to cells, a plane each for offset and gain, two blur widths and the
//! bloom (how far white has grown). Gauss-Newton with a robust weight needs three steps from refined corners.
//!
//! What it gives on rendered tags: `bench/record/corners.md`.

mod blur;
mod edges;
mod model;
mod patch;
mod pattern;
mod pixels;
mod solve;

use super::border::Border;
use super::homography::Homography;
use super::reader::Reader;
use super::sample::Frame;
use model::{Model, Parameters};
use patch::Patch;
use pattern::Pattern;
use pixels::{BLOCK, Laid, Pixels};
use solve::{NormalEquations, PARAMETERS};

/// Gauss-Newton steps.
const STEPS: usize = 3;
/// Fewest pixels that can carry seventeen parameters.
const LEAST_PIXELS: usize = 40;
/// Least gain, grey levels: below this there is no tag to align.
const LEAST_GAIN: f32 = 2.0;
/// A corner that moves further than these many pixels, and further than this many cells, has gone astray.
const FARTHEST_MOVE: (f64, f64) = (2.0, 1.0);

/// Reach that windows of cells must have around every pixel, pixels: five standard deviations of a sharp picture's blur, and
/// two and a half of a poor one's.
const WINDOW_REACH: f64 = 3.75;

/// Buffers of the alignment.
#[derive(Default)]
pub(crate) struct Align {
    pattern: Pattern,
    pixels: Pixels,
}

impl Align {
    /// The corners of a tag whose cells have the colours of `code` (as read, not turned upright), from refined ones. `None` when it has too few
    /// pixels or the fit goes astray.
    #[inline(always)]
    pub(crate) fn align(
        &mut self,
        frame: &Frame,
        reader: &Reader,
        code: u64,
        corners: &[[f64; 2]; 4],
        border: &Border,
    ) -> Option<[[f64; 2]; 4]> {
        let patch = Patch::around(corners);
        let to_frame = Homography::from_square(corners, reader.width)?;
        let to_cells = to_frame.inverse()?;
        let window = window(&to_cells, corners);
        self.pattern.paint(reader, code);
        let mut parameters = Parameters::new(&to_cells, &patch, border);
        let model = Model::new(&self.pattern, &parameters, patch.scale);
        let laid = Laid { pattern: &self.pattern, patch: &patch, to_frame: &to_frame, model: &model, window };
        self.pixels.choose(frame, &laid);
        if self.pixels.count() < LEAST_PIXELS {
            return None;
        }
        match window {
            2 => self.descend::<2>(&mut parameters, patch.scale)?,
            4 => self.descend::<4>(&mut parameters, patch.scale)?,
            _ => self.descend::<8>(&mut parameters, patch.scale)?,
        }
        if parameters.gain() < LEAST_GAIN {
            return None;
        }
        let aligned = patch.corners_of(&parameters.to_homography()?, reader.width);
        stayed(corners, &aligned, reader.width).then_some(aligned)
    }

    /// The Gauss-Newton steps, with windows of `WINDOW` cells along an axis. `None` when the numbers run away.
    #[inline(always)]
    fn descend<const WINDOW: usize>(&self, parameters: &mut Parameters, scale: f64) -> Option<()> {
        let mut rows = [[0.0; BLOCK]; PARAMETERS + 1];
        let mut rms = f32::MAX;
        for _ in 0..STEPS {
            let model = Model::new(&self.pattern, parameters, scale);
            let mut equations = NormalEquations::default();
            for block in self.pixels.blocks() {
                model.rows::<WINDOW>(block, &mut rows);
                equations.add(&rows, &block.weight, rms);
            }
            rms = equations.rms()?;
            parameters.step(&equations.solve(parameters, rms)?);
        }
        Some(())
    }
}

/// Cells along an axis that the blur can reach from a pixel, for the smallest cells of the tag: 2, 4 or 8.
#[inline(always)]
fn window(to_cells: &Homography, corners: &[[f64; 2]; 4]) -> usize {
    let mut most: f64 = 0.0;
    for corner in corners {
        let [u, v] = to_cells.stretch(*corner);
        most = most.max(u).max(v);
    }
    // Windows reach at least half a cell less than half their width on either side.
    let cells = 2.0 * WINDOW_REACH * most + 1.0;
    if cells <= 2.0 {
        2
    } else if cells <= 4.0 {
        4
    } else {
        8
    }
}

fn stayed(before: &[[f64; 2]; 4], after: &[[f64; 2]; 4], width: f64) -> bool {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let sides: f64 = (0..4).map(|k| distance(before[k], before[(k + 1) % 4])).sum();
    let farthest = FARTHEST_MOVE.0.max(FARTHEST_MOVE.1 * sides / (4.0 * width));
    (0..4).all(|k| distance(before[k], after[k]) <= farthest)
}
