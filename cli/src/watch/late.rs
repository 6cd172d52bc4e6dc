//! Which detections come too late, and which hop is to blame.

use std::fmt;

use tagbus_message::histogram::Histogram;

use super::hops::{Hops, NAMES};
use crate::outcome::Failure;
use crate::units::time;

/// Limits of a deadline, milliseconds.
const SHORTEST_MS: f64 = 0.001;
const LONGEST_MS: f64 = 3_600_000.0;

/// How old detections may be when they arrive.
pub(super) struct Deadline {
    limit_us: f64,
    /// How long each hop took so far.
    usual: [Histogram; NAMES.len()],
    frames: u64,
    /// Late ones by the hop that was to blame.
    late: [u64; NAMES.len()],
}

/// A detection that came too late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Late {
    /// How much older it was than it should have been.
    pub(super) by_us: f64,
    /// The hop that took longer than usual by most.
    pub(super) hop: &'static str,
    took_us: f64,
    usual_us: Option<f64>,
}

impl Deadline {
    /// A deadline of so many milliseconds.
    pub(super) fn new(limit_ms: f64) -> Result<Self, Failure> {
        if !(SHORTEST_MS..=LONGEST_MS).contains(&limit_ms) {
            return Err(Failure::new(format!(
                "a deadline of {limit_ms} ms is not possible: use a number from {SHORTEST_MS} to {LONGEST_MS}, such as 40"
            )));
        }
        Ok(Self { limit_us: limit_ms * 1e3, usual: Default::default(), frames: 0, late: [0; NAMES.len()] })
    }

    /// Counts a frame, and says whether it was late.
    pub(super) fn judge(&mut self, hops: &Hops) -> Option<Late> {
        let late = (hops.total_us > self.limit_us).then(|| self.blame(hops));
        // Afterwards: what it is compared with is what was usual before it.
        for (usual, us) in self.usual.iter_mut().zip(hops.us) {
            usual.count((us.max(0.0) * 1e3) as u64);
        }
        self.frames += 1;
        late
    }

    fn blame(&mut self, hops: &Hops) -> Late {
        let usual_us: [Option<f64>; NAMES.len()] =
            std::array::from_fn(|hop| self.usual[hop].quantile_ns(0.5).map(|ns| ns / 1e3));
        let excess = |hop: usize| hops.us[hop] - usual_us[hop].unwrap_or(0.0);
        let worst =
            (1..NAMES.len()).fold(0, |worst, hop| if excess(hop) > excess(worst) { hop } else { worst });
        self.late[worst] += 1;
        Late {
            by_us: hops.total_us - self.limit_us,
            hop: NAMES[worst],
            took_us: hops.us[worst],
            usual_us: usual_us[worst],
        }
    }
}

impl fmt::Display for Late {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { by_us, hop, took_us, usual_us } = *self;
        write!(f, "LATE by {}: {hop} took {}", time(by_us), time(took_us))?;
        usual_us.map_or(Ok(()), |us| write!(f, ", usually {}", time(us)))
    }
}

/// The summary: how many were late, and what was to blame how often.
impl fmt::Display for Deadline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let late: u64 = self.late.iter().sum();
        write!(f, "{late} of {} frames came later than {}", self.frames, time(self.limit_us))?;
        let blamed = NAMES.iter().zip(self.late).filter(|(_, count)| *count > 0);
        for (number, (hop, count)) in blamed.enumerate() {
            write!(f, "{} {hop} {count}", if number == 0 { ":" } else { "," })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hops(us: [f64; 6]) -> Hops {
        Hops { us, total_us: us.iter().sum() }
    }

    #[test]
    fn the_hop_that_took_longer_than_usual_is_to_blame_and_not_the_longest() {
        let mut deadline = Deadline::new(15.0).unwrap();
        (0..50)
            .for_each(|_| assert_eq!(deadline.judge(&hops([100.0, 50.0, 5.0, 12_000.0, 9.0, 60.0])), None));
        let late = deadline.judge(&hops([100.0, 50.0, 5.0, 12_500.0, 9.0, 6_060.0])).unwrap();
        assert_eq!(late.hop, "client");
        assert!((late.by_us - 3_724.0).abs() < 1e-6, "{late:?}");
        assert!(late.to_string().starts_with("LATE by 3.72 ms: client took 6.06 ms, usually 6"), "{late}");
        assert_eq!(deadline.to_string(), "1 of 51 frames came later than 15.0 ms: client 1");
    }

    #[test]
    fn with_nothing_to_compare_the_longest_hop_is_to_blame() {
        let mut deadline = Deadline::new(0.001).unwrap();
        assert_eq!(deadline.judge(&hops([-3.0, 50.0, 5.0, 900.0, 9.0, 60.0])).unwrap().hop, "detect");
    }

    #[test]
    fn impossible_deadlines_are_refused_with_what_is_allowed() {
        for limit_ms in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            let refusal = Deadline::new(limit_ms).err().unwrap().to_string();
            assert!(refusal.contains("from 0.001 to 3600000"), "{refusal}");
        }
    }
}
