//! The order in which the published families were searched: candidate codes v_1, v_2, ... of which a greedy search
//! kept those far enough from everything kept before.
//!
//! v_k = (v_0 + k * 982451653) mod 2^bits. The factor is odd, so every value occurs exactly once in 2^bits steps and
//! k can be computed from v. Codes of one family have increasing k, which makes the differences of k a compact way to
//! store the family and proves that no code is out of order.

/// The step of the sequence, a prime that fills the codes of every family with well mixed bits.
const STEP: u64 = 982_451_653;

/// The candidate sequence of one family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidates {
    start: u64,
    mask: u64,
}

impl Candidates {
    /// The sequence of a family with `bit_count` bits (1 to 64), minimum distance `distance` and the complexity
    /// number that the family was seeded with.
    pub fn new(bit_count: u32, distance: u32, complexity: u32) -> Candidates {
        let seed = u64::from(bit_count) * 10_000 + u64::from(distance) * 100 + u64::from(complexity);
        Candidates { start: first_java_random(seed), mask: u64::MAX >> (64 - bit_count.clamp(1, 64)) }
    }

    /// Candidate number `k`; the search begins with 1.
    pub fn code(&self, k: u64) -> u64 {
        self.start.wrapping_add(k.wrapping_mul(STEP)) & self.mask
    }

    /// The number of the candidate `code`, from 0 to 2^bits - 1.
    pub fn number(&self, code: u64) -> u64 {
        code.wrapping_sub(self.start).wrapping_mul(inverse(STEP)) & self.mask
    }
}

/// The first `nextLong()` of `java.util.Random(seed)`, as its documentation specifies the generator.
fn first_java_random(seed: u64) -> u64 {
    const MULTIPLIER: u64 = 0x5_DEEC_E66D;
    let mut state = seed ^ MULTIPLIER;
    let mut next = || {
        state = state.wrapping_mul(MULTIPLIER).wrapping_add(11) & ((1 << 48) - 1);
        // The upper 32 of 48 bits, taken as a signed number: a negative second half borrows from the first.
        (state >> 16) as u32 as i32
    };
    let (high, low) = (next(), next());
    (i64::from(high) << 32).wrapping_add(i64::from(low)) as u64
}

/// The inverse of an odd number modulo 2^64, by Newton's iteration: each step doubles the number of right bits,
/// beginning with the 3 bits in which an odd number is its own inverse.
fn inverse(odd: u64) -> u64 {
    (0..5).fold(odd, |guess, _| guess.wrapping_mul(2u64.wrapping_sub(odd.wrapping_mul(guess))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_a_candidate_is_found_again() {
        for bit_count in [4, 16, 21, 36, 48, 52, 63, 64] {
            let candidates = Candidates::new(bit_count, 11, 10);
            let last = u64::MAX >> (64 - bit_count);
            for k in (0..10_000).map(|i| i * 7_919_777).filter(|k| *k <= last).chain([last]) {
                assert_eq!(candidates.number(candidates.code(k)), k, "{bit_count} bits");
            }
        }
    }

    #[test]
    fn every_code_occurs_once() {
        let candidates = Candidates::new(12, 5, 3);
        let mut seen = [false; 1 << 12];
        (1..=1 << 12).for_each(|k| seen[candidates.code(k) as usize] = true);
        assert!(seen.iter().all(|seen| *seen));
    }

    #[test]
    fn the_seed_is_stretched_as_in_java() {
        // new java.util.Random(42).nextLong(), a value found in many books and answers.
        assert_eq!(first_java_random(42) as i64, -5_025_562_857_975_149_833);
    }

    #[test]
    fn the_first_code_of_tag_standard_41h12_is_an_early_candidate() {
        assert_eq!(Candidates::new(41, 12, 10).number(0x1bd_8a64_ad10), 1);
    }
}
