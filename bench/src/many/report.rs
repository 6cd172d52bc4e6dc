//! What was seen, as a table.

use std::fmt::Write as _;

use super::run::Told;
use super::verdict::{faults, seen};

/// How a record of this is made.
pub(crate) const HOW: &str = "two cameras (the built-in scene at 640x480), two detectors at the first and one at the second, every \
    process of its own; each change sets decimation, corrected bits and reported ids together. Checked: every message of a change \
    names the same parameters at every client, those that were asked for, and holds only ids that were asked for; no frame of an \
    earlier change comes after one of a later change; every change is seen; no request and no client is refused";

/// The verdict and a line for each detector.
pub(crate) fn page(all: &[Told]) -> String {
    let faults = faults(all);
    let mut text = match faults.is_empty() {
        true => "Every change took effect between two frames, no message mixed two, nobody was refused.\n"
            .to_owned(),
        false => faults.iter().map(|fault| format!("* FAULT: {fault}\n")).collect(),
    };
    text += "\n| detector | clients | changes made | changes seen | messages received | left a queue unread |\n|---|---:|---:|---:|---:|---:|\n";
    for told in all {
        let sum = |count: fn(&crate::crowd::Tally) -> u64| told.tallies.iter().map(count).sum::<u64>();
        let saw = seen(told).keys().filter(|number| told.changes.contains_key(number)).count();
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {saw} | {} | {} |",
            told.place.join(" "),
            told.tallies.len(),
            told.changes.len(),
            sum(|tally| tally.received),
            sum(|tally| tally.missed)
        );
    }
    text
}
