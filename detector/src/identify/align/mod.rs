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
//! pattern ─▶ edges ─▶ profiles ─▶ ┌ model, blur               ─▶ solve ┐ large cells in a sharp picture
//! colours    which    pixels   ─▶ └ model, window, grown, blur    step ◀┘ all others
//! ```
//!
//! Pixels lie side by side in blocks and every step of the arithmetic is a loop over a block, which the compiler makes
//! vectors of; sums are taken in the same order at every level of instructions.
//!
//! What it gives on rendered tags: `bench/record/corners.md`.

mod blur;
mod descent;
mod edges;
mod grown;
mod model;
mod patch;
mod pattern;
mod pixels;
mod profiles;
mod solve;
mod window;

use super::border::Border;
use super::homography::Homography;
use super::reader::Reader;
use super::sample::Frame;
use crate::simd::Kernel;
use descent::{Fit, Residuals, farthest_move};
use edges::Stretch;
use model::{Model, Parameters};
use patch::Patch;
use pattern::{MOST_CELLS, Pattern};
use pixels::{Laid, Pixels, ZERO};
use profiles::Profiles;
use solve::{NormalEquations, PARAMETERS, Rows};

/// Fewest pixels that can carry eighteen parameters.
const LEAST_PIXELS: usize = 40;
/// Least gain, grey levels: below this there is no tag to align.
const LEAST_GAIN: f32 = 2.0;
/// A corner that moves further than these many pixels, and further than this many cells, has gone astray.
const FARTHEST_MOVE: (f64, f64) = (2.0, 1.0);
/// Standard deviations of the blur that windows of cells must reach around every pixel.
const WINDOW_DEVIATIONS: f32 = 3.3;

/// Buffers of the alignment.
#[derive(Default)]
pub(crate) struct Align {
    pattern: Pattern,
    stretches: Vec<Stretch>,
    profiles: Profiles,
    pixels: Pixels,
    equations: NormalEquations,
}

impl Align {
    /// Makes room for any tag of these families.
    pub(crate) fn reserve(&mut self, readers: &[Reader]) {
        let widest = readers.iter().map(|reader| reader.grid_width).max().unwrap_or(0);
        let width = self.pattern.reserve(widest);
        // Two lines for each column and row at most, and a stretch for each of their places.
        self.stretches.reserve((2 * width * width).saturating_sub(self.stretches.len()));
        self.profiles.reserve();
        self.pixels.reserve();
    }

    /// The corners of a tag whose cells have the colours of `code` (as read, not turned upright), from refined ones.
    /// `None` when it has too few pixels or the fit goes astray.
    pub(crate) fn align(
        &mut self,
        frame: &Frame,
        reader: &Reader,
        code: u64,
        corners: &[[f64; 2]; 4],
        border: &Border,
    ) -> Option<[[f64; 2]; 4]> {
        frame.level().run(Alignment { align: self, frame, reader, code, corners, border })
    }

    /// By profiles where they show what they are taken for, else by windows.
    #[inline(always)]
    fn descend(&mut self, frame: &Frame, start: Fit, cells_a_pixel: f64) -> Option<Fit> {
        let from = match self.by_profiles(frame, &start, cells_a_pixel) {
            Some(end) if profiles::are_apart(&end.parameters, cells_a_pixel) => return Some(end),
            // The blur that was found is of use all the same.
            Some(end) if stayed(&start, &end) => end,
            _ => start,
        };
        self.by_windows(frame, &from, cells_a_pixel)
    }

    /// By profiles across single edges; `None` when there are too few of them.
    #[inline(always)]
    fn by_profiles(&mut self, frame: &Frame, start: &Fit, cells_a_pixel: f64) -> Option<Fit> {
        if cells_a_pixel > profiles::MOST_CELLS_A_PIXEL {
            return None;
        }
        self.profiles.choose(frame, &start.patch, &self.stretches, cells_a_pixel);
        let Self { profiles, pattern, equations, .. } = self;
        if profiles.count() < profiles::LEAST {
            return None;
        }
        start.descend(frame.level(), &ByProfiles { pattern, profiles, cells_a_pixel }, equations)
    }

    /// By windows of cells around each pixel; `None` when there are too few pixels.
    #[inline(always)]
    fn by_windows(&mut self, frame: &Frame, start: &Fit, cells_a_pixel: f64) -> Option<Fit> {
        match window_size(&start.parameters, cells_a_pixel) {
            2 => self.by_windows_of::<2>(frame, start),
            3 => self.by_windows_of::<3>(frame, start),
            4 => self.by_windows_of::<4>(frame, start),
            _ => self.by_windows_of::<MOST_CELLS>(frame, start),
        }
    }

