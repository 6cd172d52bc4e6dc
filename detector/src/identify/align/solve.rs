//! Robust least squares with priors.

use nalgebra::{SMatrix, SVector};

use super::model::{BLOOM, EXPECTED_SIGMA, GAIN, LOG_BLUR, OFFSET, Parameters};

/// Parameters of the model.
pub(super) const PARAMETERS: usize = 17;
/// Derivatives a row, filled up with zeros to whole vectors.
const LANES: usize = 24;

/// Residuals beyond this many times the last root mean square count less.
const HUBER: f32 = 3.0;
/// Share by which the diagonal is raised, so that hardly seen parameters stay put.
const DAMPING: f64 = 1e-4;
/// Variance of a grey level's rounding and of what the model leaves out, so that priors keep weight in clean pictures.
const LEAST_VARIANCE: f64 = 0.5;
/// Standard deviations of the priors: the blur's logarithm, slopes of the light across the tag (grey levels), the bloom
/// (pixels).
const LOG_BLUR_SD: f64 = 0.5;
const SLOPE_SD: f64 = 10.0;
const BLOOM_SD: f64 = 0.25;

/// What one pixel adds.
pub(super) struct Row {
    pub(super) residual: f32,
    pub(super) derivatives: [f32; LANES],
}

/// Sums of the products of all rows.
pub(super) struct NormalEquations {
    products: [[f32; LANES]; PARAMETERS],
    right: [f32; LANES],
    squares: f64,
    count: usize,
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self { products: [[0.0; LANES]; PARAMETERS], right: [0.0; LANES], squares: 0.0, count: 0 }
    }
}

impl NormalEquations {
    /// Adds a row; `rms` is the root mean square residual of the step before.
    #[inline(always)]
    pub(super) fn add(&mut self, row: &Row, rms: f32) {
        let limit = HUBER * rms.max(1.0);
        let size = row.residual.abs();
        let weight = if size > limit { limit / size } else { 1.0 };
        self.squares += f64::from(row.residual) * f64::from(row.residual);
        self.count += 1;
        for (sums, derivative) in self.products.iter_mut().zip(&row.derivatives) {
            let weighted = weight * derivative;
            for (sum, other) in sums.iter_mut().zip(&row.derivatives) {
                *sum += weighted * other;
            }
        }
        let weighted = weight * row.residual;
        for (sum, derivative) in self.right.iter_mut().zip(&row.derivatives) {
            *sum += weighted * derivative;
        }
    }

    /// Root mean square residual of all rows; `None` when that is no number.
    pub(super) fn rms(&self) -> Option<f32> {
        let rms = (self.squares / self.count.max(1) as f64).sqrt() as f32;
        rms.is_finite().then_some(rms)
    }

    /// The Gauss-Newton step.
    pub(super) fn solve(&self, parameters: &Parameters, rms: f32) -> Option<[f64; PARAMETERS]> {
        let mut left = SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|i, j| f64::from(self.products[i][j]));
        let mut right = SVector::<f64, PARAMETERS>::from_fn(|i, _| f64::from(self.right[i]));
        for i in 0..PARAMETERS {
            left[(i, i)] = left[(i, i)] * (1.0 + DAMPING) + 1e-9;
        }
        let variance = f64::from(rms) * f64::from(rms) + LEAST_VARIANCE;
        let mut pull = |place: usize, sd: f64, towards: f64| {
            left[(place, place)] += variance / (sd * sd);
            right[place] += variance / (sd * sd) * towards;
        };
        for (i, log) in parameters.log_sigma.iter().enumerate() {
            pull(LOG_BLUR + i, LOG_BLUR_SD, f64::from(EXPECTED_SIGMA.ln() - log));
        }
        for slope in [OFFSET + 1, OFFSET + 2, GAIN + 1, GAIN + 2] {
            pull(slope, SLOPE_SD, 0.0);
        }
        pull(BLOOM, BLOOM_SD, -f64::from(parameters.bloom));
        let step = left.cholesky()?.solve(&right);
        step.iter().all(|v| v.is_finite()).then(|| std::array::from_fn(|i| step[i]))
    }
}
