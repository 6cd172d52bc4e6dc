//! Tables and CSV of a run.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::kills::{Kind, Outcome, Recovery};
use super::machine::Role;

/// How it was measured, for the page.
pub(crate) const HOW: &str = "`tagbus run` with the built-in scene (320x240, 200 frames per second) and the clients (`tagbus watch --json`), \
each a process of its own. The victim (camera, detector, one of the clients, supervisor) and the moment are random; the supervisor starts \
camera and detector again, the bench clients and supervisor, at once. Times are from the start of the new process (of camera and \
detector as the kernel keeps it, rounded down to 10 ms, so up to 10 ms too long) to the first message with tags at a client that both a \
camera and a detector not older than it made; `all clients`: at the last of them; `silence`: from the kill, with the supervisor's pause. \
After each kill all clients must get messages again and nobody else may have ended; when a further client has \
come and gone, files and bytes in shared memory and files in the root must be as before the first kill, and none after the orderly end";

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::StartUp => "starting",
        }
    }

    /// What the 99th percentile has to stay below, in milliseconds.
    pub(super) fn bar_ms(self) -> f64 {
        match self {
            Self::Running => 250.0,
            Self::StartUp => 500.0,
        }
    }
}

/// The value that so many per cent of all do not pass (nearest rank); 0 of nothing.
fn percentile(sorted: &[f64], per_cent: usize) -> f64 {
    let rank = (sorted.len() * per_cent).div_ceil(100);
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// Values of some recoveries in order.
pub(super) fn sorted<'a>(
    recoveries: impl Iterator<Item = &'a Recovery>,
    value: impl Fn(&Recovery) -> f64,
) -> Vec<f64> {
    let mut values: Vec<f64> = recoveries.map(value).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The tables.
pub(crate) fn page(outcome: &Outcome) -> String {
    let mut text = String::from(
        "| killed while | role | kills | p50 ms | p95 ms | p99 ms | longest ms | all clients p99 ms | silence p50 ms |\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for kind in [Kind::Running, Kind::StartUp] {
        let of_kind: Vec<&Recovery> = outcome.recoveries.iter().filter(|one| one.kind == kind).collect();
        for role in Role::ALL {
            let of_role = of_kind.iter().copied().filter(|one| one.role == role);
            row(&mut text, kind, role.name(), &of_role.collect::<Vec<_>>());
        }
        row(&mut text, kind, "all", &of_kind);
    }
    text + &bars(outcome) + &rest(outcome)
}

fn row(text: &mut String, kind: Kind, name: &str, recoveries: &[&Recovery]) {
    if recoveries.is_empty() {
        return;
    }
    let first = sorted(recoveries.iter().copied(), |one| one.first_ms);
    let all = sorted(recoveries.iter().copied(), |one| one.all_ms);
    let silence = sorted(recoveries.iter().copied(), |one| one.silence_ms);
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "| {} | {name} | {} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} |",
        kind.name(),
        first.len(),
        percentile(&first, 50),
        percentile(&first, 95),
        percentile(&first, 99),
        percentile(&first, 100),
        percentile(&all, 99),
        percentile(&silence, 50),
    );
}

/// Each goal and whether it was met.
fn bars(outcome: &Outcome) -> String {
    let mut text = String::from("\n");
    for kind in [Kind::Running, Kind::StartUp] {
        let first = sorted(outcome.recoveries.iter().filter(|one| one.kind == kind), |one| one.first_ms);
        if first.is_empty() {
            continue;
        }
        let (p99, bar) = (percentile(&first, 99), kind.bar_ms());
        let verdict = if p99 < bar { "met" } else { "MISSED" };
        let _ = writeln!(
            text,
            "* killed while {}: p99 {p99:.0} ms, goal below {bar:.0} ms: {verdict}",
            kind.name()
        );
    }
    text
}

fn rest(outcome: &Outcome) -> String {
    let [before, after] = &outcome.storage;
    let mut text =
        format!("* stored before the first kill: {before}\n* stored after the last kill: {after}\n");
    text += "* stored after the end: nothing; processes left: none; panics and unasked ends: none\n";
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for line in &outcome.complaints {
        *counts.entry(without_numbers(line)).or_default() += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    text += "\nWhat the roles said, numbers left out:\n\n| times | line |\n|---:|---|\n";
    for (line, count) in counts {
        let _ = writeln!(text, "| {count} | `{line}` |");
    }
    text
}

/// So that lines that differ in a number only are counted together.
fn without_numbers(line: &str) -> String {
    let mut text = String::new();
    for letter in line.chars().map(|letter| if letter.is_ascii_digit() { '#' } else { letter }) {
        if letter != '#' || !text.ends_with('#') {
            text.push(letter);
        }
    }
    text.replace('|', "\\|")
}

/// One line a kill.
pub(crate) fn csv(outcome: &Outcome) -> String {
    let mut text = String::from("killed_while,role,lived_ms,first_ms,all_clients_ms,silence_ms\n");
    for Recovery { role, kind, lived_ms, first_ms, all_ms, silence_ms } in &outcome.recoveries {
        let lived = lived_ms.map(|ms| format!("{ms:.1}")).unwrap_or_default();
        let (kind, role) = (kind.name(), role.name());
        let _ = writeln!(text, "{kind},{role},{lived},{first_ms:.1},{all_ms:.1},{silence_ms:.1}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_a_value_that_was_measured() {
        let values: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!([50, 99, 100].map(|per_cent| percentile(&values, per_cent)), [100.0, 198.0, 200.0]);
        assert_eq!([percentile(&[7.0], 50), percentile(&[], 99)], [7.0, 0.0]);
    }

    #[test]
    fn lines_that_differ_in_numbers_count_as_one() {
        assert_eq!(without_numbers("waited 1.25 s for 3 | 4"), "waited #.# s for # \\| #");
    }
}
