//! What arrives at the clients, and waiting for it.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::moment::{Moment, boot_ns};

/// The first detection of one camera process and one detector process at one client process.
#[derive(Clone, Copy, Debug)]
struct First {
    client: usize,
    process: u32,
    camera_epoch: u64,
    detector_epoch: u64,
    at_ns: u64,
}

/// From whom detections are waited for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wanted {
    /// The camera was started after this (wall clock, nanoseconds).
    pub(super) camera_after: u64,
    /// The detector was started after this (`CLOCK_MONOTONIC`, nanoseconds).
    pub(super) detector_after: u64,
}

impl Wanted {
    /// Of a camera that was started after this moment.
    pub(super) fn camera_after(moment: Moment) -> Self {
        Self { camera_after: moment.wall_ns, ..Self::default() }
    }

    /// Of a detector that was started after this moment.
    pub(super) fn detector_after(moment: Moment) -> Self {
        Self { detector_after: moment.monotonic_ns, ..Self::default() }
    }

    /// Of both.
    pub(super) fn both_after(moment: Moment) -> Self {
        Self { camera_after: moment.wall_ns, detector_after: moment.monotonic_ns }
    }

    fn is(&self, first: &First) -> bool {
        first.camera_epoch > self.camera_after && first.detector_epoch > self.detector_after
    }
}

#[derive(Default)]
struct Seen {
    firsts: Vec<First>,
    /// Messages with tags, of each client.
    counts: Vec<u64>,
}

/// Shared by the threads that read the clients' lines.
#[derive(Clone, Default)]
pub(super) struct Arrivals(Arc<(Mutex<Seen>, Condvar)>);

impl Arrivals {
    /// Takes a line of `watch --json`; an empty list of detections does not count, and neither does a line that was cut off by the
    /// end of its process.
    pub(super) fn take(&self, client: usize, process: u32, line: &str) {
        let at_ns = boot_ns();
        let Some((camera_epoch, detector_epoch)) = epochs(line) else { return };
        let (mut seen, changed) = (self.lock(), &self.0.1);
        if seen.counts.len() <= client {
            seen.counts.resize(client + 1, 0);
        }
        seen.counts[client] += 1;
        let last = seen.firsts.iter().rfind(|first| first.client == client && first.process == process);
        if last.is_none_or(|last| (last.camera_epoch, last.detector_epoch) != (camera_epoch, detector_epoch))
        {
            seen.firsts.push(First { client, process, camera_epoch, detector_epoch, at_ns });
            changed.notify_all();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Seen> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// When the first wanted detection arrived at each of these processes of clients (`CLOCK_BOOTTIME`, nanoseconds), in their
    /// order; waits for all of them. The error says who got none.
    pub(super) fn wait(
        &self,
        wanted: Wanted,
        processes: &[u32],
        patience: Duration,
    ) -> Result<Vec<u64>, String> {
        let times = |seen: &Seen| -> Vec<Option<u64>> {
            let first = |&process: &u32| {
                seen.firsts.iter().find(|first| first.process == process && wanted.is(first))
            };
            processes.iter().map(|process| first(process).map(|first| first.at_ns)).collect()
        };
        let missing = |seen: &mut Seen| times(seen).contains(&None);
        let (seen, _) = (self.0.1)
            .wait_timeout_while(self.lock(), patience, missing)
            .unwrap_or_else(PoisonError::into_inner);
        let times = times(&seen);
        if times.contains(&None) {
            return Err(format!(
                "no detection of {wanted:?} at some of the clients {processes:?}: {times:?}"
            ));
        }
        Ok(times.into_iter().flatten().collect())
    }

    /// Waits for one more detection at each of so many clients.
    pub(super) fn wait_for_more(&self, clients: usize, patience: Duration) -> Result<(), String> {
        let before = self.lock().counts.clone();
        let started = Instant::now();
        let count = |counts: &[u64], client: usize| counts.get(client).copied().unwrap_or(0);
        loop {
            let now = self.lock().counts.clone();
            let silent = (0..clients).find(|&client| count(&now, client) <= count(&before, client));
            let Some(client) = silent else { return Ok(()) };
            if started.elapsed() > patience {
                return Err(format!("nothing more arrives at client {client}"));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Starts of camera and detector, of a line with detections.
fn epochs(line: &str) -> Option<(u64, u64)> {
    let line: Value = serde_json::from_str(line).ok()?;
    if line["detections"].as_array()?.is_empty() {
        return None;
    }
    Some((line["camera_epoch"].as_u64()?, line["detector_epoch"].as_u64()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(camera: u64, detector: u64, tags: &str) -> String {
        format!(r#"{{"camera_epoch":{camera},"detector_epoch":{detector},"detections":[{tags}]}}"#)
    }

    #[test]
    fn only_a_detection_of_those_who_were_started_later_is_waited_for() {
        let arrivals = Arrivals::default();
        arrivals.take(0, 7, &line(10, 20, "{}"));
        arrivals.take(0, 7, &line(11, 20, ""));
        let newer = Wanted { camera_after: 10, detector_after: 0 };
        let wait = |wanted| arrivals.wait(wanted, &[7], Duration::from_millis(1));
        assert_eq!(wait(Wanted::default()).unwrap().len(), 1);
        assert!(wait(newer).is_err());
        arrivals.take(0, 7, &line(11, 20, "{}"));
        assert_eq!(wait(newer).unwrap().len(), 1);
        assert!(arrivals.wait(newer, &[7, 8], Duration::from_millis(1)).unwrap_err().contains("None"));
    }

    #[test]
    fn lines_that_were_cut_off_count_for_nothing() {
        let arrivals = Arrivals::default();
        arrivals.take(0, 7, &line(10, 20, "{}")[..30]);
        assert!(arrivals.wait(Wanted::default(), &[7], Duration::from_millis(1)).is_err());
    }
}