    #[inline(always)]
    fn by_windows_of<const WINDOW: usize>(&mut self, frame: &Frame, start: &Fit) -> Option<Fit> {
        let Self { pixels, pattern, stretches, equations, .. } = self;
        let model = Model::new(pattern, &start.parameters, start.patch.scale);
        pixels.choose::<WINDOW>(frame, &Laid { pattern, patch: &start.patch, model: &model }, stretches);
        if pixels.count() < LEAST_PIXELS {
            return None;
        }
        start.descend(frame.level(), &ByWindows::<WINDOW> { pattern, pixels }, equations)
    }
}

/// A function of its own at every level: code that is read from the caches once serves all who align.
struct Alignment<'a> {
    align: &'a mut Align,
    frame: &'a Frame<'a>,
    reader: &'a Reader,
    code: u64,
    corners: &'a [[f64; 2]; 4],
    border: &'a Border,
}

impl Kernel for Alignment<'_> {
    type Output = Option<[[f64; 2]; 4]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { align, frame, reader, code, corners, border } = self;
        let patch = Patch::around(corners);
        let to_frame = Homography::from_square(corners, reader.width)?;
        let to_cells = to_frame.inverse()?;
        align.pattern.paint(reader, code);
        edges::find(&align.pattern, &to_frame, &mut align.stretches);
        let parameters = Parameters::new(&to_cells, &patch, border);
        let start = Fit { parameters, patch, corners: *corners, width: reader.width };
        let end = align.descend(frame, start, cells_a_pixel(&to_cells, corners))?;
        (end.parameters.gain() >= LEAST_GAIN && stayed(&start, &end)).then_some(end.corners)
    }
}

struct ByProfiles<'a> {
    pattern: &'a Pattern,
    profiles: &'a Profiles,
    cells_a_pixel: f64,
}

impl Residuals for ByProfiles<'_> {
    // Of products of columns the compiler would gather vectors from places far apart: two and a half times the time.
    const ARE_WIDE: bool = false;

    #[inline(always)]
    fn equations(&self, at: &Parameters, patch: &Patch, rms: f32, equations: &mut NormalEquations) {
        let model = Model::new(self.pattern, at, patch.scale);
        for block in self.profiles.blocks() {
            model.add_profiles(block, rms, equations);
        }
    }

    #[inline(always)]
    fn hold(&self, at: &Parameters) -> bool {
        profiles::are_apart(at, self.cells_a_pixel)
    }
}

/// Windows have `WINDOW` cells along an axis.
struct ByWindows<'a, const WINDOW: usize> {
    pattern: &'a Pattern,
    pixels: &'a Pixels,
}

impl<const WINDOW: usize> Residuals for ByWindows<'_, WINDOW> {
    const ARE_WIDE: bool = true;

    #[inline(always)]
    fn equations(&self, at: &Parameters, patch: &Patch, rms: f32, equations: &mut NormalEquations) {
        let model = Model::new(self.pattern, at, patch.scale);
        let mut rows = Rows([ZERO; PARAMETERS + 1]);
        for block in self.pixels.blocks() {
            model.rows::<WINDOW>(block, &mut rows);
            equations.add(&rows, &block.weight, rms);
        }
    }
}

/// Cells to a pixel where they are smallest.
#[inline(always)]
fn cells_a_pixel(to_cells: &Homography, corners: &[[f64; 2]; 4]) -> f64 {
    let mut most: f64 = 0.0;
    for corner in corners {
        let [u, v] = to_cells.stretch(*corner);
        most = most.max(u).max(v);
    }
    most
}

/// Cells along an axis that the blur can reach from a pixel where cells are smallest, at most `MOST_CELLS`.
#[inline(always)]
fn window_size(parameters: &Parameters, cells_a_pixel: f64) -> usize {
    let reach = f64::from(parameters.reach(WINDOW_DEVIATIONS)) * cells_a_pixel;
    // A window reaches at least half a cell less than half its width on either side.
    ((2.0 * reach + 1.0).ceil() as usize).clamp(2, MOST_CELLS)
}

/// Whether no corner has gone astray.
fn stayed(start: &Fit, end: &Fit) -> bool {
    let corners = &start.corners;
    let side = |k: usize| {
        let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
        (ax - bx).hypot(ay - by)
    };
    let sides: f64 = (0..4).map(side).sum();
    let cell = sides / (4.0 * start.width);
    farthest_move(corners, &end.corners) <= FARTHEST_MOVE.0.max(FARTHEST_MOVE.1 * cell)
}
