//! Durations, counted in buckets that are equally fine everywhere in proportion.
//!
//! ```text
//! bucket   0          1 ... 32                 33 ... 64                          833
//! holds    < 1.024 us | 1.024 us to 2.048 us   | 2.048 us to 4.096 us  | ...      | from 68.7 s on
//!                       in 32 equal steps        in 32 equal steps
//! ```
//!
//! A duration is told from its bucket to within a thirty-second, 3 %; count, sum, smallest and largest are exact.

use iceoryx2::prelude::ZeroCopySend;

/// Steps of an octave.
const STEPS: usize = 32;
const STEP_BITS: u32 = STEPS.trailing_zeros();
/// The first octave begins at 2 to this power of nanoseconds.
const FIRST_OCTAVE: u32 = 10;
/// The octave after the last one begins at 2 to this power of nanoseconds.
const END_OCTAVE: u32 = 36;
/// Buckets: those of the octaves, one for what is shorter and one for what is longer.
pub const BUCKETS: usize = (END_OCTAVE - FIRST_OCTAVE) as usize * STEPS + 2;

/// Durations of one hop, counted by one writer. Others read copies.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.Histogram.v1")]
pub struct Histogram {
    /// Durations counted.
    pub count: u64,
    /// Their sum, nanoseconds.
    pub sum_ns: u64,
    /// The shortest, nanoseconds; 0 when there is none.
    pub min_ns: u64,
    /// The longest, nanoseconds.
    pub max_ns: u64,
    /// Ends that lay before their beginnings, and stamps that cannot be right: a clock that lies. They are not counted elsewhere.
    pub backwards: u64,
    /// How many durations each bucket holds.
    pub buckets: [u32; BUCKETS],
}

const _: () = assert!(size_of::<Histogram>() == 40 + 4 * BUCKETS);

impl Default for Histogram {
    fn default() -> Self {
        Self { count: 0, sum_ns: 0, min_ns: 0, max_ns: 0, backwards: 0, buckets: [0; BUCKETS] }
    }
}

/// The bucket of a duration.
fn bucket(duration_ns: u64) -> usize {
    let octave = 63 - (duration_ns | 1).leading_zeros();
    if octave < FIRST_OCTAVE {
        return 0;
    }
    if octave >= END_OCTAVE {
        return BUCKETS - 1;
    }
    // The bits behind the first one say which step of the octave it is.
    let step = (duration_ns >> (octave - STEP_BITS)) as usize % STEPS;
    1 + (octave - FIRST_OCTAVE) as usize * STEPS + step
}

/// Where a bucket begins, nanoseconds. The bucket behind the last one begins where everything ends.
fn begin_ns(bucket: usize) -> u64 {
    match bucket {
        0 => 0,
        BUCKETS.. => u64::MAX,
        _ => {
            let (octave, step) = ((bucket - 1) / STEPS, (bucket - 1) % STEPS);
            ((STEPS + step) as u64) << (octave as u32 + FIRST_OCTAVE - STEP_BITS)
        }
    }
}

impl Histogram {
    /// Counts the time from one stamp to another, both of one clock in nanoseconds.
    pub fn record(&mut self, from_ns: u64, to_ns: u64) {
        match to_ns.checked_sub(from_ns) {
            Some(duration_ns) => self.count(duration_ns),
            None => self.backwards += 1,
        }
    }

    /// Counts a duration.
    pub fn count(&mut self, duration_ns: u64) {
        self.min_ns = if self.count == 0 { duration_ns } else { self.min_ns.min(duration_ns) };
        self.max_ns = self.max_ns.max(duration_ns);
        self.count += 1;
        self.sum_ns = self.sum_ns.saturating_add(duration_ns);
        let bucket = &mut self.buckets[bucket(duration_ns)];
        *bucket = bucket.wrapping_add(1);
    }

