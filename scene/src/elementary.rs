//! Sine, cosine, the exponential and the logarithm, the same bit for bit on every machine.
//!
//! The standard library hands these to the platform's mathematics library, whose last digit differs between systems.
//! Here they are made of additions, multiplications and divisions, which IEEE 754 fixes exactly.

use std::f64::consts::FRAC_PI_2;

/// Sine and cosine of an angle in radians; the error is below 1e-15 for angles of a few turns.
pub(crate) fn sine_cosine(angle_rad: f64) -> (f64, f64) {
    let quarters = (angle_rad / FRAC_PI_2).round();
    let rest = angle_rad - quarters * FRAC_PI_2;
    quarter_turned(quarters, sine_series(rest), cosine_series(rest))
}

/// Sine and cosine of an angle in whole turns. Whole turns are dropped exactly, so a clock may run for years.
pub(crate) fn sine_cosine_of_turns(turns: f64) -> (f64, f64) {
    let quarters = (turns.fract() * 4.0).round();
    let rest = (turns.fract() * 4.0 - quarters) * FRAC_PI_2;
    quarter_turned(quarters, sine_series(rest), cosine_series(rest))
}

/// Sine of an angle in whole turns.
pub(crate) fn sine_of_turns(turns: f64) -> f64 {
    sine_cosine_of_turns(turns).0
}

/// The exponential of a number that is not positive: the series for a small part of it, squared back up. Below -50
/// (2e-22) it is taken as 0, where the series would need more terms.
pub(crate) fn exponential_of_negative(exponent: f64) -> f64 {
    const DOUBLINGS: i32 = 8;
    const TERMS: u32 = 14;
    const NOTHING_BELOW: f64 = -50.0;
    if exponent < NOTHING_BELOW {
        return 0.0;
    }
    let small = exponent / f64::from(1 << DOUBLINGS);
    let series = (1..=TERMS).rev().fold(1.0, |sum, term| 1.0 + small / f64::from(term) * sum);
    (0..DOUBLINGS).fold(series, |value, _| value * value)
}

/// The natural logarithm of a positive number: whole powers of two are taken out, the rest is a series for numbers
/// between 0.7 and 1.5 (ln x = 2 artanh((x - 1) / (x + 1))).
pub(crate) fn logarithm(number: f64) -> f64 {
    const TERMS: i32 = 16;
    let (mut rest, mut doublings) = (number, 0.0);
    while rest > std::f64::consts::SQRT_2 {
        (rest, doublings) = (rest / 2.0, doublings + 1.0);
    }
    while rest > 0.0 && rest < std::f64::consts::FRAC_1_SQRT_2 {
        (rest, doublings) = (rest * 2.0, doublings - 1.0);
    }
    let ratio = (rest - 1.0) / (rest + 1.0);
    let series = (0..TERMS).rev().fold(0.0, |sum, term| sum * ratio * ratio + 1.0 / f64::from(2 * term + 1));
    2.0 * ratio * series + doublings * std::f64::consts::LN_2
}

/// Sine and cosine after `quarters` quarter turns more.
fn quarter_turned(quarters: f64, sine: f64, cosine: f64) -> (f64, f64) {
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Taylor series up to the power 17; enough for an eighth of a turn.
fn sine_series(angle_rad: f64) -> f64 {
    let square = angle_rad * angle_rad;
    let terms = (1..=8).rev().map(|pair| f64::from(2 * pair * (2 * pair + 1)));
    angle_rad * terms.fold(1.0, |sum, divisor| 1.0 - square / divisor * sum)
}

/// Taylor series up to the power 18; enough for an eighth of a turn.
fn cosine_series(angle_rad: f64) -> f64 {
    let square = angle_rad * angle_rad;
    let terms = (1..=9).rev().map(|pair| f64::from(2 * pair * (2 * pair - 1)));
    terms.fold(1.0, |sum, divisor| 1.0 - square / divisor * sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// Our functions and the platform's may differ in the last few bits.
    const ROUNDING: f64 = 4e-15;

    #[test]
    fn sine_and_cosine_agree_with_the_standard_library() {
        let mut stream = Stream::new(11);
        for _ in 0..10_000 {
            let angle_rad = stream.between(-20.0, 20.0);
            let (sine, cosine) = sine_cosine(angle_rad);
            assert!((sine - angle_rad.sin()).abs() < ROUNDING, "sine of {angle_rad}");
            assert!((cosine - angle_rad.cos()).abs() < ROUNDING, "cosine of {angle_rad}");
        }
    }

    #[test]
    fn whole_turns_change_nothing() {
        for turns in [0.0, 0.125, 0.25, 0.5, 0.75, -0.25] {
            assert_eq!(sine_cosine_of_turns(turns), sine_cosine_of_turns(turns + 1024.0 * turns.signum()));
        }
        assert_eq!(sine_cosine_of_turns(0.25), (1.0, 0.0));
    }

    #[test]
    fn the_exponential_agrees_with_the_standard_library() {
        let mut stream = Stream::new(12);
        for _ in 0..10_000 {
            let exponent = stream.between(-50.0, 0.0);
            let relative = exponential_of_negative(exponent) / exponent.exp() - 1.0;
            assert!(relative.abs() < 1e-12, "exponential of {exponent}");
        }
        assert_eq!(exponential_of_negative(-1e9), 0.0);
    }

    #[test]
    fn the_logarithm_agrees_with_the_standard_library() {
        let mut stream = Stream::new(13);
        for _ in 0..10_000 {
            let number = stream.between(-20.0, 20.0).exp();
            assert!((logarithm(number) - number.ln()).abs() < 1e-13, "logarithm of {number}");
        }
        assert_eq!(logarithm(1.0), 0.0);
    }
}
