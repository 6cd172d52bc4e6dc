//! Template alignment: the whole decoded tag is laid over its pixels.
//!
//! Four edges see only the border. Once the code is known, every edge between a black and a white cell is known too, and
//! the homography that explains all of them at once is several times more accurate and free of the bias that blur, gamma
//! or spread ink give to single edges. Each pixel is modelled as
//!
//! ```text
//! offset(x, y) + gain(x, y) * (T + curve * T (1 - T)),     T = grown cell pattern, blurred by a Gaussian, at the pixel's place
//! ```
//!
//! with eight parameters of the map from pixels to cells, a plane each for offset and gain, two blur widths, and the two
//! ways in which white or black take more room than they have on paper: before the blur every white cell grows by a number
//! of pixels on all sides ("bloom"; below zero it is ink that spreads), after it the sensor's curve lifts what lies between
//! black and white (gamma, clipping). At a single edge both look the same, and where cells are large it does not matter
//! which it is; between edges a cell or two apart they differ. Gauss-Newton with a robust weight needs one or two steps from
//! refined corners, up to four where blur or bloom are far from what is expected.
//!
//! ```text
//! pattern ─▶ edges ─▶ pixels ─▶ ┌ model, window, blur ─▶ solve ┐
//! colours    which pixels       └ what they should be    step ◀┘
//! ```
//!
//! Pixels lie side by side in blocks and every step of the arithmetic is a loop over a block, which the compiler makes
//! vectors of; sums are taken in the same order at every level of instructions. An alignment takes 60 to 100
//! microseconds in plain light, whatever the size of the tag, up to 300 where all steps are needed.
//!
//! What it gives on rendered tags: `bench/record/corners.md`.

mod blur;
mod edges;
mod model;
mod patch;
mod pattern;
mod pixels;
mod solve;
mod window;

use super::border::Border;
use super::homography::Homography;
use super::reader::Reader;
use super::sample::Frame;
use model::{Model, Parameters};
use patch::Patch;
use pattern::{MOST_CELLS, Pattern};
use pixels::{Laid, Pixels, ZERO};
use solve::{NormalEquations, PARAMETERS};

/// Most Gauss-Newton steps.
const STEPS: usize = 4;
/// A step that moves no corner further than this many pixels, and hardly changes blur and bloom, is the last one.
const SETTLED: f64 = 0.05;
/// Fewest pixels that can carry eighteen parameters.
const LEAST_PIXELS: usize = 40;
/// Least gain, grey levels: below this there is no tag to align.
const LEAST_GAIN: f32 = 2.0;
/// A corner that moves further than these many pixels, and further than this many cells, has gone astray.
const FARTHEST_MOVE: (f64, f64) = (2.0, 1.0);
/// Reach that windows of cells must have around every pixel, pixels: four standard deviations of a sharp picture's blur.
const WINDOW_REACH: f64 = 3.0;

/// Buffers of the alignment.
#[derive(Default)]
pub(crate) struct Align {
    pattern: Pattern,
    pixels: Pixels,
}

impl Align {
    /// Makes room for any tag of these families.
    pub(crate) fn reserve(&mut self, readers: &[Reader]) {
        let widest = readers.iter().map(|reader| reader.grid_width).max().unwrap_or(0);
        self.pixels.reserve(self.pattern.reserve(widest));
    }

    /// The corners of a tag whose cells have the colours of `code` (as read, not turned upright), from refined ones.
    /// `None` when it has too few pixels or the fit goes astray.
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
        let window = window_size(&to_cells, corners);
        self.pattern.paint(reader, code);
        let parameters = Parameters::new(&to_cells, &patch, border);
        let model = Model::new(&self.pattern, &parameters, patch.scale);
        let laid = Laid { pattern: &self.pattern, patch: &patch, to_frame: &to_frame, model: &model, window };
        self.pixels.choose(frame, &laid);
        if self.pixels.count() < LEAST_PIXELS {
            return None;
        }
        let aligned = match window {
            2 => self.descend::<2>(parameters, &patch, corners, reader.width)?,
            4 => self.descend::<4>(parameters, &patch, corners, reader.width)?,
            _ => self.descend::<MOST_CELLS>(parameters, &patch, corners, reader.width)?,
        };
        stayed(corners, &aligned, reader.width).then_some(aligned)
    }

    /// The corners after Gauss-Newton steps, with windows of `WINDOW` cells along an axis, of a tag of that many cells. `None`
    /// when the numbers run away or contrast vanishes.
    #[inline(always)]
    fn descend<const WINDOW: usize>(
        &self,
        mut parameters: Parameters,
        patch: &Patch,
        corners: &[[f64; 2]; 4],
        width: f64,
    ) -> Option<[[f64; 2]; 4]> {
        let mut aligned = *corners;
        let mut rms = f32::MAX;
        for _ in 0..STEPS {
            let equations = self.equations::<WINDOW>(&parameters, patch, rms);
            rms = equations.rms()?;
            let before = (parameters, aligned);
            parameters.step(&equations.solve(&parameters, rms)?);
            aligned = patch.corners_of(&parameters.to_homography()?, width);
            if farthest_move(&before.1, &aligned) < SETTLED && parameters.look_like(&before.0) {
                break;
            }
        }
        (parameters.gain() >= LEAST_GAIN).then_some(aligned)
    }

    /// The equations of a step; `rms` is the root mean square residual of the step before.
    #[inline(always)]
    fn equations<const WINDOW: usize>(
        &self,
        parameters: &Parameters,
        patch: &Patch,
        rms: f32,
    ) -> NormalEquations {
        let model = Model::new(&self.pattern, parameters, patch.scale);
        let mut rows = [ZERO; PARAMETERS + 1];
        let mut equations = NormalEquations::default();
        for block in self.pixels.blocks() {
            model.rows::<WINDOW>(block, &mut rows);
            equations.add(&rows, &block.weight, rms);
        }
        equations
    }
}

/// Cells along an axis that the blur can reach from a pixel, for the smallest cells of the tag: 2, 4 or `MOST_CELLS`.
#[inline(always)]
fn window_size(to_cells: &Homography, corners: &[[f64; 2]; 4]) -> usize {
    let mut cells_a_pixel: f64 = 0.0;
    for corner in corners {
        let [u, v] = to_cells.stretch(*corner);
        cells_a_pixel = cells_a_pixel.max(u).max(v);
    }
    // A window reaches at least half a cell less than half its width on either side.
    let cells = 2.0 * WINDOW_REACH * cells_a_pixel + 1.0;
    match cells {
        ..=2.0 => 2,
        ..=4.0 => 4,
        _ => MOST_CELLS,
    }
}

/// The largest distance between corners before and after.
fn farthest_move(before: &[[f64; 2]; 4], after: &[[f64; 2]; 4]) -> f64 {
    (0..4).map(|k| (before[k][0] - after[k][0]).hypot(before[k][1] - after[k][1])).fold(0.0, f64::max)
}

fn stayed(before: &[[f64; 2]; 4], after: &[[f64; 2]; 4], width: f64) -> bool {
    let side = |k: usize| {
        let ([ax, ay], [bx, by]) = (before[k], before[(k + 1) % 4]);
        (ax - bx).hypot(ay - by)
    };
    let sides: f64 = (0..4).map(side).sum();
    farthest_move(before, after) <= FARTHEST_MOVE.0.max(FARTHEST_MOVE.1 * sides / (4.0 * width))
}
