//! A table over numbers of clients.

use std::fmt::Write as _;

use super::run::Measured;
use crate::median::median;

/// From no client to this many ...
const MANY: usize = 16;
/// ... the median may rise by so much.
const GOAL_US: f64 = 20.0;

/// A line for each number of clients, then what the goal says.
pub(crate) fn page(all: &[Measured]) -> String {
    let mut text = String::from(
        "| clients | frames | least us | median us | medians of the rounds us | above none us |\n|---:|---:|---:|---:|---|---:|\n",
    );
    let base = all.iter().find(|measured| measured.clients == 0);
    for measured in all {
        let above = base.map_or_else(String::new, |base| format!("{:.1}", measured.median() - base.median()));
        let medians: Vec<String> = measured.medians().map(|median| format!("{median:.1}")).collect();
        let (clients, medians) = (measured.clients, medians.join(", "));
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {clients} | {} | {:.1} | {:.1} | {medians} | {above} |",
            measured.all().count(),
            measured.least(),
            measured.median()
        );
    }
    let many = all.iter().find(|measured| measured.clients == MANY);
    if let (Some(base), Some(many)) = (base, many) {
        let (least, middle) = (many.least() - base.least(), many.median() - base.median());
        let verdict = if middle <= GOAL_US { "met" } else { "not met" };
        let _ = writeln!(
            text,
            "\nFrom no client to {MANY}: the median rises by {middle:.1} us, the least by {least:.1} us; goal at most {GOAL_US} us: {verdict}."
        );
    }
    text
}

impl Measured {
    fn all(&self) -> impl Iterator<Item = f64> + '_ {
        self.rounds.iter().flatten().copied()
    }

    fn median(&self) -> f64 {
        median(self.all())
    }

    fn medians(&self) -> impl Iterator<Item = f64> + '_ {
        self.rounds.iter().map(|round| median(round.iter().copied()))
    }

    fn least(&self) -> f64 {
        self.all().fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rise_is_that_of_the_medians_and_held_to_the_goal() {
        let measured = |clients, add: f64| Measured {
            clients,
            rounds: vec![vec![100.0 + add, 103.0 + add], vec![101.0 + add, 109.0 + add, 102.0 + add]],
        };
        let text = page(&[measured(0, 0.0), measured(16, 20.0)]);
        assert!(text.contains("| 16 | 5 | 120.0 | 122.0 | 123.0, 122.0 | 20.0 |"), "{text}");
        assert!(text.contains("the median rises by 20.0 us, the least by 20.0 us") && text.contains(": met"));
        assert!(page(&[measured(0, 0.0), measured(16, 20.5)]).contains("not met"));
    }
}
