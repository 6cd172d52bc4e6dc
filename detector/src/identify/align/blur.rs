//! A step blurred by a Gaussian, and its derivative, from a table.

/// Steps of the table per standard deviation.
const PER_SIGMA: usize = 64;
/// Beyond this many standard deviations the step is over.
pub(super) const REACH: f32 = 3.5;
const ENTRIES: usize = 2 * (REACH as usize + 1) * PER_SIGMA + 1;

/// The normal distribution's integral and density, tabulated.
pub(crate) struct StepTable {
    integral: Vec<f32>,
    density: Vec<f32>,
}

impl Default for StepTable {
    fn default() -> Self {
        let half = (ENTRIES - 1) / 2;
        let density = |i: f64| {
            let z = (i - half as f64) / PER_SIGMA as f64;
            (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt()
        };
        let mut sum = 0.0;
        let mut integral = Vec::with_capacity(ENTRIES);
        for i in 0..ENTRIES {
            integral.push(sum as f32);
            // Simpson's rule from this entry to the next.
            let i = i as f64;
            sum += (density(i) + 4.0 * density(i + 0.5) + density(i + 1.0)) / (6.0 * PER_SIGMA as f64);
        }
        // The table begins where a little of the integral has gone by already.
        let missed = 0.5 - integral[half];
        integral.iter_mut().for_each(|value| *value += missed);
        Self { integral, density: (0..ENTRIES).map(|i| density(i as f64) as f32).collect() }
    }
}

impl StepTable {
    /// Integral and density of the standard normal distribution at `z`.
    #[inline(always)]
    pub(super) fn at(&self, z: f32) -> (f32, f32) {
        let half = (ENTRIES - 1) / 2;
        let place = z.clamp(-REACH, REACH) * PER_SIGMA as f32 + half as f32;
        let entry = (place as usize).min(ENTRIES - 2);
        let share = place - entry as f32;
        let between = |table: &[f32]| table[entry] + share * (table[entry + 1] - table[entry]);
        (between(&self.integral), between(&self.density))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_the_normal_distribution() {
        let table = StepTable::default();
        for (z, integral) in
            [(-3.0, 0.001_35), (-1.0, 0.158_655), (0.0, 0.5), (0.25, 0.598_706), (2.0, 0.977_25)]
        {
            let (found, density) = table.at(z);
            assert!((found - integral).abs() < 3e-5, "{found} at {z}");
            let exact = (-0.5 * z * z).exp() / (2.0 * std::f32::consts::PI).sqrt();
            assert!((density - exact).abs() < 3e-5, "{density} at {z}");
        }
    }
}
