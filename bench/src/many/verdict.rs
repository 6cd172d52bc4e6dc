//! What must not have happened.

use std::collections::BTreeMap;

use super::run::Told;
use crate::crowd::InForce;

/// What all clients of a detector saw together, by number of the change.
pub(super) fn seen(told: &Told) -> BTreeMap<u64, InForce> {
    let mut all: BTreeMap<u64, InForce> = BTreeMap::new();
    for (number, seen) in told.tallies.iter().flat_map(|tally| &tally.changes) {
        all.entry(*number).and_modify(|known| known.widen(seen)).or_insert_with(|| seen.clone());
    }
    all
}

/// Everything that is wrong, in words; empty when all is well.
pub(crate) fn faults(all: &[Told]) -> Vec<String> {
    all.iter().flat_map(faults_of).collect()
}

fn faults_of(told: &Told) -> Vec<String> {
    let (mut faults, name) = (Vec::new(), told.place.join(" "));
    for tally in &told.tallies {
        if tally.received == 0 || tally.unaccounted + tally.restarts + tally.backwards + tally.mixed > 0 {
            faults.push(format!("a client of {name}: {tally:?}"));
        }
        for (number, seen) in &tally.changes {
            if let Some(expected) = told.changes.get(number).filter(|expected| !expected.is_met_by(seen)) {
                faults
                    .push(format!("{name}, change {number}: asked for {expected:?}, a client saw {seen:?}"));
            }
        }
    }
    let seen = seen(told);
    let missing = told.changes.keys().filter(|number| !seen.contains_key(number));
    faults.extend(missing.map(|number| format!("{name}: no client saw change {number}")));
    // A frame belongs to one change, and so do all frames between two of its own.
    for ((earlier, before), (later, after)) in seen.iter().zip(seen.iter().skip(1)) {
        if before.frames[1] >= after.frames[0] {
            faults.push(format!(
                "{name}: frames of changes {earlier} and {later} overlap: {before:?}, {after:?}"
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::super::run::Expected;
    use super::*;
    use crate::crowd::Tally;

    fn seen_as(round: usize, frames: [u64; 2]) -> InForce {
        let Expected { decimation, hamming, ids } = Expected::of(round);
        InForce { decimation, hamming, flags: 4, frames, ids: Some(ids) }
    }

    fn faults_when(changes: [InForce; 2]) -> Vec<String> {
        let changes: BTreeMap<u64, InForce> = [1, 2].into_iter().zip(changes).collect();
        let told = Told {
            place: ["cam0".to_owned(), "main".to_owned()],
            changes: [(1, Expected::of(0)), (2, Expected::of(1))].into(),
            tallies: vec![Tally { received: 9, changes, ..Tally::default() }],
        };
        faults(&[told])
    }

    #[test]
    fn mixed_parameters_and_overlapping_frames_are_faults() {
        assert_eq!(faults_when([seen_as(0, [1, 5]), seen_as(1, [6, 9])]), Vec::<String>::new());
        let overlap = faults_when([seen_as(0, [1, 6]), seen_as(1, [6, 9])]);
        assert!(overlap.len() == 1 && overlap[0].contains("overlap"), "{overlap:?}");
        let other = InForce { hamming: 2, ..seen_as(1, [6, 9]) };
        let mixed = faults_when([seen_as(0, [1, 5]), other]);
        assert!(mixed.len() == 1 && mixed[0].contains("asked for"), "{mixed:?}");
        let stray = InForce { ids: Some([299, 300]), ..seen_as(1, [6, 9]) };
        assert_eq!(faults_when([seen_as(0, [1, 5]), stray]).len(), 1);
    }
}
