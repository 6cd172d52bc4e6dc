//! What the model says about pixels, and how that changes with each parameter.

use nalgebra::Matrix3;

use super::super::border::Border;
use super::super::homography::Homography;
use super::blur::normal;
use super::patch::Patch;
use super::pattern::Pattern;
use super::pixels::{BLOCK, Block, Lanes};
use super::solve::{PARAMETERS, Rows};

/// Blur that is assumed before anything is measured: optics, sensor and demosaicing, pixels.
pub(super) const EXPECTED_SIGMA: f32 = 0.75;
/// Limits of the blur's logarithm.
const LOG_SIGMA: (f32, f32) = (-1.05, 1.25);
/// The largest move of the map's offsets in one step, cells.
const LONGEST_STEP: f64 = 0.5;
/// The largest change of the blur's logarithm in one step.
const LONGEST_LOG_STEP: f32 = 0.5;

/// Places of the parameters: map from patch to cells, offset plane, gain plane, blur along u and v, bloom.
pub(super) const MAP: usize = 0;
pub(super) const OFFSET: usize = 8;
pub(super) const GAIN: usize = 11;
pub(super) const LOG_BLUR: usize = 14;
pub(super) const BLOOM: usize = 16;

/// All parameters of the model. The map's numbers are kept in f64, since corners are wanted to a thousandth of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameters {
    map: [f64; 8],
    grey: [f32; 6],
    pub(super) log_sigma: [f32; 2],
    pub(super) bloom: f32,
}

impl Parameters {
    /// From the map of refined corners (frame pixels to cells) and the levels that the border shows.
    pub(super) fn new(to_cells: &Homography, patch: &Patch, border: &Border) -> Self {
        let [x, y] = patch.middle;
        let to_frame = Matrix3::new(patch.scale, 0.0, x, 0.0, patch.scale, y, 0.0, 0.0, 1.0);
        let map = to_cells.after(&to_frame).to_array();
        let black = border.black_level();
        Self {
            map: std::array::from_fn(|i| map[i]),
            grey: [black, 0.0, 0.0, border.contrast, 0.0, 0.0],
            log_sigma: [EXPECTED_SIGMA.ln(); 2],
            bloom: 0.0,
        }
    }

    /// White minus black at the tag's middle.
    pub(super) fn gain(&self) -> f32 {
        self.grey[3]
    }

    /// The map from cells to patch units.
    pub(super) fn to_homography(self) -> Option<Homography> {
        let m = self.map;
        Homography::from_rows([m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], 1.0]).inverse()
    }

    /// Goes a step, shortened where it would leave the range in which the model is linear.
    pub(super) fn step(&mut self, step: &[f64; PARAMETERS]) {
        let longest = step[MAP + 2].abs().max(step[MAP + 5].abs());
        let share = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        for (value, change) in self.map.iter_mut().zip(&step[MAP..OFFSET]) {
            *value += share * change;
        }
        let change = |place: usize| (share * step[place]) as f32;
        for (i, value) in self.grey.iter_mut().enumerate() {
            *value += change(OFFSET + i);
        }
        for (i, value) in self.log_sigma.iter_mut().enumerate() {
            let change = change(LOG_BLUR + i).clamp(-LONGEST_LOG_STEP, LONGEST_LOG_STEP);
            *value = (*value + change).clamp(LOG_SIGMA.0, LOG_SIGMA.1);
        }
        self.bloom += change(BLOOM);
    }
}

/// The model with parameters in force.
pub(super) struct Model {
    margin: f32,
    map: [f32; 8],
    grey: [f32; 6],
    /// Blur in units of the patch, along u and v.
    sigma: [f32; 2],
    bloom: f32,
    per_unit: f32,
}

/// Where pixels lie in cells, and how fast that changes.
pub(super) struct Places {
    /// Counted as the pattern does.
    pub(super) u: Lanes,
    pub(super) v: Lanes,
    /// One over the pixel's distance from the horizon.
    depth: Lanes,
    pub(super) u_by: [Lanes; 2],
    pub(super) v_by: [Lanes; 2],
}

