//! Times of which only is known between which two they lie.

/// From the first to the last moment at which something can have been, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) first: u64,
    pub(super) last: u64,
}

/// A delay that lies between two values, nanoseconds; negative where a stamp is earlier than what it stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Delay {
    pub(super) least: i64,
    pub(super) most: i64,
}

impl Delay {
    /// From a moment in `span` to a stamp.
    pub(super) fn between(span: Span, stamp_ns: u64) -> Self {
        Self { least: stamp_ns as i64 - span.last as i64, most: stamp_ns as i64 - span.first as i64 }
    }

    fn middle(self) -> i64 {
        self.least + (self.most - self.least) / 2
    }
}

/// Many delays of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Delays(Vec<Delay>);

impl Delays {
    pub(super) fn add(&mut self, delay: Delay) {
        self.0.push(delay);
    }

    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// The quantile of the middles, milliseconds. A moment lies anywhere in its span, so of many the middles are right.
    pub(super) fn quantile_ms(&self, part: f64) -> f64 {
        let mut middles: Vec<i64> = self.0.iter().map(|delay| delay.middle()).collect();
        middles.sort_unstable();
        let place = ((part * middles.len() as f64).ceil() as usize).saturating_sub(1);
        middles.get(place.min(middles.len().saturating_sub(1))).map_or(0.0, |&middle| milliseconds(middle))
    }

    /// How far from its middle a delay can be, milliseconds: half of the widest span.
    pub(super) fn uncertainty_ms(&self) -> f64 {
        let widest = self.0.iter().map(|delay| delay.most - delay.least).max();
        milliseconds(widest.unwrap_or(0)) / 2.0
    }

    /// The delay was never longer than this in the frame in which it was shortest, milliseconds: other work of the machine, which makes
    /// some frames late, does not touch it.
    pub(super) fn shortest_ms(&self) -> f64 {
        milliseconds(self.0.iter().map(|delay| delay.most).min().unwrap_or(0))
    }

    /// Between which two values a delay lies that is the same for all, milliseconds; `None` when no value fits all.
    pub(super) fn common_ms(&self) -> Option<[f64; 2]> {
        let least = self.0.iter().map(|delay| delay.least).max()?;
        let most = self.0.iter().map(|delay| delay.most).min()?;
        (least <= most).then(|| [least, most].map(milliseconds))
    }
}

fn milliseconds(time_ns: i64) -> f64 {
    time_ns as f64 / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments at every phase of a step of 20 ms, stamped so much later.
    fn delays(late_ns: u64) -> Delays {
        let mut delays = Delays::default();
        for moment in (1_000_000_000..2_000_000_000).step_by(7_300_000) {
            let first = moment / 20_000_000 * 20_000_000;
            delays.add(Delay::between(Span { first, last: first + 20_000_000 }, moment + late_ns));
        }
        delays
    }

    #[test]
    fn a_delay_is_found_far_better_than_a_step_is_long() {
        for late_ms in [0, 3, 30, 250] {
            let delays = delays(late_ms * 1_000_000);
            let late_ms = late_ms as f64;
            assert!((delays.quantile_ms(0.5) - late_ms).abs() < 0.5, "{}", delays.quantile_ms(0.5));
            let [least, most] = delays.common_ms().unwrap();
            assert!(least <= late_ms && late_ms <= most && most - least < 1.0, "{least} {most}");
            assert_eq!(delays.shortest_ms(), most);
            assert_eq!(delays.uncertainty_ms(), 10.0);
        }
    }

    #[test]
    fn delays_that_differ_have_none_in_common_and_a_stamp_may_be_too_early() {
        let mut delays = delays(30_000_000);
        delays.add(Delay { least: 100_000_000, most: 120_000_000 });
        assert_eq!(delays.common_ms(), None);
        let early = Delay::between(Span { first: 5_000_000, last: 6_000_000 }, 4_000_000);
        assert_eq!(early, Delay { least: -2_000_000, most: -1_000_000 });
        assert_eq!((Delays::default().quantile_ms(0.5), Delays::default().common_ms()), (0.0, None));
    }
}
