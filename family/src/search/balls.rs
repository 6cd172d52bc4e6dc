//! All values of the high bits of a code at once, one bit each, and the balls of values that codes forbid.
//!
//! The high bits are cut in two halves of nine: a word of 512 bits for each value of the upper half, a bit in it for each
//! value of the lower. All values that differ from a centre in at most r bits are then, in each word whose number differs
//! from the centre's upper half in d bits, those that differ from its lower half in at most r - d: one of 512 x 10
//! patterns.

/// High bits of a code.
pub(super) const HIGH_BITS: u32 = 2 * HALF_BITS;
const HALF_BITS: u32 = 9;
const WORDS: usize = 1 << HALF_BITS;
const CHUNKS: usize = WORDS / 64;

/// 512 bits.
type Word = [u64; CHUNKS];

/// Patterns and orders that all bitmaps share.
pub(super) struct Balls {
    /// For each centre and radius (0 to 9) the values within it.
    patterns: Vec<[Word; HALF_BITS as usize + 1]>,
    /// The values of a half, those with fewest ones first, and where those with the next number of ones begin.
    by_ones: Vec<u16>,
    starts: [usize; HALF_BITS as usize + 2],
}

impl Balls {
    pub(super) fn new() -> Balls {
        let within = |centre: usize, radius: u32| {
            let bit = |chunk: usize, bit: usize| {
                u64::from(((chunk * 64 + bit) ^ centre).count_ones() <= radius) << bit
            };
            std::array::from_fn(|chunk| (0..64).fold(0, |word, at| word | bit(chunk, at)))
        };
        let mut by_ones: Vec<u16> = (0..WORDS as u16).collect();
        by_ones.sort_by_key(|value| value.count_ones());
        let starts =
            std::array::from_fn(|ones| by_ones.partition_point(|value| (value.count_ones() as usize) < ones));
        let of_centre = |centre| std::array::from_fn(|radius| within(centre, radius as u32));
        Balls { patterns: (0..WORDS).map(of_centre).collect(), by_ones, starts }
    }
}

/// Values of the high bits that are forbidden.
pub(super) struct Forbidden(Box<[Word; WORDS]>);

impl Forbidden {
    pub(super) fn none() -> Forbidden {
        Forbidden(Box::new([[0; CHUNKS]; WORDS]))
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.0.fill([0; CHUNKS]);
    }

    /// Forbids all values that differ from `centre` in at most `radius` bits.
    #[inline(always)]
    pub(super) fn forbid(&mut self, balls: &Balls, centre: u32, radius: u32) {
        let (upper, lower) = (centre as usize >> HALF_BITS, centre as usize & (WORDS - 1));
        let patterns = &balls.patterns[lower];
        for ones in 0..=radius.min(HALF_BITS) {
            let pattern = patterns[(radius - ones).min(HALF_BITS) as usize];
            for &value in &balls.by_ones[balls.starts[ones as usize]..balls.starts[ones as usize + 1]] {
                let word = &mut self.0[(upper ^ usize::from(value)) & (WORDS - 1)];
                for chunk in 0..CHUNKS {
                    word[chunk] |= pattern[chunk];
                }
            }
        }
    }

    /// Bit i of place p stands for the value 64 p + i, and is set when that is forbidden.
    #[inline(always)]
    pub(super) fn chunks(&self) -> &[u64] {
        self.0.as_flattened()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn allowed(forbidden: &Forbidden) -> Vec<u64> {
        (0..1 << HIGH_BITS)
            .filter(|value| forbidden.chunks()[value / 64] >> (value % 64) & 1 == 0)
            .map(|value| value as u64)
            .collect()
    }

    #[test]
    fn balls_forbid_what_lies_within_their_radius() {
        let balls = Balls::new();
        let mut random = Random::new(4);
        for radius in 0..=HIGH_BITS {
            let centre = random.below(1 << HIGH_BITS) as u32;
            let mut forbidden = Forbidden::none();
            forbidden.forbid(&balls, centre, radius);
            let outside = |value: &u64| (*value as u32 ^ centre).count_ones() > radius;
            assert_eq!(
                allowed(&forbidden),
                (0..1 << HIGH_BITS).filter(outside).collect::<Vec<_>>(),
                "{centre:#x}, {radius}"
            );
        }
    }

    #[test]
    fn balls_add_up_until_they_are_cleared() {
        let (balls, mut forbidden) = (Balls::new(), Forbidden::none());
        forbidden.forbid(&balls, 0, HIGH_BITS - 1);
        forbidden.forbid(&balls, (1 << HIGH_BITS) - 1, 0);
        assert_eq!(allowed(&forbidden), []);
        forbidden.clear();
        assert_eq!(allowed(&forbidden).len(), 1 << HIGH_BITS);
    }
}
