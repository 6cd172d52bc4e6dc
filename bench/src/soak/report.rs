//! What was seen, as a table and as figures over time.

use std::fmt::Write as _;

use super::run::{Look, Outcome, Plan};
use super::usage::Usage;
use super::verdict::{Change, change, faults};
use crate::crowd::Part;

/// How a record of this is made.
pub(crate) const HOW: &str = "the built-in scene at 320x240, one detector with its defaults, every process of its own; a quarter of the \
    clients works 50 ms on each message, an eighth takes one message and never comes again. The first minute (of short runs the \
    first quarter) is warm-up. Tolerated: 64 KiB more memory of a process's own (16 pages), 512 KiB of reserved shared memory \
    written for the first time; no file, thread or reserved byte more";

/// The verdict, a line for each kind of process, the domain, and the counters.
pub(crate) fn page(plan: &Plan, outcome: &Outcome) -> String {
    let mut text = verdict(plan, outcome);
    text += "\n| process | of them | own memory KiB | resident KiB | proportional KiB | open files | threads |\n|---|---:|---|---|---|---|---|\n";
    for part in kinds(outcome) {
        let of = |figure: fn(&Usage) -> u64| shown(most(plan, outcome, part, figure));
        let count = outcome.parts.iter().filter(|other| **other == part).count();
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {count} | {} | {} | {} | {} | {} |",
            part.name(),
            of(|usage| usage.anonymous_kib),
            of(|usage| usage.resident_kib),
            of(|usage| usage.proportional_kib),
            of(|usage| usage.files),
            of(|usage| usage.threads)
        );
    }
    text + &domain(plan, outcome) + &counters(plan, outcome)
}

fn verdict(plan: &Plan, outcome: &Outcome) -> String {
    let faults = faults(plan, outcome);
    if faults.is_empty() {
        return "Nothing grew, no frame was lost by the camera, and every frame was sent or counted.\n"
            .to_owned();
    }
    faults.iter().map(|fault| format!("* FAULT: {fault}\n")).collect()
}

/// Each kind of process once.
pub(super) fn kinds(outcome: &Outcome) -> Vec<Part> {
    let mut kinds = outcome.parts.clone();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

/// Of the process of this kind that grew most.
fn most(plan: &Plan, outcome: &Outcome, part: Part, figure: fn(&Usage) -> u64) -> Change {
    let of = |place: usize| change(plan, &outcome.looks, |look| figure(&look.usages[place]));
    let places = outcome.parts.iter().enumerate().filter(|(_, other)| **other == part);
    places.map(|(place, _)| of(place)).max_by_key(|change| (change.growth(), change.end)).unwrap_or_default()
}

fn shown(change: Change) -> String {
    let Change { begin, end } = change;
    if begin == end { end.to_string() } else { format!("{begin} -> {end}") }
}

fn domain(plan: &Plan, outcome: &Outcome) -> String {
    let of = |figure: fn(&Look) -> u64| shown(change(plan, &outcome.looks, figure));
    format!(
        "\nEach cell: after the warm-up -> at the end where they differ (medians of five looks), of the process of its kind that grew most.\n\
         \nShared memory: {} files of {} bytes, of which {} were written; {} files and sockets in the root.\n",
        of(|look| look.stored.files),
        of(|look| look.stored.reserved),
        of(|look| look.stored.touched),
        of(|look| look.stored.in_root)
    )
}

fn counters(plan: &Plan, outcome: &Outcome) -> String {
    let Some(last) = outcome.looks.last() else { return String::new() };
    let (camera, detector) = (&last.camera, &last.detector);
    let mut text = format!(
        "\nThe camera sent {} frames in {:.0} s ({:.1} a second of {} asked for) and lost {}; the detector searched {}, skipped {} \
         and sent {} messages.\n\n| client | messages | left its queue unread | frames nobody counts |\n|---|---:|---:|---:|\n",
        camera.frames,
        (camera.taken_ns.saturating_sub(camera.started_ns)) as f64 / 1e9,
        camera.frames as f64 * 1e9 / (camera.taken_ns.saturating_sub(camera.started_ns)).max(1) as f64,
        plan.rate,
        camera.damaged + camera.no_loan,
        detector.frames_searched,
        detector.frames_skipped,
        detector.messages_sent
    );
    for (part, tally) in &outcome.tallies {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            part.name(),
            tally.received,
            tally.missed,
            tally.unaccounted
        );
    }
    text
}

/// A line a look: the largest process of each kind, sums, the domain, the counters.
pub(crate) fn csv(outcome: &Outcome) -> String {
    let kinds = kinds(outcome);
    let mut text = String::from("seconds");
    for kind in &kinds {
        text += &format!(",{} own KiB", kind.name());
    }
    text += ",proportional KiB of all,open files,threads,shared files,shared reserved,shared written,root files,frames sent,frames lost,frames searched,frames skipped\n";
    for look in &outcome.looks {
        let all = |figure: fn(&Usage) -> u64| look.usages.iter().map(figure).sum::<u64>();
        let own = kinds.iter().map(|kind| largest(outcome, look, *kind));
        let figures = own.chain([
            all(|usage| usage.proportional_kib),
            all(|usage| usage.files),
            all(|usage| usage.threads),
            look.stored.files,
            look.stored.reserved,
            look.stored.touched,
            look.stored.in_root,
            look.camera.frames,
            look.camera.damaged + look.camera.no_loan,
            look.detector.frames_searched,
            look.detector.frames_skipped,
        ]);
        let figures: String = figures.map(|figure| format!(",{figure}")).collect();
        text += &format!("{:.0}{figures}\n", look.seconds);
    }
    text
}

/// Memory of its own of the largest process of this kind, KiB.
pub(super) fn largest(outcome: &Outcome, look: &Look, kind: Part) -> u64 {
    let usages = outcome.parts.iter().zip(&look.usages).filter(|(part, _)| **part == kind);
    usages.map(|(_, usage)| usage.anonymous_kib).max().unwrap_or(0)
}
