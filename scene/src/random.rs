//! Random numbers that are the same on every machine and for ever.
//!
//! All of them come from SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
//! Its n-th number is a hash of `seed + n * GAMMA`, so the same generator serves as a stream and, for the noise of
//! pixels, as a table of endless length that may be read in any order.

/// The step of SplitMix64: 2^64 divided by the golden ratio, made odd.
const GAMMA: u64 = 0x9E37_79B9_7F4A_7C15;

/// The output function of SplitMix64: every bit of `state` reaches every bit of the result.
pub(crate) fn mix(state: u64) -> u64 {
    let state = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let state = (state ^ (state >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    state ^ (state >> 31)
}

/// Number `index` (from 0) of the stream with this seed, without walking there.
pub(crate) fn number_at(seed: u64, index: u64) -> u64 {
    mix(seed.wrapping_add(index.wrapping_add(1).wrapping_mul(GAMMA)))
}

/// A key for one of many independent streams: `purpose` is a frame number, an octave, or the like.
pub(crate) fn key_for(seed: u64, purpose: u64) -> u64 {
    mix(number_at(seed, purpose) ^ GAMMA)
}

/// A seeded stream of random numbers; the same seed gives the same numbers on every machine.
///
/// ```
/// use tagbus_scene::Stream;
/// let mut stream = Stream::new(7);
/// let angle_rad = stream.between(-1.0, 1.0);
/// assert!((-1.0..1.0).contains(&angle_rad));
/// assert_eq!(Stream::new(7).between(-1.0, 1.0), angle_rad);
/// ```
#[derive(Clone, Debug)]
pub struct Stream {
    seed: u64,
    next: u64,
}

impl Stream {
    /// A stream that starts at its first number.
    pub fn new(seed: u64) -> Stream {
        Stream { seed, next: 0 }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.next += 1;
        number_at(self.seed, self.next - 1)
    }

    /// The next number in 0 (included) .. 1 (excluded), a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        unit_from(self.bits())
    }

    /// The next number from `low` (included) up to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next whole number in 0..`count`; 0 when `count` is 0 or 1. Counts are far below 2^32, so that the bias of
    /// the remainder is below 2^-32.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits() % count.max(1)
    }
}

/// Random bits as a number in 0..1, a multiple of 2^-53.
pub(crate) fn unit_from(bits: u64) -> f64 {
    const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
    (bits >> 11) as f64 * STEP
}

/// A table of normally distributed numbers with mean 0 and standard deviation 1, drawn from by hash.
///
/// A draw is one table look-up, which is what makes noise on every pixel of every frame affordable. The entries are
/// sums of twelve uniform numbers (exact arithmetic, no logarithm that could differ between machines).
pub(crate) struct Normals {
    table: Box<[f32; Normals::LENGTH]>,
}

impl Normals {
    /// Enough values that no grey-level histogram shows the table; 16 KB, which stays in the L1 cache.
    const LENGTH: usize = 4096;
    /// The table's own seed: the table is a constant of this crate.
    const SEED: u64 = 0x007A_6B05;

    pub(crate) fn new() -> Normals {
        let mut stream = Stream::new(Normals::SEED);
        let mut table = Box::new([0.0; Normals::LENGTH]);
        let raw: Vec<f64> = (0..Normals::LENGTH).map(|_| sum_of_twelve(&mut stream)).collect();
        let mean = raw.iter().sum::<f64>() / raw.len() as f64;
        let variance =
            raw.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / raw.len() as f64;
        for (entry, value) in table.iter_mut().zip(&raw) {
            *entry = ((value - mean) / variance.sqrt()) as f32;
        }
        Normals { table }
    }

    /// The value that belongs to `bits`.
    #[inline]
    pub(crate) fn draw(&self, bits: u64) -> f32 {
        self.table[bits as usize % Normals::LENGTH]
    }
}

/// Twelve uniform numbers of variance 1/12 each: variance 1, and close to normal.
fn sum_of_twelve(stream: &mut Stream) -> f64 {
    (0..12).map(|_| stream.unit()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_splitmix64_as_published() {
        // First outputs of the reference implementation for seed 1234567.
        let mut stream = Stream::new(1_234_567);
        assert_eq!(stream.bits(), 6_457_827_717_110_365_317);
        assert_eq!(stream.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn the_table_of_normals_has_mean_zero_and_deviation_one() {
        let normals = Normals::new();
        let mean = normals.table.iter().sum::<f32>() / Normals::LENGTH as f32;
        let variance = normals.table.iter().map(|value| value * value).sum::<f32>() / Normals::LENGTH as f32;
        assert!(mean.abs() < 1e-4, "mean {mean}");
        assert!((variance - 1.0).abs() < 1e-4, "variance {variance}");
    }

    #[test]
    fn about_68_percent_of_the_normals_lie_within_one_deviation() {
        let normals = Normals::new();
        let inside = normals.table.iter().filter(|value| value.abs() < 1.0).count();
        let share = inside as f64 / Normals::LENGTH as f64;
        assert!((share - 0.683).abs() < 0.03, "share {share}");
    }

    #[test]
    fn numbers_between_bounds_stay_there() {
        let mut stream = Stream::new(3);
        for _ in 0..1000 {
            let value = stream.between(-2.0, 5.0);
            assert!((-2.0..5.0).contains(&value));
            assert!(stream.below(7) < 7);
        }
        assert_eq!(stream.below(0), 0);
    }
}