/// The blurred step at each line between the cells of a window, along one axis, with its derivatives by the pixel's place
/// and by the blur's logarithm. Line `k` lies between cells `k - 1` and `k`.
struct Steps<const WINDOW: usize> {
    share: [Lanes; WINDOW],
    by_place: [Lanes; WINDOW],
    by_blur: [Lanes; WINDOW],
}

/// The blurred pattern with its derivatives.
struct Blurred {
    value: Lanes,
    by_u: Lanes,
    by_v: Lanes,
    by_blur_u: Lanes,
    by_blur_v: Lanes,
}

const ZERO: Lanes = [0.0; BLOCK];

impl Model {
    pub(super) fn new(pattern: &Pattern, parameters: &Parameters, scale: f64) -> Self {
        Self {
            margin: pattern.margin() as f32,
            map: parameters.map.map(|v| v as f32),
            grey: parameters.grey,
            sigma: parameters.log_sigma.map(|log| log.exp() / scale as f32),
            bloom: parameters.bloom,
            per_unit: 1.0 / scale as f32,
        }
    }

    /// Residuals and derivatives of a block of pixels whose windows have `WINDOW` cells along an axis.
    #[inline(always)]
    pub(super) fn rows<const WINDOW: usize>(&self, block: &Block, rows: &mut Rows) {
        let places = self.places(&block.x, &block.y);
        let along_u = self.steps::<WINDOW>(&places.u, &block.first_u, &places.u_by, self.sigma[0]);
        let along_v = self.steps::<WINDOW>(&places.v, &block.first_v, &places.v_by, self.sigma[1]);
        let blurred = blurred::<WINDOW>(block, &along_u, &along_v);
        self.derive(block, &places, &blurred, rows);
    }

    #[inline(always)]
    pub(super) fn places(&self, x: &Lanes, y: &Lanes) -> Places {
        let h = &self.map;
        let mut p = Places { u: ZERO, v: ZERO, depth: ZERO, u_by: [ZERO; 2], v_by: [ZERO; 2] };
        for l in 0..BLOCK {
            let (x, y) = (x[l], y[l]);
            let depth = 1.0 / (h[6] * x + h[7] * y + 1.0);
            let u = (h[0] * x + h[1] * y + h[2]) * depth;
            let v = (h[3] * x + h[4] * y + h[5]) * depth;
            p.u[l] = u + self.margin;
            p.v[l] = v + self.margin;
            p.depth[l] = depth;
            p.u_by[0][l] = (h[0] - u * h[6]) * depth;
            p.u_by[1][l] = (h[1] - u * h[7]) * depth;
            p.v_by[0][l] = (h[3] - v * h[6]) * depth;
            p.v_by[1][l] = (h[4] - v * h[7]) * depth;
        }
        p
    }

