//! When a role answers requests: at once where there are few, and never so many that frames would notice.

use std::time::{Duration, Instant};

/// Requests take at most this part of the time, however many there are: after a round of answers they wait so many times as long as it
/// took ...
const SHARE: u32 = 20;
/// ... this long at least ...
const SHORTEST_PAUSE: Duration = Duration::from_millis(5);
/// ... and never longer.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// So many rounds are held as soon as they are wanted. A detector of small frames needs a fiftieth of a core: a flood that takes a
/// twentieth of the time would make it take three times as much.
const AT_ONCE: u32 = 50;
/// After that they come so often: each client has an answer in each.
const REFILL: Duration = Duration::from_millis(100);

/// The rounds in which a role answers one request of each client.
#[derive(Debug)]
pub struct Turns {
    paused_until: Option<Instant>,
    /// Rounds that may be held at once.
    left: u32,
    /// When one was last given back.
    refilled: Instant,
}

impl Default for Turns {
    fn default() -> Self {
        Self::new()
    }
}

impl Turns {
    /// Nothing was answered yet.
    #[must_use]
    pub fn new() -> Self {
        Self { paused_until: None, left: AT_ONCE, refilled: Instant::now() }
    }

    /// How long until a round may be held; `None` when it may be held now.
    #[must_use]
    pub fn pause(&self, now: Instant) -> Option<Duration> {
        self.paused_until.map(|end| end.saturating_duration_since(now))
    }

    /// Whether a round may be held now; ends a pause that is over.
    pub fn may_answer(&mut self, now: Instant) -> bool {
        if self.paused_until.is_some_and(|end| now < end) {
            return false;
        }
        self.paused_until = None;
        true
    }

    /// Takes note of a round that began at `begin` and ends now, also of one for which somebody called and nobody asked.
    pub fn answered(&mut self, begin: Instant, now: Instant) {
        let refills = now.saturating_duration_since(self.refilled).as_millis() / REFILL.as_millis();
        if refills > 0 {
            self.left = u32::try_from(refills).unwrap_or(u32::MAX).saturating_add(self.left).min(AT_ONCE);
            self.refilled = now;
        }
        let took = now.saturating_duration_since(begin);
        let mut pause = (took * SHARE).clamp(SHORTEST_PAUSE, LONGEST_PAUSE);
        match self.left.checked_sub(1) {
            Some(left) => self.left = left,
            None => {
                pause = pause.max(REFILL);
                // That pause is the price of this round and pays for no other.
                self.refilled = now + pause;
            }
        }
        self.paused_until = Some(now + pause);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds in so many seconds of somebody who asks again as soon as he may; each takes this long.
    fn rounds(seconds: u64, took: Duration) -> u32 {
        let mut turns = Turns::new();
        let begin = Instant::now();
        let (end, mut now, mut count) = (begin + Duration::from_secs(seconds), begin, 0);
        while now < end {
            assert!(turns.may_answer(now));
            turns.answered(now, now + took);
            now += took;
            assert!(!turns.may_answer(now));
            now += turns.pause(now).unwrap();
            count += 1;
        }
        count
    }

    #[test]
    fn a_few_requests_are_answered_at_once_and_a_flood_ten_times_a_second() {
        let quick = Duration::from_micros(50);
        assert!(rounds(1, quick) > AT_ONCE);
        let more = rounds(20, quick) - rounds(10, quick);
        assert!((95..=101).contains(&more), "{more} in ten seconds");
    }

    #[test]
    fn what_takes_long_takes_its_part_of_the_time_only() {
        let count = rounds(60, Duration::from_millis(20));
        assert!((60_000 / 420 - 1..=60_000 / 420 + 1).contains(&count), "{count}");
        assert!(rounds(60, Duration::from_secs(2)) <= 21);
    }

    #[test]
    fn who_asks_seldom_never_waits() {
        let mut turns = Turns::new();
        let mut now = Instant::now();
        for _ in 0..1000 {
            assert!(turns.may_answer(now));
            turns.answered(now, now);
            assert_eq!(turns.pause(now), Some(SHORTEST_PAUSE));
            now += REFILL;
        }
    }
}
