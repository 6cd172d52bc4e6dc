//! How much contrast a tile must have before it says anything: learnt from the frame itself.
//!
//! A fixed limit either fills a noisy wall with components or loses dim tags. The range of 16 normal samples has its
//! 5 % quantile at 2.3 sigma, so the 5 % quantile of all 4x4 tile ranges tells sigma as long as a twentieth of the
//! frame is flat. A window of 3x3 tiles without content then stays below 8 sigma.

use super::cuts::{Extremes, LANES};

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

/// Stands for the range of a tile that does not vote.
const NO_VOTE: u8 = u8::MAX;
/// Ranges that are told apart: with this one and more the largest contrast is asked for.
const TOLD_APART: usize = 12;
/// What ranges are compared with: each of these, and the largest that there is.
const COMPARED: [u8; TOLD_APART + 1] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, NO_VOTE - 1];
/// Blocks of tiles that are counted in bytes.
const BLOCKS: usize = u8::MAX as usize;

/// How many of the tiles that may vote have a range (largest minus smallest value) of at most each of [`COMPARED`].
#[derive(Default)]
pub(super) struct Ranges {
    at_most: [u32; COMPARED.len()],
}

impl Ranges {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds a row of tiles; what lies behind the last one does not vote.
    #[inline(always)]
    pub(super) fn add(&mut self, row: Extremes) {
        for (minima, maxima) in row.minima.chunks(BLOCKS).zip(row.maxima.chunks(BLOCKS)) {
            let mut counts = [[0; LANES]; COMPARED.len()];
            for (minima, maxima) in minima.iter().zip(maxima) {
                let ranges = votes_of(minima, maxima);
                for (count, largest) in counts.iter_mut().zip(COMPARED) {
                    for l in 0..LANES {
                        count[l] += u8::from(ranges[l] <= largest);
                    }
                }
            }
            for (sum, counts) in self.at_most.iter_mut().zip(counts) {
                *sum += counts.iter().map(|count| u32::from(*count)).sum::<u32>();
            }
        }
    }
}

/// The range of each of some tiles, or [`NO_VOTE`].
#[inline(always)]
fn votes_of(minima: &[u8; LANES], maxima: &[u8; LANES]) -> [u8; LANES] {
    let mut ranges = [0; LANES];
    for l in 0..LANES {
        // A range is only known where the smallest value is below white and the largest above black. No branch: vectors.
        let is_clipped = (minima[l] >= UNCLIPPED.end) | (maxima[l] < UNCLIPPED.start);
        ranges[l] = maxima[l].wrapping_sub(minima[l]).min(NO_VOTE - 1) | (NO_VOTE * u8::from(is_clipped));
    }
    ranges
}

/// The least range of a 3x3 window of tiles that counts as content, in grey levels, from the ranges of the tiles that vote.
pub(super) fn contrast_limit<'r>(ranges: impl Iterator<Item = &'r Ranges>, are_averages: bool) -> u8 {
    let mut at_most = [0; COMPARED.len()];
    for ranges in ranges {
        at_most.iter_mut().zip(ranges.at_most).for_each(|(sum, count)| *sum += count);
    }
    let sigma = flat_range(&at_most) / FLAT_RANGE_SIGMAS;
    let sigmas = if are_averages { SIGMAS_OF_AVERAGES } else { SIGMAS };
    ((sigmas * sigma.max(0.0)).ceil() as u32).clamp(LIMITS.0, LIMITS.1) as u8
}

/// The range below which a twentieth of the tiles lie, as if those of one range lay evenly between its neighbours; from
/// [`TOLD_APART`] on that.
fn flat_range(at_most: &[u32; COMPARED.len()]) -> f32 {
    let wanted = at_most[TOLD_APART] as f32 * FLAT_SHARE;
    let is_enough = |count: &u32| *count as f32 >= wanted;
    match at_most[..TOLD_APART].iter().position(is_enough) {
        _ if wanted == 0.0 => 0.0,
        None => TOLD_APART as f32,
        Some(range) => {
            let below = if range > 0 { at_most[range - 1] } else { 0 };
            range as f32 - 0.5 + (wanted - below as f32) / (at_most[range] - below) as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cuts::{NO_MAXIMUM, NO_MINIMUM};
    use super::*;

    /// Of tiles whose extremes these are, in rows of no more than a few blocks.
    fn ranges(minima: &[u8], maxima: &[u8]) -> Ranges {
        let mut ranges = Ranges::default();
        for (minima, maxima) in minima.chunks(300 * LANES).zip(maxima.chunks(300 * LANES)) {
            let room = minima.len().next_multiple_of(LANES);
            let (mut low, mut high) = (vec![NO_MINIMUM; room], vec![NO_MAXIMUM; room]);
            low[..minima.len()].copy_from_slice(minima);
            high[..maxima.len()].copy_from_slice(maxima);
            ranges.add(Extremes::new(&low, &high));
        }
        ranges
    }

    fn limit(minima: &[u8], maxima: &[u8]) -> u8 {
        contrast_limit(std::iter::once(&ranges(minima, maxima)), false)
    }

    /// The limit from the range below which a twentieth lie, by going through all of them in order.
    fn limit_in_order(mut ranges: Vec<u8>) -> u8 {
        ranges.sort_unstable();
        let wanted = ranges.len() as f32 * FLAT_SHARE;
        let Some(range) = ranges.get((wanted.ceil() as usize).max(1) - 1) else { return 5 };
        let below = ranges.iter().filter(|other| *other < range).count();
        let count = ranges.iter().filter(|other| *other == range).count();
        let flat = f32::from(*range) - 0.5 + (wanted - below as f32) / count as f32;
        (8.0 * (flat / 2.3).max(0.0)).ceil().clamp(5.0, 40.0) as u8
    }

    #[test]
    fn a_flat_frame_asks_for_the_least_contrast() {
        assert_eq!(limit(&[100; 64], &[100; 64]), 5);
    }

    #[test]
    fn a_frame_without_votes_asks_for_the_least_contrast() {
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
    fn ranges_that_are_not_told_apart_ask_for_the_most() {
        for sigmas in [SIGMAS, SIGMAS_OF_AVERAGES] {
            let least = TOLD_APART as f32 - 0.5;
            assert!((sigmas * least / FLAT_RANGE_SIGMAS).ceil() as u32 >= LIMITS.1, "{sigmas} sigmas");
        }
    }

    #[test]
    fn the_limit_is_that_of_the_range_that_going_through_all_in_order_finds() {
        let mut state = 7_u32;
        let mut byte = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for length in (0..300).chain([20_000, 40_001]) {
            let largest = [byte(), byte() % 32][length % 2].max(1);
            let of_tiles: Vec<u8> = (0..length).map(|_| byte() % largest).collect();
            let split = length * 2 / 3;
            let parts = [&of_tiles[..split], &of_tiles[split..]].map(|part| {
                ranges(&vec![20; part.len()], &part.iter().map(|r| r.saturating_add(20)).collect::<Vec<_>>())
            });
            let expected = limit_in_order(of_tiles.iter().map(|r| r.saturating_add(20) - 20).collect());
            assert_eq!(contrast_limit(parts.iter(), false), expected, "{length} tiles below {largest}");
        }
    }

    #[test]
    fn clipped_tiles_do_not_vote() {
        let of = |low: &[u8], high: &[u8]| ranges(low, high).at_most;
        assert_eq!(of(&[90, 250, 0, 255, 90], &[93, 255, 5, 255, 93]), of(&[90, 90], &[93, 93]));
    }
}
