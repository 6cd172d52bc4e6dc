//! How much contrast a tile must have before it says anything: learnt from the frame itself.
//!
//! A fixed limit either fills a noisy wall with components or loses dim tags. The range of 16 normal samples has its
//! 5 % quantile at 2.3 sigma, so the 5 % quantile of all 4x4 tile ranges tells sigma as long as a twentieth of the
//! frame is flat. A window of 3x3 tiles without content then stays below 8 sigma.

/// Sigmas of noise that a window of 144 samples must exceed to count as content.
const SIGMAS: f32 = 8.0;
/// The same where values are averages of pixels that their neighbours share: their ranges in a tile are a little smaller, and
/// with weak noise rounding takes more off them.
const SIGMAS_OF_AVERAGES: f32 = 9.0;
/// Limits of the contrast asked for, in grey levels: compression noise, and dim tags in strong noise.
const LIMITS: (u32, u32) = (5, 40);
/// Share of the tiles that is taken as flat.
const FLAT_SHARE: f32 = 0.05;
/// That share of the ranges of 16 samples of noise lies below this many sigmas.
const FLAT_RANGE_SIGMAS: f32 = 2.3;
/// Every how many rows of tiles votes.
pub(super) const ROW_STEP: usize = 4;
/// Tiles that the sensor may have clipped do not vote: they look flat without being so.
const UNCLIPPED: std::ops::Range<u8> = 6..250;

/// Whether a row of tiles says what the noise is.
#[inline(always)]
pub(super) fn votes(tile_row: usize) -> bool {
    tile_row % ROW_STEP == 1
}

/// How many unclipped tiles have each range (largest minus smallest value).
pub(super) struct Ranges([u32; 256]);

impl Default for Ranges {
    fn default() -> Self {
        Self([0; 256])
    }
}

impl Ranges {
    pub(super) fn clear(&mut self) {
        self.0.fill(0);
    }

    /// Counts a row of tiles.
    #[inline(always)]
    pub(super) fn add(&mut self, minima: &[u8], maxima: &[u8]) {
        for (low, high) in minima.iter().zip(maxima) {
            // A range is only counted where it is known: the smallest value below white, the largest above black.
            if *low < UNCLIPPED.end && *high >= UNCLIPPED.start {
                self.0[usize::from(high - low)] += 1;
            }
        }
    }

    pub(super) fn add_all(&mut self, others: &Ranges) {
        self.0.iter_mut().zip(&others.0).for_each(|(count, other)| *count += other);
    }
}

/// The least range of a 3x3 window of tiles that counts as content, in grey levels, from the ranges of the tiles that vote.
pub(super) fn contrast_limit(ranges: &Ranges, are_averages: bool) -> u8 {
    let quantile = flat_range(&ranges.0);
    let sigma = (quantile / FLAT_RANGE_SIGMAS).max(0.0);
    let sigmas = if are_averages { SIGMAS_OF_AVERAGES } else { SIGMAS };
    ((sigmas * sigma).ceil() as u32).clamp(LIMITS.0, LIMITS.1) as u8
}

/// The range below which a twentieth of the tiles lie, interpolated inside its histogram bin.
fn flat_range(counts: &[u32; 256]) -> f32 {
    let wanted = counts.iter().sum::<u32>() as f32 * FLAT_SHARE;
    let mut below = 0.0;
    for (range, count) in counts.iter().enumerate() {
        let count = *count as f32;
        if count > 0.0 && below + count >= wanted {
            return range as f32 - 0.5 + (wanted - below) / count;
        }
        below += count;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(minima: &[u8], maxima: &[u8]) -> u8 {
        let mut ranges = Ranges::default();
        ranges.add(minima, maxima);
        contrast_limit(&ranges, false)
    }

    #[test]
    fn a_flat_frame_asks_for_the_least_contrast() {
        assert_eq!(limit(&[100; 64], &[100; 64]), 5);
    }

    #[test]
    fn an_empty_histogram_asks_for_the_least_contrast() {
        assert_eq!(limit(&[], &[]), 5);
        assert_eq!(limit(&[255; 16], &[255; 16]), 5, "all clipped");
    }

    #[test]
    fn the_limit_follows_the_noise_and_is_clamped() {
        let of_range = |range: u8| limit(&[100; 64], &[100 + range; 64]);
        assert!(of_range(5) > 12 && of_range(5) < 22, "{}", of_range(5));
        assert_eq!(of_range(60), 40);
    }

    #[test]
    fn ranges_that_are_counted_apart_are_those_of_the_whole() {
        let (mut sum, mut rest) = (Ranges::default(), Ranges::default());
        sum.add(&[90; 40], &[93; 40]);
        rest.add(&[90; 9], &[101; 9]);
        rest.clear();
        rest.add(&[80; 24], &[101; 24]);
        sum.add_all(&rest);
        assert_eq!((sum.0[3], sum.0[11], sum.0[21]), (40, 0, 24));
    }
}
