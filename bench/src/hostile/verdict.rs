//! What must not have happened, whatever the machine's speed.

use super::run::Outcome;

/// Everything that is wrong, in words; empty when all is well.
pub(crate) fn faults(outcome: &Outcome) -> Vec<String> {
    let mut faults = Vec::new();
    for (number, tally) in outcome.tallies.iter().enumerate() {
        if tally.received == 0 || tally.unaccounted + tally.restarts + tally.mixed + tally.backwards > 0 {
            faults.push(format!("client {number}: {tally:?}"));
        }
    }
    for attacked in &outcome.attacks {
        for window in &attacked.hostile {
            if window.received == 0 || window.deeds == 0 {
                faults.push(format!("during {}: {window:?}", attacked.attack.name()));
            }
        }
    }
    if outcome.no_loan > 0 {
        faults.push(format!("the camera had no memory for {} frames", outcome.no_loan));
    }
    let [searched, sent] = outcome.searched_and_sent;
    if searched != sent {
        faults.push(format!("{searched} frames were searched and {sent} messages sent"));
    }
    let [before, after] = &outcome.stored;
    // Fewer are none: what the last attacker left may have gone only after the first look.
    if after.files > before.files || after.in_root > before.in_root {
        let new = outcome.left.join(", ");
        faults.push(format!(
            "something is left: {before:?} before the attacks, {after:?} after them, new: {new}"
        ));
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::super::attack::Attack;
    use super::super::run::{Attacked, Window};
    use super::*;
    use crate::crowd::Tally;
    use crate::soak::Stored;

    fn faults_when(spoil: fn(&mut Outcome)) -> Vec<String> {
        let window = Window { received: 9, deeds: 5, ..Window::default() };
        let mut outcome = Outcome {
            quiet: vec![window],
            attacks: vec![Attacked { attack: Attack::Hoard, tame: vec![window], hostile: vec![window] }],
            tallies: vec![Tally { received: 9, missed: 1, ..Tally::default() }],
            no_loan: 0,
            searched_and_sent: [9, 9],
            stored: [Stored::default(); 2],
            left: Vec::new(),
        };
        spoil(&mut outcome);
        faults(&outcome)
    }

    #[test]
    fn what_attackers_break_is_a_fault() {
        assert_eq!(faults_when(|_| ()), Vec::<String>::new());
        type Spoil = fn(&mut Outcome);
        let spoils: [(Spoil, &str); 6] = [
            (|outcome| outcome.tallies[0].unaccounted = 1, "client 0"),
            (|outcome| outcome.attacks[0].hostile[0].received = 0, "during hoard"),
            (|outcome| outcome.attacks[0].hostile[0].deeds = 0, "during hoard"),
            (|outcome| outcome.no_loan = 1, "no memory for 1"),
            (|outcome| outcome.searched_and_sent = [9, 8], "8 messages sent"),
            (|outcome| outcome.stored[1].files = 1, "something is left"),
        ];
        for (spoil, word) in spoils {
            let faults = faults_when(spoil);
            assert!(faults.len() == 1 && faults[0].contains(word), "{faults:?}");
        }
    }
}
