//! How much contrast a tile must have before it says anything: learnt from the frame itself.
//!
//! A fixed limit either fills a noisy wall with components or loses dim tags. The range of 16 normal samples has its
//! 5 % quantile at 2.3 sigma, so the 5 % quantile of all 4x4 tile ranges tells sigma as long as a twentieth of the
//! frame is flat. A window of 3x3 tiles without content then stays below 8 sigma.

use crate::simd::{Kernel, Level};

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
/// The largest range that is told apart: from far below on the limit is the same.
const MOST: u8 = NO_VOTE - 1;
/// Values that are counted in 16 bits, so that many are counted at once.
const PART: usize = 4096;
/// Where the search for a range begins.
const FIRST_GUESS: u8 = 8;

/// The range (largest minus smallest value) of each tile that may vote, or [`NO_VOTE`].
#[derive(Default)]
pub(super) struct Ranges {
    values: Vec<u8>,
    /// How many there are; what follows is of another frame.
    count: usize,
}

impl Ranges {
    /// Forgets all, and makes room for so many tiles.
    pub(super) fn clear(&mut self, room: usize) {
        self.values.resize(room, 0);
        self.count = 0;
    }

    /// Adds a row of tiles; what lies behind the last one does not vote.
    #[inline(always)]
    pub(super) fn add(&mut self, minima: &[u8], maxima: &[u8]) {
        let to = &mut self.values[self.count..][..minima.len()];
        self.count += to.len();
        for ((to, low), high) in to.iter_mut().zip(minima).zip(maxima) {
            // A range is only counted where it is known: the smallest value below white, the largest above black. No branch: vectors.
            let is_clipped = (*low >= UNCLIPPED.end) | (*high < UNCLIPPED.start);
            *to = high.wrapping_sub(*low).min(MOST) | (NO_VOTE * u8::from(is_clipped));
        }
    }

    /// How many are at most so large.
    #[inline(always)]
    fn at_most(&self, largest: u8) -> usize {
        let mut sum = 0;
        for part in self.values[..self.count].chunks(PART) {
            let mut count = 0_u16;
            for range in part {
                count += u16::from(*range <= largest);
            }
            sum += usize::from(count);
        }
        sum
    }
}

/// The least range of a 3x3 window of tiles that counts as content, in grey levels, from the ranges of the tiles that vote.
pub(super) fn contrast_limit<'r, R>(level: Level, ranges: R, are_averages: bool) -> u8
where
    R: Iterator<Item = &'r Ranges> + Clone,
{
    let sigma = level.run(FlatRange(ranges)) / FLAT_RANGE_SIGMAS;
    let sigmas = if are_averages { SIGMAS_OF_AVERAGES } else { SIGMAS };
    ((sigmas * sigma.max(0.0)).ceil() as u32).clamp(LIMITS.0, LIMITS.1) as u8
}

/// Finds the range below which a twentieth of the tiles lie, as if those of one range lay evenly between its neighbours.
struct FlatRange<R>(R);

impl<'r, R: Iterator<Item = &'r Ranges> + Clone> Kernel for FlatRange<R> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let voters = at_most(&self.0, MOST);
        let wanted = voters as f32 * FLAT_SHARE;
        if voters == 0 {
            return 0.0;
        }
        // Ranges of noise are small, so the search begins with these. `below` are those of less than `range`, too few.
        let (mut range, mut below, mut enough) = (0, 0, FIRST_GUESS);
        let mut up_to_enough = at_most(&self.0, enough);
        while (up_to_enough as f32) < wanted {
            (range, below) = (enough + 1, up_to_enough);
            enough = enough.saturating_mul(2).min(MOST);
            up_to_enough = at_most(&self.0, enough);
        }
        while range < enough {
            let middle = range + (enough - range) / 2;
            let count = at_most(&self.0, middle);
            if (count as f32) < wanted {
                (range, below) = (middle + 1, count);
            } else {
                (enough, up_to_enough) = (middle, count);
            }
        }
        f32::from(range) - 0.5 + (wanted - below as f32) / (up_to_enough - below) as f32
    }
}

#[inline(always)]
fn at_most<'r>(ranges: &(impl Iterator<Item = &'r Ranges> + Clone), largest: u8) -> usize {
    let mut sum = 0;
    for ranges in ranges.clone() {
        sum += ranges.at_most(largest);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(minima: &[u8], maxima: &[u8]) -> Ranges {
        let mut ranges = Ranges::default();
        ranges.clear(minima.len());
        ranges.add(minima, maxima);
        ranges
    }

    fn limit(minima: &[u8], maxima: &[u8]) -> u8 {
        contrast_limit(Level::best(), std::iter::once(&ranges(minima, maxima)), false)
    }

    /// The range below which a twentieth lie, by going through all of them in order.
    fn flat_range_in_order(mut ranges: Vec<u8>) -> f32 {
        ranges.sort_unstable();
        let wanted = ranges.len() as f32 * FLAT_SHARE;
        let Some(range) = ranges.get((wanted.ceil() as usize).max(1) - 1) else { return 0.0 };
        let below = ranges.iter().filter(|other| *other < range).count();
        let count = ranges.iter().filter(|other| *other == range).count();
        f32::from(*range) - 0.5 + (wanted - below as f32) / count as f32
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
    fn every_level_finds_the_range_that_going_through_all_in_order_finds() {
        let mut state = 7_u32;
        let mut byte = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for length in (0..300).chain([20_000, 40_001]) {
            let largest = byte().max(1);
            let of_tiles: Vec<u8> = (0..length).map(|_| byte() % largest).collect();
            let split = length * 2 / 3;
            let parts = [&of_tiles[..split], &of_tiles[split..]].map(|part| {
                ranges(&vec![20; part.len()], &part.iter().map(|r| r.saturating_add(20)).collect::<Vec<_>>())
            });
            let expected = flat_range_in_order(of_tiles.iter().map(|r| r.saturating_add(20) - 20).collect());
            for level in Level::available() {
                assert_eq!(level.run(FlatRange(parts.iter())), expected, "{level}, {length} tiles");
            }
        }
    }

    #[test]
    fn clipped_tiles_do_not_vote() {
        let of = |low: &[u8], high: &[u8]| Level::best().run(FlatRange(std::iter::once(&ranges(low, high))));
        assert_eq!(of(&[90, 250, 0, 255, 90], &[93, 255, 5, 255, 93]), of(&[90, 90], &[93, 93]));
    }
}
