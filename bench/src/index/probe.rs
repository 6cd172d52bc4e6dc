//! Codes to look up.

use tagbus_family::Family;
use tagbus_scene::Stream;

/// The most wrong bits of a probe: one more than three, the most that are corrected here.
const MOST_ERRORS: u64 = 4;

/// A code of as many random bits as the family's have.
pub(super) fn random_code(family: &Family, random: &mut Stream) -> u64 {
    random.bits() & (u64::MAX >> (64 - family.layout().bit_count()))
}

/// Any tag in any of its rotations, with exactly so many wrong bits.
pub(super) fn tag_with_errors(family: &Family, errors: u32, random: &mut Stream) -> u64 {
    let id = random.below(family.codes().len() as u64) as usize;
    let turned = family.layout().rotations(family.codes()[id])[random.below(4) as usize];
    let mut wrong = 0_u64;
    while wrong.count_ones() < errors {
        wrong |= 1 << random.below(u64::from(family.layout().bit_count()));
    }
    turned ^ wrong
}

/// A random code or, as often, a tag with up to four wrong bits.
pub(super) fn either(family: &Family, random: &mut Stream) -> u64 {
    if random.below(2) == 0 {
        random_code(family, random)
    } else {
        let errors = random.below(MOST_ERRORS + 1) as u32;
        tag_with_errors(family, errors, random)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_have_as_many_wrong_bits_as_asked_for_and_come_in_all_rotations() {
        let family = Family::published("tag25h9").unwrap();
        let mut random = Stream::new(1);
        let mut seen = [0; 4];
        for errors in (0..=MOST_ERRORS as u32).cycle().take(500) {
            let code = tag_with_errors(&family, errors, &mut random);
            let rotations = family.layout().rotations(code);
            // The distance is 9, so with four wrong bits a tag is still the nearest.
            let nearest = |turned: &u64| family.codes().iter().map(|tag| (tag ^ turned).count_ones()).min();
            let rotation = (0..4).min_by_key(|&rotation| nearest(&rotations[rotation])).unwrap();
            assert_eq!(nearest(&rotations[rotation]), Some(errors));
            seen[rotation] += 1;
        }
        assert!(seen.iter().all(|&count| count > 50), "{seen:?}");
    }
}
