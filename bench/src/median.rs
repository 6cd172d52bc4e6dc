//! The middle of what was measured.

/// The middle value, the upper one of two; 0 of nothing.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Between which two values the middle of all that could have been measured lies, with a probability of at least 95 %: those
/// so far from the ends that chance puts the middle outside of them in at most one case of twenty (order statistics, whatever the
/// distribution is). The ends themselves where there are fewer than six, which tell less than that.
pub(crate) fn median_interval(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let count = values.len();
    // The chance that at most so many of the values lie below the middle.
    let (mut chance, mut term, mut rank) = (0.0, 0.5_f64.powi(count as i32), 0);
    while chance + term <= 0.025 {
        chance += term;
        term *= (count - rank) as f64 / (rank + 1) as f64;
        rank += 1;
    }
    let place = rank.saturating_sub(1);
    [place, count.saturating_sub(1 + place)].map(|place| values.get(place).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known ranks: 1 and 6 of 6, 6 and 15 of 20, 18 and 33 of 50 (tables of the sign test).
    #[test]
    fn the_interval_of_the_middle_has_the_ranks_of_the_sign_test() {
        let ranks = |count: u32| median_interval((1..=count).rev().map(f64::from));
        assert_eq!([6, 20, 50].map(ranks), [[1.0, 6.0], [6.0, 15.0], [18.0, 33.0]]);
        assert_eq!([1, 5].map(ranks), [[1.0, 1.0], [1.0, 5.0]]);
        assert_eq!(median_interval([]), [0.0, 0.0]);
    }

    #[test]
    fn the_middle_does_not_depend_on_the_order() {
        assert_eq!(median([5.0, 1.0, 9.0]), 5.0);
        assert_eq!(median([4.0, 1.0]), 4.0);
        assert_eq!(median([]), 0.0);
    }
}
