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
mod model;
mod pixels;
mod solve;

pub(crate) use blur::StepTable;

use super::border::Border;
use super::homography::Homography;
use super::reader::Reader;
use super::sample::Frame;
use model::{Model, Parameters};
use pixels::{Patch, Pixel};
use solve::NormalEquations;

/// Gauss-Newton steps.
const STEPS: usize = 3;
/// Fewest pixels that can carry seventeen parameters.
const LEAST_PIXELS: usize = 40;
/// Least gain, grey levels: below this there is no tag to align.
const LEAST_GAIN: f32 = 2.0;
/// A corner that moves further than these many pixels, and further than this many cells, has gone astray.
const FARTHEST_MOVE: (f64, f64) = (2.0, 1.0);

/// Buffers of the alignment.
#[derive(Default)]
pub(crate) struct Align {
    table: StepTable,
    pixels: Vec<Pixel>,
    pattern: Vec<f32>,
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
        self.paint(reader, code);
        let patch = Patch::around(corners);
        let start = Homography::from_square(corners, reader.width)?.inverse()?;
        let mut parameters = Parameters::new(&start, &patch, border);
        pixels::choose(frame, reader, &self.pattern, &patch, &start, &mut self.pixels);
        if self.pixels.len() < LEAST_PIXELS {
            return None;
        }
        let mut rms = f32::MAX;
        for step in 0..=STEPS {
            let model = Model::new(reader, &self.pattern, &self.table, &parameters, patch.scale);
            let mut equations = NormalEquations::default();
            for pixel in &self.pixels {
                equations.add(&model.row(pixel), rms);
            }
            rms = equations.rms()?;
            if step < STEPS {
                parameters.step(&equations.solve(&parameters, rms)?);
            }
        }
        if parameters.gain() < LEAST_GAIN {
            return None;
        }
        let aligned = patch.corners_of(&parameters.to_homography()?, reader.width);
        stayed(corners, &aligned, reader.width).then_some(aligned)
    }

    /// The colours of all cells: 0 black, 1 white, NaN unknown.
    #[inline(always)]
    fn paint(&mut self, reader: &Reader, code: u64) {
        self.pattern.clear();
        self.pattern.resize(reader.grid_width * reader.grid_width, f32::NAN);
        for cell in &reader.known {
            self.pattern[cell.place] = f32::from(u8::from(cell.white));
        }
        for (i, cell) in reader.data.iter().enumerate() {
            let bit = code >> (reader.data.len() - 1 - i) & 1;
            self.pattern[cell.place] = bit as f32;
        }
    }
}

fn stayed(before: &[[f64; 2]; 4], after: &[[f64; 2]; 4], width: f64) -> bool {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let sides: f64 = (0..4).map(|k| distance(before[k], before[(k + 1) % 4])).sum();
    let farthest = FARTHEST_MOVE.0.max(FARTHEST_MOVE.1 * sides / (4.0 * width));
    (0..4).all(|k| distance(before[k], after[k]) <= farthest)
}
