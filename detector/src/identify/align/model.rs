//! What the model says about one pixel, and how that changes with each parameter.

use nalgebra::Matrix3;

use super::super::border::Border;
use super::super::homography::Homography;
use super::super::reader::Reader;
use super::blur::{REACH, StepTable};
use super::pixels::{Patch, Pixel};
use super::solve::{PARAMETERS, Row};

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
pub(super) struct Model<'a> {
    pattern: &'a [f32],
    grid_width: usize,
    margin: f32,
    table: &'a StepTable,
    map: [f32; 8],
    grey: [f32; 6],
    /// Blur in units of the patch, along u and v.
    sigma: [f32; 2],
    bloom: f32,
    per_unit: f32,
}

/// Most cells that the blur can reach along an axis; wider blurs are cut off there.
const MOST_CELLS: usize = 8;

/// The share of each cell along one axis, with its derivatives by place and by the blur's logarithm.
struct Axis {
    first: usize,
    count: usize,
    share: [f32; MOST_CELLS],
    by_place: [f32; MOST_CELLS],
    by_blur: [f32; MOST_CELLS],
}

impl<'a> Model<'a> {
    pub(super) fn new(
        reader: &Reader,
        pattern: &'a [f32],
        table: &'a StepTable,
        parameters: &Parameters,
        scale: f64,
    ) -> Self {
        Self {
            pattern,
            grid_width: reader.grid_width,
            margin: reader.grid_margin() as f32,
            table,
            map: parameters.map.map(|v| v as f32),
            grey: parameters.grey,
            sigma: parameters.log_sigma.map(|log| log.exp() / scale as f32),
            bloom: parameters.bloom,
            per_unit: 1.0 / scale as f32,
        }
    }

    /// Residual and derivatives of one pixel.
    #[inline(always)]
    pub(super) fn row(&self, pixel: &Pixel) -> Row {
        let (x, y, h) = (pixel.x, pixel.y, &self.map);
        let scale = 1.0 / (h[6] * x + h[7] * y + 1.0);
        let u = (h[0] * x + h[1] * y + h[2]) * scale;
        let v = (h[3] * x + h[4] * y + h[5]) * scale;
        let (ux, uy) = ((h[0] - u * h[6]) * scale, (h[1] - u * h[7]) * scale);
        let (vx, vy) = ((h[3] - v * h[6]) * scale, (h[4] - v * h[7]) * scale);
        let along_u = self.axis(u + self.margin, self.sigma[0] * (ux * ux + uy * uy).sqrt());
        let along_v = self.axis(v + self.margin, self.sigma[1] * (vx * vx + vy * vy).sqrt());
        let [t, t_u, t_v, t_blur_u, t_blur_v] = self.blurred(&along_u, &along_v);
        let (tx, ty) = (t_u * ux + t_v * vx, t_u * uy + t_v * vy);
        let slope = (tx * tx + ty * ty).sqrt() * self.per_unit;
        let g = &self.grey;
        let gain = g[3] + g[4] * x + g[5] * y;
        let predicted = g[0] + g[1] * x + g[2] * y + gain * (t + self.bloom * slope);
        let (by_u, by_v) = (gain * t_u * scale, gain * t_v * scale);
        let by_depth = -(by_u * u + by_v * v);
        Row {
            residual: pixel.grey - predicted,
            derivatives: [
                by_u * x,
                by_u * y,
                by_u,
                by_v * x,
                by_v * y,
                by_v,
                by_depth * x,
                by_depth * y,
                1.0,
                x,
                y,
                t,
                t * x,
                t * y,
                gain * t_blur_u,
                gain * t_blur_v,
                gain * slope,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
            ],
        }
    }

    /// How much each cell along an axis contributes at a place (in grid cells) under a blur (in cells).
    #[inline(always)]
    fn axis(&self, place: f32, sigma: f32) -> Axis {
        let last = self.grid_width - 1;
        let first = ((place - REACH * sigma).max(0.0) as usize).min(last);
        let end = ((place + REACH * sigma).max(0.0) as usize).min(last);
        let count = (end - first + 1).min(MOST_CELLS);
        let mut axis = Axis {
            first,
            count,
            share: [0.0; MOST_CELLS],
            by_place: [0.0; MOST_CELLS],
            by_blur: [0.0; MOST_CELLS],
        };
        let inverse = 1.0 / sigma;
        let at = |cell: usize| {
            let z = (cell as f32 - place) * inverse;
            let (integral, density) = self.table.at(z);
            (z, integral, density)
        };
        let mut before = at(first);
        for i in 0..count {
            let after = at(first + i + 1);
            axis.share[i] = after.1 - before.1;
            axis.by_place[i] = (before.2 - after.2) * inverse;
            axis.by_blur[i] = before.0 * before.2 - after.0 * after.2;
            before = after;
        }
        axis
    }

    /// The blurred pattern and its derivatives by u, v and the blurs' logarithms. Unknown cells count as grey.
    #[inline(always)]
    fn blurred(&self, along_u: &Axis, along_v: &Axis) -> [f32; 5] {
        let mut sums = [0.0; 5];
        for j in 0..along_v.count {
            let row = &self.pattern[(along_v.first + j) * self.grid_width + along_u.first..][..along_u.count];
            let (mut value, mut by_place, mut by_blur) = (0.0, 0.0, 0.0);
            for (i, colour) in row.iter().enumerate() {
                let colour = if colour.is_nan() { 0.5 } else { *colour };
                value += colour * along_u.share[i];
                by_place += colour * along_u.by_place[i];
                by_blur += colour * along_u.by_blur[i];
            }
            sums[0] += value * along_v.share[j];
            sums[1] += by_place * along_v.share[j];
            sums[2] += value * along_v.by_place[j];
            sums[3] += by_blur * along_v.share[j];
            sums[4] += value * along_v.by_blur[j];
        }
        sums
    }
}
