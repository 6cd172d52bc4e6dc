//! The last copies of what one role counts.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use tagbus_message::histogram::Histogram;
use tagbus_message::stats::{CameraStats, ClientStats, DetectorStats, Stats};

use super::process::Process;

/// The time over which rates and hops are told.
pub(super) const WINDOW: Duration = Duration::from_secs(5);
/// A copy that is older says that its role does not carry on. Roles publish one every half a second.
pub(super) const STALE: Duration = Duration::from_millis(1500);
/// How long a role that is gone is still shown.
const SHOWN_GONE: Duration = Duration::from_secs(10);
/// Rates are taken of copies that lie at least so far from each other.
const SHORTEST: Duration = Duration::from_millis(300);

/// What all roles count.
pub(super) trait Counted: Stats {
    /// Another number at each start.
    fn epoch(&self) -> u64;
    /// The process.
    fn process(&self) -> u32;
    /// When it began, monotonic nanoseconds.
    fn started_ns(&self) -> u64;
    /// When the copy was written, monotonic nanoseconds.
    fn written_ns(&self) -> u64;
    /// What grows while it does what it is for: frames, or messages.
    fn progress(&self) -> u64;

    /// The histograms.
    fn hops(&self) -> &[Histogram] {
        self.parts().1
    }
}

macro_rules! counted {
    ($type:ty, $progress:ident) => {
        impl Counted for $type {
            fn epoch(&self) -> u64 {
                self.epoch
            }
            fn process(&self) -> u32 {
                self.process
            }
            fn started_ns(&self) -> u64 {
                self.started_ns
            }
            fn written_ns(&self) -> u64 {
                self.written_ns
            }
            fn progress(&self) -> u64 {
                self.$progress
            }
        }
    };
}

counted!(CameraStats, frames);
counted!(DetectorStats, messages);
counted!(ClientStats, received);

/// How a role is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Life {
    /// It speaks.
    Alive,
    /// Its process is there, but it does not speak.
    Silent,
    /// Its process was stopped by a signal or a debugger.
    Halted,
    /// Its process has gone, or it has left the bus.
    Gone,
}

/// A role's copies of the last seconds, all of one start of it.
#[derive(Debug)]
pub(super) struct Track<T> {
    copies: VecDeque<T>,
    publisher: u128,
    moved_ns: u64,
    life: Life,
    gone_ns: u64,
}

impl<T: Counted> Track<T> {
    /// Begins with the first copy.
    pub(super) fn new(publisher: u128, copy: T) -> Self {
        let moved_ns = copy.written_ns();
        Self { copies: VecDeque::from([copy]), publisher, moved_ns, life: Life::Alive, gone_ns: 0 }
    }

    /// Takes a copy, unless it is no newer than those that are known.
    pub(super) fn take(&mut self, publisher: u128, copy: T) {
        let last = self.last();
        if copy.epoch() != last.epoch() {
            if copy.started_ns() >= last.started_ns() {
                *self = Self::new(publisher, copy);
            }
            return;
        }
        if copy.written_ns() <= last.written_ns() {
            return;
        }
        if copy.progress() != last.progress() {
            self.moved_ns = copy.written_ns();
        }
        self.publisher = publisher;
        self.copies.push_back(copy);
        self.forget();
    }

    /// What is older than the window is needed no more.
    fn forget(&mut self) {
        let from_ns = self.last().written_ns().saturating_sub(ns(WINDOW + STALE / 5));
        while self.copies.len() > 2 && self.copies[0].written_ns() < from_ns {
            self.copies.pop_front();
        }
    }

    /// The last copy.
    pub(super) fn last(&self) -> &T {
        self.copies.back().expect("a track begins with a copy and keeps two")
    }

    /// The first and the last copy of the window, where there are two.
    pub(super) fn window(&self) -> Option<(&T, &T)> {
        let (first, last) = (&self.copies[0], self.last());
        (last.written_ns() - first.written_ns() >= ns(SHORTEST)).then_some((first, last))
    }

    /// When the first of the copies was written of which this holds.
    pub(super) fn first_written(&self, holds: impl Fn(&T) -> bool) -> Option<u64> {
        self.copies.iter().find(|copy| holds(copy)).map(Counted::written_ns)
    }

    /// How much a count grew in a second, on the average of the window.
    pub(super) fn rate(&self, count: impl Fn(&T) -> u64) -> Option<f64> {
        let (first, last) = self.window()?;
        let seconds = (last.written_ns() - first.written_ns()) as f64 / 1e9;
        Some(count(last).saturating_sub(count(first)) as f64 / seconds)
    }

