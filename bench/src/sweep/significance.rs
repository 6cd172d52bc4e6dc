//! Whether one detector finds more than another one on the same frames, or was merely lucky.

/// McNemar's test in its exact form: the probability of a split at least as uneven as this one between frames that only
/// the one and frames that only the other detector solved, if both were equally good. Two-sided.
pub(crate) fn mcnemar(only_one: u32, only_other: u32) -> f64 {
    let (few, all) = (only_one.min(only_other), only_one + only_other);
    // Probability of k of `all` fair coins, from one k to the next.
    let (mut term, mut sum) = (0.5_f64.powi(i32::try_from(all).unwrap_or(i32::MAX)), 0.0);
    for k in 0..=few {
        sum += term;
        term *= f64::from(all - k) / f64::from(k + 1);
    }
    (2.0 * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_splits_mean_nothing_and_uneven_ones_something() {
        assert_eq!(mcnemar(0, 0), 1.0);
        assert_eq!(mcnemar(4, 4), 1.0);
        assert!((mcnemar(0, 5) - 0.0625).abs() < 1e-12);
        assert!((mcnemar(1, 9) - 22.0 / 1024.0).abs() < 1e-12);
        assert_eq!(mcnemar(9, 1), mcnemar(1, 9));
    }
}
