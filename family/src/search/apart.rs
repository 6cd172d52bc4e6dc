//! How far the codes of a family are apart, and whether that is as far as it says.

use super::level::{Kernel, Level};
use super::near::any_within;
use crate::layout::Layout;

/// Codes a vector of the widest kind.
const LANES: usize = 8;

/// Two tags that resemble each other more than their family says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooClose {
    /// The id of the one.
    pub first: usize,
    /// The id of the other, or the same: a tag that resembles itself turned.
    pub second: usize,
    /// In how many bits they differ, the one turned.
    pub bits: u32,
}

/// The first tag that differs from itself turned, or from one before in any rotation, in fewer than `distance` bits.
/// About a second for 65,000 codes with AVX-512, ten times that on processors that cannot count bits.
pub fn first_too_close(layout: &Layout, codes: &[u64], distance: u32) -> Option<TooClose> {
    let level = Level::best();
    (0..codes.len()).find_map(|second| {
        let rotations = layout.rotations(codes[second]);
        let [code, turns @ ..] = rotations;
        let own = turns.iter().map(|turned| (code ^ turned).count_ones()).min().unwrap_or(0);
        if own < distance {
            return Some(TooClose { first: second, second, bits: own });
        }
        let is_close = level.run(AnyOf { rotations, codes: &codes[..second], distance });
        is_close.then(|| nearest(&rotations, &codes[..second], second))
    })
}

fn nearest(rotations: &[u64; 4], codes: &[u64], second: usize) -> TooClose {
    let bits = |code: u64| rotations.iter().map(|turned| (turned ^ code).count_ones()).min().unwrap_or(0);
    let distances =
        codes.iter().enumerate().map(|(first, &code)| TooClose { first, second, bits: bits(code) });
    distances.min_by_key(|found| found.bits).unwrap_or(TooClose { first: second, second, bits: 0 })
}

struct AnyOf<'a> {
    rotations: [u64; 4],
    codes: &'a [u64],
    distance: u32,
}

impl Kernel for AnyOf<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let mut any = false;
        for turned in self.rotations {
            any |= any_within(turned, self.codes, self.distance);
        }
        any
    }
}

/// The fewest bits in which any of `codes` differs from a tag in any of its rotations; `None` without codes.
pub(crate) fn least_bits(level: Level, rotations: [u64; 4], codes: &[u64]) -> Option<u32> {
    (!codes.is_empty()).then(|| level.run(Least { rotations, codes }))
}

struct Least<'a> {
    rotations: [u64; 4],
    codes: &'a [u64],
}

impl Kernel for Least<'_> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let (groups, rest) = self.codes.as_chunks::<LANES>();
        let mut least = [u64::from(u64::BITS); LANES];
        for group in groups {
            for turned in self.rotations {
                for lane in 0..LANES {
                    least[lane] = least[lane].min(u64::from((group[lane] ^ turned).count_ones()));
                }
            }
        }
        for code in rest {
            for turned in self.rotations {
                least[0] = least[0].min(u64::from((code ^ turned).count_ones()));
            }
        }
        least.into_iter().fold(u64::from(u64::BITS), u64::min) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_fewest_bits_are_those_of_all_pairs_at_every_level() {
        let mut random = Random::new(9);
        for count in [0, 1, 7, 8, 9, 100] {
            let codes: Vec<u64> = (0..count).map(|_| random.next()).collect();
            let rotations: [u64; 4] = std::array::from_fn(|_| random.next());
            let pairs = codes.iter().flat_map(|code| rotations.map(|turned| (code ^ turned).count_ones()));
            let least = pairs.min();
            for level in Level::available() {
                assert_eq!(least_bits(level, rotations, &codes), least, "{count} codes at {level:?}");
            }
        }
    }
    use crate::Family;

    #[test]
    fn published_families_are_as_far_apart_as_they_say_and_no_further() {
        for name in ["tag16h5", "tag25h9", "tag36h11", "tagCircle21h7"] {
            let family = Family::published(name).unwrap();
            let found = |distance| first_too_close(family.layout(), family.codes(), distance);
            assert_eq!(found(family.distance()), None, "{name}");
            let TooClose { first, second, bits } = found(family.distance() + 1).unwrap();
            assert_eq!(bits, family.distance(), "{name}: {first} and {second}");
        }
    }

    #[test]
    fn the_two_tags_are_named() {
        let family = Family::published("tag36h11").unwrap();
        let mut codes = family.codes()[..40].to_vec();
        codes.push(family.layout().rotate90(codes[7]) ^ 0b11);
        let found = first_too_close(family.layout(), &codes, 11);
        assert_eq!(found, Some(TooClose { first: 7, second: 40, bits: 2 }));
        assert_eq!(
            first_too_close(family.layout(), &[0], 11),
            Some(TooClose { first: 0, second: 0, bits: 0 })
        );
    }
}
