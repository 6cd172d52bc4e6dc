//! When the next frame is due.

use std::time::{Duration, Instant};

use tagbus_message::stop::Stop;

use crate::config::Pace;

/// A camera sleeps no longer without looking whether somebody asks it something.
const LONGEST_SLEEP: Duration = Duration::from_millis(50);

/// Due times on a fixed grid: an early or late frame does not shift those that follow.
#[derive(Debug)]
pub(crate) struct Pacer {
    period: Duration,
    due: Instant,
}

impl Pacer {
    /// The first frame is due at `start`.
    pub(crate) fn new(pace: Pace, start: Instant) -> Pacer {
        let period =
            pace.framerate().map_or(Duration::ZERO, |framerate| Duration::from_secs_f64(1.0 / framerate));
        Pacer { period, due: start }
    }

    /// Nominal time from frame to frame; zero without a rate.
    pub(crate) fn period(&self) -> Duration {
        self.period
    }

    /// Sleeps until the next frame is due or a stop is asked for; says whether a stop was asked for. During a long sleep
    /// `meanwhile` is called now and then.
    pub(crate) fn wait(&mut self, stop: &Stop, mut meanwhile: impl FnMut()) -> bool {
        let begun = Instant::now();
        let pause = self.next_pause(begun);
        if pause.is_zero() {
            return stop.is_triggered();
        }
        loop {
            let left = pause.saturating_sub(begun.elapsed());
            if stop.wait(left.min(LONGEST_SLEEP)) {
                return true;
            }
            if left <= LONGEST_SLEEP {
                return false;
            }
            meanwhile();
        }
    }

    /// Time from `now` until the next frame is due, and the step to the one after it.
    ///
    /// Whoever is more than a period late starts a new grid: frames that were missed are not sent in a burst.
    fn next_pause(&mut self, now: Instant) -> Duration {
        if now > self.due + self.period {
            self.due = now;
        }
        let pause = self.due.saturating_duration_since(now);
        self.due += self.period;
        pause
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(10);

    #[test]
    fn due_times_lie_on_the_grid_however_late_within_a_period_each_frame_was() {
        let start = Instant::now();
        let mut pacer = Pacer::new(Pace::Framerate(100.0), start);
        let mut now = start;
        for frame in 0..100_u32 {
            now += pacer.next_pause(now);
            assert_eq!(now, start + PERIOD * frame);
            now += Duration::from_micros(u64::from(frame * 37 % 9) * 1000);
        }
    }

    #[test]
    fn after_a_long_delay_frames_are_not_sent_in_a_burst() {
        let start = Instant::now();
        let mut pacer = Pacer::new(Pace::Framerate(100.0), start);
        let late = start + Duration::from_secs(5);
        assert_eq!(pacer.next_pause(late), Duration::ZERO);
        assert_eq!(pacer.next_pause(late), PERIOD);
    }

    #[test]
    fn as_fast_as_possible_never_pauses() {
        let mut pacer = Pacer::new(Pace::AsFastAsPossible, Instant::now());
        assert!((0..100).all(|_| pacer.next_pause(Instant::now()).is_zero()));
    }

    #[test]
    fn a_stop_ends_the_longest_pause() {
        let stop = Stop::new().unwrap();
        let mut pacer = Pacer::new(Pace::Framerate(1e-6), Instant::now());
        assert!(!pacer.wait(&stop, || ()));
        let trigger = stop.clone();
        let thread = std::thread::spawn(move || trigger.trigger());
        assert!(pacer.wait(&stop, || ()));
        thread.join().unwrap();
    }
}
