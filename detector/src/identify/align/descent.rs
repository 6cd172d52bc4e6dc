//! Gauss-Newton steps until they hardly move anything.

use super::model::Parameters;
use super::patch::Patch;
use super::solve::NormalEquations;
use crate::simd::{Kernel, Level};

/// Most steps.
const STEPS: usize = 4;
/// A step that moves no corner further than this many cells, but at least and at most so many pixels, and hardly changes blur and
/// bloom, is the last one.
const SETTLED: f64 = 0.02;
const SETTLED_PX: (f64, f64) = (0.05, 0.1);

/// What pixels say about parameters.
pub(super) trait Residuals {
    /// Whether the widest vectors are of use to the arithmetic.
    const ARE_WIDE: bool;

    /// Adds up the equations of a step; `rms` is the root mean square residual of the step before.
    fn equations(&self, at: &Parameters, patch: &Patch, rms: f32, equations: &mut NormalEquations);

    /// Whether the pixels can still be compared with the model there; when not, steps end.
    #[inline(always)]
    fn hold(&self, _at: &Parameters) -> bool {
        true
    }
}

/// A step's equations. A function of its own at every level for each kind of residuals: it is where the time goes, and code that
/// is read from the caches once serves all steps.
struct Equations<'a, R> {
    residuals: &'a R,
    at: &'a Fit,
    rms: f32,
    equations: &'a mut NormalEquations,
}

impl<R: Residuals> Kernel for Equations<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { residuals, at, rms, equations } = self;
        equations.clear();
        residuals.equations(&at.parameters, &at.patch, rms, equations);
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
    pub(super) fn descend<R: Residuals>(
        &self,
        level: Level,
        residuals: &R,
        equations: &mut NormalEquations,
    ) -> Option<Fit> {
        let mut fit = *self;
        let mut rms = f32::MAX;
        for _ in 0..STEPS {
            let before = fit;
            let step = Equations { residuals, at: &fit, rms, equations };
            if R::ARE_WIDE {
                level.run_wide(step);
            } else {
                level.run(step);
            }
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
