//! A step blurred by a Gaussian: the normal distribution, as arithmetic that compilers make vectors of.

/// Beyond this many standard deviations the step is over to the precision of this file.
const REACH: f32 = 5.0;
/// 1.5 * 2^23: added to a small number it leaves the nearest whole number in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

/// Integral and density of the standard normal distribution at `z`, each to 2e-5.
///
/// The integral is Hastings' approximation (Abramowitz and Stegun, 26.2.16).
#[inline(always)]
pub(super) fn normal(z: f32) -> (f32, f32) {
    let size = z.abs();
    let size = if size < REACH { size } else { REACH };
    let density = exp_of_half_square(size) * 0.398_942_3;
    let t = 1.0 / (1.0 + 0.332_67 * size);
    let tail = density * t * (0.436_183_6 + t * (0.937_298 * t - 0.120_167_6));
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
}

/// exp(-z^2 / 2) for z up to `REACH`: a power of two by its exponent's bits, the rest by a polynomial.
#[inline(always)]
fn exp_of_half_square(z: f32) -> f32 {
    let power = z * z * (-0.5 * std::f32::consts::LOG2_E);
    let rounded = power + ROUNDER;
    let rest = power - (rounded - ROUNDER);
    let scale = f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23));
    let polynomial = 1.0
        + rest * (std::f32::consts::LN_2 + rest * (0.240_226_5 + rest * (0.055_504_1 + rest * 0.009_618_1)));
    scale * polynomial
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_distribution_has_its_values() {
        for (z, integral) in [
            (-7.0, 0.0),
            (-3.0, 0.001_35),
            (-1.0, 0.158_655),
            (0.0, 0.5),
            (0.25, 0.598_706),
            (2.0, 0.977_25),
            (80.0, 1.0),
        ] {
            let (found, density) = normal(z);
            assert!((found - integral).abs() < 3e-5, "{found} at {z}");
            let exact = (-0.5 * z * z).exp() / (2.0 * std::f32::consts::PI).sqrt();
            assert!((density - exact).abs() < 3e-5, "{density} at {z}");
        }
    }

    #[test]
    fn the_density_is_the_slope_of_the_integral_everywhere() {
        for i in -450..450 {
            let z = i as f32 * 0.01;
            let slope = (normal(z + 0.05).0 - normal(z - 0.05).0) / 0.1;
            assert!((slope - normal(z).1).abs() < 1e-3, "{slope} at {z}");
        }
    }
}