    /// A hop in the window; since the role's start as long as there is none.
    pub(super) fn hop(&self, number: usize) -> Histogram {
        let now = self.last().hops()[number];
        match self.window() {
            Some((first, _)) if first.hops()[number].count < now.count => now.since(&first.hops()[number]),
            Some((first, _)) if first.hops()[number].count > 0 => Histogram::default(),
            _ => now,
        }
    }

    /// Looks at what has become of the role.
    pub(super) fn judge(&mut self, publishers: Option<&BTreeMap<u128, u32>>, now_ns: u64) {
        let left = publishers.is_some_and(|publishers| !publishers.contains_key(&self.publisher));
        let life = match self.age(now_ns) >= STALE {
            _ if left => Life::Gone,
            false => Life::Alive,
            true => match Process::of(self.last().process()) {
                Process::There => Life::Silent,
                Process::Halted => Life::Halted,
                Process::Gone => Life::Gone,
            },
        };
        if life == Life::Gone && self.life != Life::Gone {
            self.gone_ns = now_ns;
        }
        self.life = life;
    }

    /// How the role was when it was looked at.
    pub(super) fn life(&self) -> Life {
        self.life
    }

    /// Whether it is shown; what is gone long enough is not.
    pub(super) fn is_shown(&self, now_ns: u64) -> bool {
        self.life != Life::Gone || now_ns.saturating_sub(self.gone_ns) < ns(SHOWN_GONE)
    }

    /// The place that the last copy came from.
    pub(super) fn publisher(&self) -> u128 {
        self.publisher
    }

    /// How old the last copy is.
    pub(super) fn age(&self, now_ns: u64) -> Duration {
        Duration::from_nanos(now_ns.saturating_sub(self.last().written_ns()))
    }

    /// How long its progress has not moved, as far as the copies tell.
    pub(super) fn resting(&self, now_ns: u64) -> Duration {
        Duration::from_nanos(now_ns.saturating_sub(self.moved_ns))
    }
}

fn ns(duration: Duration) -> u64 {
    duration.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn copy(written_ms: u64, frames: u64) -> CameraStats {
        let mut copy =
            CameraStats { epoch: 1, written_ns: written_ms * 1_000_000, frames, ..CameraStats::default() };
        (0..frames).for_each(|frame| copy.hops[1].count(1_000_000 + frame * 10_000));
        copy
    }

    #[test]
    fn rates_and_hops_are_those_of_the_last_seconds() {
        let mut track = Track::new(5, copy(1_000, 30));
        assert_eq!((track.rate(|copy| copy.frames), track.hop(1).count), (None, 30));
        (1..=20).for_each(|step| track.take(5, copy(1_000 + step * 500, 30 + step * 15)));
        assert_eq!(track.rate(|copy| copy.frames), Some(30.0));
        let hop = track.hop(1);
        assert_eq!(hop.count, 150);
        assert!(hop.min_ns > 2_500_000, "{} ns is of a frame before", hop.min_ns);
        assert_eq!(track.hop(0).count, 0);
    }

    #[test]
    fn a_copy_again_and_one_of_an_earlier_start_change_nothing_and_a_new_start_begins_anew() {
        let mut track = Track::new(5, CameraStats { started_ns: 10, ..copy(1_000, 3) });
        track.take(5, copy(1_000, 9));
        track.take(4, CameraStats { epoch: 7, started_ns: 9, ..copy(2_000, 9) });
        assert_eq!(track.last().frames, 3);
        track.take(6, CameraStats { epoch: 8, started_ns: 11, ..copy(3_000, 1) });
        assert_eq!((track.last().frames, track.rate(|copy| copy.frames)), (1, None));
    }

    #[test]
    fn an_old_copy_is_silence_of_a_process_that_is_there_and_the_end_of_one_that_is_not() {
        let mut track = Track::new(5, copy(1_000, 3));
        let mut life = |now_ms: u64, publishers: &[u128]| {
            track.judge(
                Some(&publishers.iter().map(|&publisher| (publisher, 0)).collect()),
                now_ms * 1_000_000,
            );
            (track.life(), track.is_shown(now_ms * 1_000_000))
        };
        assert_eq!(life(2_499, &[5]), (Life::Alive, true));
        assert_eq!(life(2_500, &[5]), (Life::Silent, true));
        assert_eq!(life(2_600, &[4]), (Life::Gone, true));
        assert_eq!(life(12_600, &[]), (Life::Gone, false));
        let mut killed = Track::new(5, CameraStats { process: 1 << 30, ..copy(1_000, 3) });
        killed.judge(None, 2_500_000_000);
        assert_eq!(killed.life(), Life::Gone);
    }
}
