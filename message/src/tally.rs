//! Durations of some frames, which are counted together.
//!
//! Histograms are scattered over more memory than a core's caches keep beside the pixels of a frame, so that counting in them
//! frame by frame would mean waiting for memory at every hop. A row of durations takes a cache line or two; once the rows are
//! full, or are to be published, all are counted, and most of them find their bucket near.

use crate::histogram::Histogram;

/// Frames that are kept.
const ROWS: usize = 32;
/// In place of a duration: the hop is not known for this frame.
pub const UNKNOWN: u64 = u64::MAX;
/// In place of a duration: the hop ended before it began.
const BACKWARDS: u64 = u64::MAX - 1;

/// The time from one stamp to another, both of one clock in nanoseconds.
#[must_use]
pub fn between(from_ns: u64, to_ns: u64) -> u64 {
    to_ns.checked_sub(from_ns).unwrap_or(BACKWARDS)
}

/// Durations of the hops of some frames.
#[derive(Debug)]
pub struct Tally<const HOPS: usize> {
    rows: Box<[[u64; HOPS]; ROWS]>,
    filled: usize,
}

impl<const HOPS: usize> Default for Tally<HOPS> {
    fn default() -> Self {
        Self { rows: Box::new([[UNKNOWN; HOPS]; ROWS]), filled: 0 }
    }
}

impl<const HOPS: usize> Tally<HOPS> {
    /// Keeps the durations of a frame, made by [`between`] or [`UNKNOWN`]; counts all once there are many.
    pub fn frame(&mut self, durations_ns: [u64; HOPS], hops: &mut [Histogram; HOPS]) {
        self.rows[self.filled] = durations_ns;
        self.filled += 1;
        if self.filled == ROWS {
            self.count(hops);
        }
    }

    /// Counts what is kept.
    pub fn count(&mut self, hops: &mut [Histogram; HOPS]) {
        let rows = &self.rows[..self.filled];
        for (place, hop) in hops.iter_mut().enumerate() {
            for row in rows {
                match row[place] {
                    UNKNOWN => {}
                    BACKWARDS => hop.backwards += 1,
                    duration_ns => hop.count(duration_ns),
                }
            }
        }
        self.filled = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_is_counted_once_whether_the_rows_are_full_or_not() {
        let mut tally = Tally::<2>::default();
        let mut hops = [Histogram::default(), Histogram::default()];
        for frame in 0..100 {
            let second = if frame % 2 == 0 { UNKNOWN } else { between(frame, 3 * frame) };
            tally.frame([between(frame, frame + 5_000), second], &mut hops);
        }
        tally.frame([between(9, 8), between(0, 0)], &mut hops);
        tally.count(&mut hops);
        tally.count(&mut hops);
        assert_eq!((hops[0].count, hops[0].backwards, hops[0].sum_ns), (100, 1, 500_000));
        assert_eq!((hops[1].count, hops[1].backwards, hops[1].max_ns), (51, 0, 198));
        assert!(hops.iter().all(Histogram::is_sound));
    }
}
