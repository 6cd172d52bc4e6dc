//! In words, what the intervals of the differences carry, and nothing beyond.

use super::interval::{Bootstrap, Estimate};
use super::run::Outcome;

/// For each pair the numbers of corrected bits at which their difference is told from 0, and those at which it is not.
pub(super) fn verdict(outcome: &Outcome, bootstrap: &Bootstrap) -> String {
    let mut text = String::from("\nWhat the intervals carry:\n\n");
    for pair in &outcome.pairs {
        let [ising, other] = [pair.ising, pair.other].map(|place| &outcome.lines[place]);
        let side = |bits| side(bootstrap.difference([&ising.counts, &other.counts], bits));
        let at = |wanted| outcome.levels().filter(|&bits| side(bits) == wanted).collect::<Vec<_>>();
        let parts =
            [("fewer", at(Side::Fewer)), ("more", at(Side::More)), ("not told apart", at(Side::Unknown))];
        let parts = parts.iter().filter(|(_, bits)| !bits.is_empty());
        let words: Vec<String> = parts.map(|(word, bits)| format!("{word} at {}", listed(bits))).collect();
        let names =
            [ising, other].map(|line| format!("{} (passes {:.3})", line.contender.name(), line.share));
        text += &format!("* {} against {}: {}.\n", names[0], names[1], words.join("; "));
    }
    text
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Fewer,
    More,
    Unknown,
}

fn side(difference: Estimate) -> Side {
    match difference {
        Estimate { high, .. } if high < 0.0 => Side::Fewer,
        Estimate { low, .. } if low > 0.0 => Side::More,
        _ => Side::Unknown,
    }
}

fn listed(bits: &[usize]) -> String {
    bits.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::contenders::Field;
    use super::super::families::KINDS;
    use super::super::matches::LEVELS;
    use super::super::run::Line;
    use super::*;

    /// Eight places that all have so many false positives of the first four contenders, at every number of bits but 0.
    pub(in super::super) fn outcome(counts: [u32; 4]) -> Outcome {
        let layout = tagbus_family::Layout::circle(9).unwrap();
        let Field { contenders, pairs, .. } = Field::new(&layout, 100);
        let of_place = |count: u32| {
            let mut levels = [count; LEVELS];
            levels[0] = 0;
            levels
        };
        let line = |(&contender, count): (_, u32)| Line {
            contender,
            share: 0.5,
            counts: vec![vec![of_place(count); 8]; 3],
        };
        Outcome {
            kind: &KINDS[0],
            bit_count: 21,
            most_bits: 3,
            quads: vec![100; 8],
            lines: contenders.iter().zip(counts).map(line).collect(),
            pairs: pairs.into_iter().filter(|pair| pair.ising < 4).collect(),
            passed_over: Vec::new(),
        }
    }

    #[test]
    fn only_what_excludes_0_is_said() {
        let outcome = outcome([9, 4, 2, 2]);
        let verdict = verdict(&outcome, &outcome.bootstrap());
        let ends: Vec<&str> = verdict.lines().filter_map(|line| Some(line.rsplit_once("): ")?.1)).collect();
        let fewer = "fewer at 1, 2, 3; not told apart at 0.";
        assert_eq!(ends, [fewer, fewer, "not told apart at 0, 1, 2, 3."]);
    }

    #[test]
    fn ising_can_lose() {
        let outcome = outcome([9, 4, 2, 3]);
        let verdict = verdict(&outcome, &outcome.bootstrap());
        assert!(verdict.ends_with("more at 1, 2, 3; not told apart at 0.\n"), "{verdict}");
    }

    #[test]
    fn an_interval_that_touches_0_tells_nothing() {
        let sides = [(-2.0, -1.0), (-2.0, 0.0), (0.0, 2.0), (1.0, 2.0), (-1.0, 1.0)]
            .map(|(low, high)| side(Estimate { value: 0.0, low, high }));
        assert_eq!(sides, [Side::Fewer, Side::Unknown, Side::Unknown, Side::More, Side::Unknown]);
    }
}
