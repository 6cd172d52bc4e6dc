//! What must not have happened.

use std::ops::Range;

use super::run::{Look, Outcome, Plan};
use crate::crowd::{Part, Temper};

/// Looks whose median is the begin, and as many for the end.
const LOOKS_OF_A_MEDIAN: usize = 5;
/// Memory that a process may have more at the end, KiB: 16 pages, such as of a stack that was never so deep. At 200 frames a
/// second for 30 minutes a fifth of a byte a frame would be more.
const TOLERATED_KIB: u64 = 64;
/// Bytes of shared memory that may have been written for the first time after the warm-up. All of it was reserved at the start, and
/// what was reserved must not change; but how many chunks were ever used at once depends on the worst moment of a machine.
const TOLERATED_TOUCHED: u64 = 512 * 1024;

/// A figure at the begin (after the warm-up) and at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Change {
    pub(super) begin: u64,
    pub(super) end: u64,
}

impl Change {
    /// How much more it is at the end.
    pub(super) fn growth(self) -> u64 {
        self.end.saturating_sub(self.begin)
    }
}

/// Medians of what comes after the warm-up.
pub(super) fn change(plan: &Plan, looks: &[Look], figure: impl Fn(&Look) -> u64) -> Change {
    let warm = looks.iter().position(|look| look.seconds > plan.warm_up().as_secs_f64()).unwrap_or(0);
    let middle = |range: Range<usize>| {
        let mut figures: Vec<u64> = looks[range].iter().map(&figure).collect();
        figures.sort_unstable();
        figures.get(figures.len() / 2).copied().unwrap_or(0)
    };
    let count = LOOKS_OF_A_MEDIAN.min(looks.len() - warm);
    Change { begin: middle(warm..warm + count), end: middle(looks.len() - count..looks.len()) }
}

/// Everything that is wrong, in words; empty when all is well.
pub(crate) fn faults(plan: &Plan, outcome: &Outcome) -> Vec<String> {
    let mut faults = Vec::new();
    for (place, part) in outcome.parts.iter().enumerate() {
        let of = |figure: fn(&super::usage::Usage) -> u64| {
            change(plan, &outcome.looks, |look| figure(&look.usages[place]))
        };
        let name = format!("{} (process {place})", part.name());
        grown(
            &mut faults,
            &format!("{name}: KiB of its own"),
            of(|usage| usage.anonymous_kib),
            TOLERATED_KIB,
        );
        grown(&mut faults, &format!("{name}: open files"), of(|usage| usage.files), 0);
        grown(&mut faults, &format!("{name}: threads"), of(|usage| usage.threads), 0);
    }
    let of =
        |figure: fn(&super::usage::Stored) -> u64| change(plan, &outcome.looks, |look| figure(&look.stored));
    grown(&mut faults, "files in shared memory", of(|stored| stored.files), 0);
    grown(&mut faults, "reserved bytes of shared memory", of(|stored| stored.reserved), 0);
    grown(&mut faults, "written bytes of shared memory", of(|stored| stored.touched), TOLERATED_TOUCHED);
    grown(&mut faults, "files in the root", of(|stored| stored.in_root), 0);
    faults.extend(lost(outcome));
    faults
}

fn grown(faults: &mut Vec<String>, what: &str, change: Change, tolerated: u64) {
    if change.growth() > tolerated {
        faults.push(format!("{what}: {} after the warm-up, {} at the end", change.begin, change.end));
    }
}

/// Frames that the camera lost, that the detector did not send, or that no counter of a client knows of.
fn lost(outcome: &Outcome) -> Vec<String> {
    let mut faults = Vec::new();
    let Some(last) = outcome.looks.last() else { return vec!["nothing was looked at".to_owned()] };
    let (camera, detector) = (&last.camera, &last.detector);
    if camera.damaged + camera.no_loan > 0 {
        faults.push(format!(
            "the camera lost frames: {} damaged, {} without memory",
            camera.damaged, camera.no_loan
        ));
    }
    if detector.frames_searched != detector.messages_sent || detector.frames_refused > 0 {
        faults.push(format!("the detector did not send all that it searched: {detector:?}"));
    }
    for (number, (part, tally)) in outcome.tallies.iter().enumerate() {
        if tally.received == 0 || tally.unaccounted + tally.restarts + tally.mixed + tally.backwards > 0 {
            faults.push(format!("{} {number}: {tally:?}", part.name()));
        }
        if *part == Part::Client(Temper::Honest) && tally.received < 2 {
            faults.push(format!("{} {number} got next to nothing: {tally:?}", part.name()));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::Tally;
    use crate::soak::usage::{Stored, Usage};
    use std::path::PathBuf;

    /// Memory, open files and lost frames in each second.
    type Figures = fn(u64) -> (u64, u64, u64);

    /// A look a second for a minute, whose memory, open files and lost frames are as told.
    fn faults_of(figures: Figures) -> Vec<String> {
        let plan = Plan { program: PathBuf::new(), minutes: 1.0, clients: 16, rate: 200 };
        let look = |second: u64| {
            let (anonymous_kib, files, no_loan) = figures(second);
            let mut look = Look {
                seconds: second as f64,
                usages: vec![Usage { anonymous_kib, files, ..Usage::default() }],
                stored: Stored::default(),
                camera: Default::default(),
                detector: Default::default(),
            };
            look.camera.no_loan = no_loan;
            look
        };
        let tallies = vec![(Part::Client(Temper::Slow), Tally { received: 1, ..Tally::default() })];
        let looks = (1..=60).map(look).collect();
        faults(&plan, &Outcome { parts: vec![Part::Camera], looks, tallies })
    }

    #[test]
    fn growth_and_lost_frames_are_faults_and_a_warm_up_is_none() {
        assert_eq!(faults_of(|second| (1000 + second.min(10) * 100, 20, 0)), Vec::<String>::new());
        assert_eq!(faults_of(|second| (1000 + second, 20, 0)), Vec::<String>::new());
        let cases: [(Figures, &str); 3] = [
            (|second| (1000 + 3 * second, 20, 0), "KiB of its own"),
            (|second| (1000, 20 + second / 30, 0), "open files: 20"),
            (|second| (1000, 20, second / 60), "the camera lost frames"),
        ];
        for (figures, word) in cases {
            let faults = faults_of(figures);
            assert!(faults.len() == 1 && faults[0].contains(word), "{faults:?}");
        }
    }
}
