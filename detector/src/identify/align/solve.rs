//! Robust least squares with priors.

use nalgebra::{SMatrix, SVector};

use super::model::{BLOOM, CURVE, EXPECTED_SIGMA, GAIN, LOG_BLUR, OFFSET, Parameters};
use super::pixels::{BLOCK, Lanes, ZERO};

/// Parameters of the model.
pub(super) const PARAMETERS: usize = 18;
/// Derivatives by all parameters, and the residuals behind them, of a block of pixels.
#[repr(align(64))]
pub(super) struct Rows(pub(super) [Lanes; PARAMETERS + 1]);
/// Sums are kept in so many parts, which are added up at the end, always in this order.
const PARTS: usize = 16;
/// Pairs of a column and itself or one behind it; the residuals' own is kept apart.
const PAIRS: usize = PARAMETERS * (PARAMETERS + 3) / 2;

/// Residuals beyond this many times the last root mean square count less.
const HUBER: f32 = 3.0;
/// Share by which the diagonal is raised, so that hardly seen parameters stay put.
const DAMPING: f64 = 1e-4;
/// Variance of a grey level's rounding and of what the model leaves out, so that priors keep weight in clean pictures.
const LEAST_VARIANCE: f64 = 0.5;
/// Standard deviations of the priors: the blur's logarithm, slopes of the light across the tag (grey levels), the bloom
/// (pixels), the curve.
const LOG_BLUR_SD: f64 = 0.5;
const SLOPE_SD: f64 = 10.0;
const BLOOM_SD: f64 = 0.25;
const CURVE_SD: f64 = 0.4;

/// Sums of the products of all columns.
#[repr(align(64))]
pub(super) struct NormalEquations {
    /// For each pair of columns, the second one not before the first.
    products: [[f32; PARTS]; PAIRS],
    squares: [f32; PARTS],
    weight: [f32; PARTS],
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self { products: [[0.0; PARTS]; PAIRS], squares: [0.0; PARTS], weight: [0.0; PARTS] }
    }
}

/// Adds the products of two columns to the parts of a sum.
#[inline(always)]
fn add_products(parts: &mut [f32; PARTS], a: &Lanes, b: &Lanes) {
    let mut sum = *parts;
    for chunk in 0..BLOCK / PARTS {
        for l in 0..PARTS {
            sum[l] += a[chunk * PARTS + l] * b[chunk * PARTS + l];
        }
    }
    *parts = sum;
}

/// Half of the parts is added to the other half until one is left, which vectors do at once.
#[inline(always)]
fn total(parts: &[f32; PARTS]) -> f64 {
    let mut sums = *parts;
    let mut half = PARTS / 2;
    while half > 0 {
        for l in 0..half {
            sums[l] += sums[l + half];
        }
        half /= 2;
    }
    f64::from(sums[0])
}

/// The place of a pair of columns, the second one not before the first.
#[inline(always)]
const fn pair(i: usize, j: usize) -> usize {
    i * (2 * PARAMETERS + 1 - i) / 2 + j
}

impl NormalEquations {
    /// Forgets all blocks. Where they lie: a new value would be made elsewhere and copied, 12 kB twice.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.products.as_flattened_mut().fill(0.0);
        self.squares.fill(0.0);
        self.weight.fill(0.0);
    }

    /// Adds the products of two columns to those of two parameters, the second one not before the first.
    #[inline(always)]
    pub(super) fn add_products(&mut self, i: usize, j: usize, a: &Lanes, b: &Lanes) {
        add_products(&mut self.products[pair(i, j)], a, b);
    }

    /// Counts residuals of pixels that count `weight`, and says what they are to count in the equations; `rms` is the root mean
    /// square residual of the step before.
    #[inline(always)]
    pub(super) fn count(&mut self, residual: &Lanes, weight: &Lanes, rms: f32) -> Lanes {
        let limit = HUBER * if rms > 1.0 { rms } else { 1.0 };
        let (mut robust, mut counted) = (ZERO, ZERO);
        for l in 0..BLOCK {
            let size = residual[l].abs();
            robust[l] = weight[l] * if size > limit { limit / size } else { 1.0 };
            counted[l] = weight[l] * residual[l];
        }
        add_products(&mut self.squares, &counted, residual);
        add_products(&mut self.weight, weight, weight);
        robust
    }

    /// Adds a block; `weight` is what its pixels count, `rms` the root mean square residual of the step before.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "said in the loop")]
    pub(super) fn add(&mut self, rows: &Rows, weight: &Lanes, rms: f32) {
        let robust = self.count(&rows.0[PARAMETERS], weight, rms);
        for i in 0..PARAMETERS {
            let mut weighted = ZERO;
            for l in 0..BLOCK {
                weighted[l] = robust[l] * rows.0[i][l];
            }
            // Not by iterators: these stay calls here, compiled without the level's instructions.
            for j in i..=PARAMETERS {
                add_products(&mut self.products[pair(i, j)], &weighted, &rows.0[j]);
            }
        }
    }

    /// Root mean square residual of all rows; `None` when that is no number.
    pub(super) fn rms(&self) -> Option<f32> {
        let rms = (total(&self.squares) / total(&self.weight).max(1.0)).sqrt() as f32;
        rms.is_finite().then_some(rms)
    }

    /// The Gauss-Newton step.
    pub(super) fn solve(&self, parameters: &Parameters, rms: f32) -> Option<[f64; PARAMETERS]> {
        // A symmetric matrix, of which only the lower half is looked at.
        let mut left = SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|i, j| {
            if j <= i { total(&self.products[pair(j, i)]) } else { 0.0 }
        });
        let mut right =
            SVector::<f64, PARAMETERS>::from_fn(|i, _| total(&self.products[pair(i, PARAMETERS)]));
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
        pull(CURVE, CURVE_SD, -f64::from(parameters.curve));
        let step = left.cholesky()?.solve(&right);
        step.iter().all(|v| v.is_finite()).then(|| std::array::from_fn(|i| step[i]))
    }
}

#[cfg(test)]
impl NormalEquations {
    /// Panics unless all sums are those of others, up to a share of what their columns' lengths allow.
    pub(super) fn assert_near(&self, other: &Self, share: f64) {
        let sum = |of: &Self, i: usize, j: usize| total(&of.products[pair(i, j)]);
        let squares = total(&other.squares);
        assert!((total(&self.squares) - squares).abs() < share * squares, "squares of residuals");
        for i in 0..PARAMETERS {
            for j in i..=PARAMETERS {
                let length = if j < PARAMETERS { sum(other, j, j) } else { squares };
                let most = (sum(other, i, i) * length).sqrt();
                let (own, others) = (sum(self, i, j), sum(other, i, j));
                assert!(
                    (own - others).abs() <= share * most,
                    "columns {i} and {j}: {own}, not {others}, of {most}"
                );
            }
        }
    }
}
