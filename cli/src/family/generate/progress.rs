//! The progress bar of a search.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use tagbus_family::search::Progress;

/// Parts of the whole that the bar tells apart.
const STEPS: u64 = 10_000;

/// Shown on a terminal only.
pub(super) struct Bar {
    bar: ProgressBar,
    /// The codes that are wanted, where that is known.
    codes: Option<usize>,
    begun: Instant,
    /// What was looked at when this phase began.
    first: Option<Progress>,
}

impl Bar {
    pub(super) fn new(codes: Option<usize>) -> Bar {
        let bar = ProgressBar::new(STEPS);
        // The template is a constant that is tried by every search.
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}") {
            bar.set_style(style);
        }
        Bar { bar, codes, begun: Instant::now(), first: None }
    }

    pub(super) fn show(&mut self, progress: Progress) {
        if self.first.is_none_or(|first| first.sweeping != progress.sweeping) {
            (self.first, self.begun) = (Some(progress), Instant::now());
        }
        let first = self.first.unwrap_or(progress);
        let seconds = self.begun.elapsed().as_secs_f64();
        let rate = (progress.looked_at - first.looked_at) as f64 / seconds.max(1e-3);
        self.bar.set_position((self.done(progress) * STEPS as f64) as u64);
        self.bar.set_message(message(progress, rate, self.left(progress, rate)));
    }

    /// By candidates, or by codes where a number of these is wanted and no sweep brings them all at once.
    fn done(&self, progress: Progress) -> f64 {
        let by_codes =
            self.codes.filter(|_| !progress.sweeping).map(|codes| progress.codes as f64 / codes as f64);
        by_codes.unwrap_or(progress.looked_at as f64 / progress.total as f64)
    }

    /// Nobody knows how many candidates the next code takes, so time is told by candidates only.
    fn left(&self, progress: Progress, rate: f64) -> Option<Duration> {
        let is_known = (self.codes.is_none() || progress.sweeping) && rate > 0.0;
        let seconds = (progress.total - progress.looked_at) as f64 / rate;
        is_known.then(|| Duration::try_from_secs_f64(seconds).ok()).flatten()
    }

    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

fn message(progress: Progress, rate: f64, left: Option<Duration>) -> String {
    let phase = if progress.sweeping { "all at once" } else { "in order" };
    let left = left.map_or(String::new(), |left| format!(", {} left", indicatif::HumanDuration(left)));
    format!("{phase}: {} codes, {:.1} million candidates/s{left}", progress.codes, rate / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_phase_codes_rate_and_time_left() {
        let progress = Progress { codes: 17, looked_at: 1000, total: 5000, sweeping: false };
        let text = message(progress, 2e6, Some(Duration::from_secs(30)));
        assert_eq!(text, "in order: 17 codes, 2.0 million candidates/s, 30 seconds left");
        assert!(
            message(Progress { sweeping: true, ..progress }, 2e6, None).starts_with("all at once: 17 codes")
        );
    }
}
