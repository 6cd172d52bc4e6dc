//! Gauss-Newton steps until they hardly move anything.

use super::model::Parameters;
use super::patch::Patch;
use super::solve::NormalEquations;

/// Most steps.
const STEPS: usize = 4;
/// A step that moves no corner further than this many cells, but at least and at most so many pixels, and hardly changes blur and
/// bloom, is the last one.
const SETTLED: f64 = 0.02;
const SETTLED_PX: (f64, f64) = (0.05, 0.1);

/// What pixels say about parameters.
pub(super) trait Residuals {
    /// The equations of a step; `rms` is the root mean square residual of the step before.
    fn equations(&self, at: &Parameters, patch: &Patch, rms: f32) -> NormalEquations;

    /// Whether the pixels can still be compared with the model there; when not, steps end.
    #[inline(always)]
    fn hold(&self, _at: &Parameters) -> bool {
        true
    }
}

/// A tag, where and how it is thought to lie.
#[derive(Clone, Copy)]
pub(super) struct Fit {
    pub(super) parameters: Parameters,
    pub(super) patch: Patch,
    pub(super) corners: [[f64; 2]; 4],
    /// Cells between the tag's corners.
    pub(super) width: f64,
}

impl Fit {
    /// Where steps lead from here. `None` when the numbers run away.
    #[inline(always)]
    pub(super) fn descend(&self, residuals: &impl Residuals) -> Option<Fit> {
        let mut fit = *self;
        let mut rms = f32::MAX;
        for _ in 0..STEPS {
            let before = fit;
            let equations = residuals.equations(&fit.parameters, &fit.patch, rms);
            rms = equations.rms()?;
            fit.parameters.step(&equations.solve(&before.parameters, rms)?);
            fit.corners = fit.patch.corners_of(&fit.parameters.to_homography()?, fit.width);
            if fit.is_settled(&before) || !residuals.hold(&fit.parameters) {
                break;
            }
        }
        Some(fit)
    }

    fn is_settled(&self, before: &Fit) -> bool {
        // The patch reaches to the farthest corner.
        let cell = self.patch.scale * std::f64::consts::SQRT_2 / self.width;
        farthest_move(&before.corners, &self.corners) < (SETTLED * cell).clamp(SETTLED_PX.0, SETTLED_PX.1)
            && self.parameters.look_like(&before.parameters)
    }
}

/// The largest distance between corners before and after.
pub(super) fn farthest_move(before: &[[f64; 2]; 4], after: &[[f64; 2]; 4]) -> f64 {
    (0..4).map(|k| (before[k][0] - after[k][0]).hypot(before[k][1] - after[k][1])).fold(0.0, f64::max)
}