    /// `by` is how fast `place` changes in the patch, `sigma` the blur there.
    #[inline(always)]
    fn steps<const WINDOW: usize>(
        &self,
        place: &Lanes,
        first: &Lanes,
        by: &[Lanes; 2],
        sigma: f32,
    ) -> Steps<WINDOW> {
        let mut steps = Steps { share: [ZERO; WINDOW], by_place: [ZERO; WINDOW], by_blur: [ZERO; WINDOW] };
        let (mut within, mut inverse) = (ZERO, ZERO);
        for l in 0..BLOCK {
            within[l] = place[l] - first[l];
            inverse[l] = 1.0 / (sigma * (by[0][l] * by[0][l] + by[1][l] * by[1][l]).sqrt());
        }
        for k in 1..WINDOW {
            for l in 0..BLOCK {
                let z = (within[l] - k as f32) * inverse[l];
                let (share, density) = normal(z);
                steps.share[k][l] = share;
                steps.by_place[k][l] = density * inverse[l];
                steps.by_blur[k][l] = -z * density;
            }
        }
        steps
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn derive(&self, block: &Block, p: &Places, t: &Blurred, rows: &mut Rows) {
        let g = &self.grey;
        for l in 0..BLOCK {
            let (x, y, depth) = (block.x[l], block.y[l], p.depth[l]);
            let by_x = t.by_u[l] * p.u_by[0][l] + t.by_v[l] * p.v_by[0][l];
            let by_y = t.by_u[l] * p.u_by[1][l] + t.by_v[l] * p.v_by[1][l];
            let slope = (by_x * by_x + by_y * by_y).sqrt() * self.per_unit;
            let gain = g[3] + g[4] * x + g[5] * y;
            let predicted = g[0] + g[1] * x + g[2] * y + gain * (t.value[l] + self.bloom * slope);
            let (by_u, by_v) = (gain * t.by_u[l] * depth, gain * t.by_v[l] * depth);
            let by_depth = -(by_u * (p.u[l] - self.margin) + by_v * (p.v[l] - self.margin));
            rows[MAP][l] = by_u * x;
            rows[MAP + 1][l] = by_u * y;
            rows[MAP + 2][l] = by_u;
            rows[MAP + 3][l] = by_v * x;
            rows[MAP + 4][l] = by_v * y;
            rows[MAP + 5][l] = by_v;
            rows[MAP + 6][l] = by_depth * x;
            rows[MAP + 7][l] = by_depth * y;
            rows[OFFSET][l] = 1.0;
            rows[OFFSET + 1][l] = x;
            rows[OFFSET + 2][l] = y;
            rows[GAIN][l] = t.value[l];
            rows[GAIN + 1][l] = t.value[l] * x;
            rows[GAIN + 2][l] = t.value[l] * y;
            rows[LOG_BLUR][l] = gain * t.by_blur_u[l];
            rows[LOG_BLUR + 1][l] = gain * t.by_blur_v[l];
            rows[BLOOM][l] = gain * slope;
            rows[PARAMETERS][l] = block.grey[l] - predicted;
        }
    }
}

/// The pattern under the blur. Cells outside of the windows have the colours of the outermost ones inside.
#[inline(always)]
fn blurred<const WINDOW: usize>(block: &Block, along_u: &Steps<WINDOW>, along_v: &Steps<WINDOW>) -> Blurred {
    let mut t = Blurred { value: ZERO, by_u: ZERO, by_v: ZERO, by_blur_u: ZERO, by_blur_v: ZERO };
    let mut before = [ZERO; 3];
    for j in 0..WINDOW {
        let row = blurred_row::<WINDOW>(&block.rows[j], along_u);
        if j == 0 {
            (t.value, t.by_u, t.by_blur_u) = (row[0], row[1], row[2]);
        } else {
            let (share, by_place, by_blur) = (&along_v.share[j], &along_v.by_place[j], &along_v.by_blur[j]);
            for l in 0..BLOCK {
                let change = row[0][l] - before[0][l];
                t.value[l] += change * share[l];
                t.by_v[l] += change * by_place[l];
                t.by_blur_v[l] += change * by_blur[l];
                t.by_u[l] += (row[1][l] - before[1][l]) * share[l];
                t.by_blur_u[l] += (row[2][l] - before[2][l]) * share[l];
            }
        }
        before = row;
    }
    t
}

/// One row of cells under the blur along it, with the derivatives by place and by the blur's logarithm.
#[inline(always)]
fn blurred_row<const WINDOW: usize>(words: &[u32; BLOCK], along: &Steps<WINDOW>) -> [Lanes; 3] {
    // Cells' colours are given as twice their brightness.
    let colour = |word: u32, k: usize| (word >> (2 * k) & 3) as i32;
    let [mut value, mut by_place, mut by_blur] = [ZERO; 3];
    for l in 0..BLOCK {
        value[l] = 0.5 * colour(words[l], 0) as f32;
    }
    for k in 1..WINDOW {
        for l in 0..BLOCK {
            let change = 0.5 * (colour(words[l], k) - colour(words[l], k - 1)) as f32;
            value[l] += change * along.share[k][l];
            by_place[l] += change * along.by_place[k][l];
            by_blur[l] += change * along.by_blur[k][l];
        }
    }
    [value, by_place, by_blur]
}