    /// Whether the numbers agree with each other, as those of a message have to before they are believed.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let counted = self.buckets.iter().map(|&held| u64::from(held)).sum::<u64>();
        counted == self.count && self.min_ns <= self.max_ns
    }

    /// The mean, nanoseconds; `None` when nothing was counted.
    #[must_use]
    pub fn mean_ns(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum_ns as f64 / self.count as f64)
    }

    /// The duration that a share of all are not longer than, nanoseconds: 0.5 is the median. `None` when nothing was counted.
    ///
    /// Within its bucket durations are taken for evenly spread; the shortest and the longest are limits.
    #[must_use]
    pub fn quantile_ns(&self, share: f64) -> Option<f64> {
        if self.count == 0 {
            return None;
        }
        let wanted = share.clamp(0.0, 1.0) * self.count as f64;
        let mut before = 0.0;
        for (number, &held) in self.buckets.iter().enumerate().filter(|(_, held)| **held > 0) {
            let held = f64::from(held);
            if before + held >= wanted {
                let (begin, end) = (begin_ns(number) as f64, begin_ns(number + 1) as f64);
                let at = begin + (end - begin) * ((wanted - before) / held);
                return Some(at.clamp(self.min_ns as f64, self.max_ns as f64));
            }
            before += held;
        }
        Some(self.max_ns as f64)
    }

    /// How many durations are not longer than that, as far as whole buckets tell.
    #[must_use]
    pub fn count_up_to(&self, duration_ns: u64) -> u64 {
        let whole = (0..BUCKETS).take_while(|&number| begin_ns(number + 1) <= duration_ns);
        whole.map(|number| u64::from(self.buckets[number])).sum()
    }

    /// What was counted since an earlier copy of the same histogram. Of its shortest and longest only the buckets are known, so
    /// their limits stand for them. A copy that is not an earlier one, because its writer began anew, counts as empty.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        let is_earlier = earlier.count <= self.count
            && earlier.sum_ns <= self.sum_ns
            && self.buckets.iter().zip(&earlier.buckets).all(|(now, then)| then <= now);
        if !is_earlier || earlier.count == 0 {
            return *self;
        }
        let mut since = Self {
            count: self.count - earlier.count,
            sum_ns: self.sum_ns - earlier.sum_ns,
            backwards: self.backwards.saturating_sub(earlier.backwards),
            buckets: std::array::from_fn(|number| self.buckets[number] - earlier.buckets[number]),
            ..Self::default()
        };
        let first = since.buckets.iter().position(|&held| held > 0);
        let last = since.buckets.iter().rposition(|&held| held > 0);
        since.min_ns = first.map_or(0, begin_ns).max(self.min_ns);
        // A histogram that lies about its limits must not make the difference contradict itself.
        since.max_ns = last.map_or(0, |last| begin_ns(last + 1).min(self.max_ns)).max(since.min_ns);
        since
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn every_duration_lies_in_its_bucket_and_no_bucket_is_wider_than_a_thirty_second() {
        for shift in 0..64 {
            for duration_ns in [1u64 << shift, (1 << shift) - 1, (1 << shift) | (1 << shift) >> 3] {
                let number = bucket(duration_ns);
                let (begin, end) = (begin_ns(number), begin_ns(number + 1));
                assert!(
                    begin <= duration_ns && (duration_ns < end || number == BUCKETS - 1),
                    "{duration_ns}"
                );
                if (1..BUCKETS - 1).contains(&number) {
                    assert!((end - begin) * STEPS as u64 <= begin, "{number}: {begin} to {end}");
                }
            }
        }
        assert_eq!((bucket(0), bucket(u64::MAX)), (0, BUCKETS - 1));
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_durations_within_a_thirty_second() {
        let mut random = Random::new(7);
        let mut all: Vec<u64> = (0..5000).map(|_| 2_000 + random.next() % 50_000_000).collect();
        let mut histogram = Histogram::default();
        all.iter().for_each(|&duration| histogram.count(duration));
        all.sort_unstable();
        for share in [0.01, 0.5, 0.95, 0.99, 1.0] {
            let exact = all[((all.len() as f64 * share).ceil() as usize).max(1) - 1] as f64;
            let told = histogram.quantile_ns(share).unwrap();
            assert!((told - exact).abs() <= exact / 16.0, "{share}: {told} and {exact}");
        }
        assert_eq!(histogram.quantile_ns(1.0), Some(all[4999] as f64));
        assert!(histogram.is_sound());
        assert_eq!(Histogram::default().quantile_ns(0.5), None);
    }

    #[test]
    fn an_end_before_its_beginning_is_a_fault_of_a_clock_and_no_duration() {
        let mut histogram = Histogram::default();
        histogram.record(10, 9);
        assert_eq!((histogram.count, histogram.backwards), (0, 1));
        histogram.record(10, 10);
        assert_eq!((histogram.count, histogram.min_ns, histogram.max_ns), (1, 0, 0));
    }

    #[test]
    fn what_came_since_a_copy_is_told_alone_and_a_writer_that_began_anew_is_taken_whole() {
        let mut histogram = Histogram::default();
        (0..10).for_each(|_| histogram.count(1_000_000));
        let earlier = histogram;
        (0..20).for_each(|_| histogram.count(5_000_000));
        let since = histogram.since(&earlier);
        assert_eq!((since.count, since.sum_ns), (20, 100_000_000));
        assert!(since.is_sound() && since.min_ns > 4_800_000 && since.max_ns <= 5_000_000, "{since:?}");
        let mut anew = Histogram::default();
        anew.count(3_000);
        assert_eq!(anew.since(&histogram), anew);
    }

    #[test]
    fn durations_up_to_a_limit_are_counted() {
        let mut histogram = Histogram::default();
        [500, 3_000, 900_000, 2_000_000].into_iter().for_each(|duration| histogram.count(duration));
        assert_eq!(
            [1_024, 4_096, 1_048_576, u64::MAX].map(|limit| histogram.count_up_to(limit)),
            [1, 2, 3, 4]
        );
    }
}
