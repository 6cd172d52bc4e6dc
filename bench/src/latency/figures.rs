//! What many times have in common.

/// Times in nanoseconds, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Times(Vec<u64>);

/// The quantiles that tables show; the last is the longest.
pub(super) const SHOWN: [f64; 4] = [0.5, 0.99, 0.999, 1.0];

impl Times {
    pub(super) fn of(times: impl IntoIterator<Item = u64>) -> Self {
        let mut times: Vec<u64> = times.into_iter().collect();
        times.sort_unstable();
        Self(times)
    }

    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// The time in microseconds that so large a part does not pass: the smallest for 0, the longest for 1. 0 when there are none.
    pub(super) fn quantile_us(&self, part: f64) -> f64 {
        let place = (part * self.0.len() as f64).ceil() as usize;
        let time = self.0.get(place.saturating_sub(1).min(self.0.len().saturating_sub(1)));
        time.map_or(0.0, |&time| time as f64 / 1e3)
    }

    pub(super) fn median_us(&self) -> f64 {
        self.quantile_us(0.5)
    }

    /// The quantiles of [`SHOWN`] as a cell of a table.
    pub(super) fn cell(&self) -> String {
        SHOWN.map(|part| format!("{:.1}", self.quantile_us(part))).join(" / ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_a_time_that_was_measured() {
        let times = Times::of((1..=1000).rev().map(|time| time * 1000));
        assert_eq!(times.count(), 1000);
        assert_eq!(times.median_us(), 500.0);
        assert_eq!([0.0, 0.99, 0.999, 1.0].map(|part| times.quantile_us(part)), [1.0, 990.0, 999.0, 1000.0]);
        assert_eq!(times.cell(), "500.0 / 990.0 / 999.0 / 1000.0");
        assert_eq!(Times::of([7000]).quantile_us(0.5), 7.0);
        assert_eq!(Times::default().median_us(), 0.0);
    }
}
