//! All candidates at once, for the second half of a complete search: by then nearly every candidate lies too close to a
//! code, and it is quicker to strike out whole balls around the codes than to ask candidate by candidate.
//!
//! For each value of the low bits a bitmap holds all values of the high bits. A code whose low bits differ from that
//! value in t forbids a ball of radius distance - 1 - t in it. Only balls that are large enough to pay are struck out;
//! what is left is compared with the codes one by one.

use super::balls::{Balls, Forbidden, HIGH_BITS};
use super::judge::Judge;
use super::level::{Kernel, Level};
use super::near::any_within;
use super::state::Sweep;
use crate::candidates::Candidates;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Smaller balls than of this radius are not struck out.
const LEAST_BALL: u32 = 5;
/// Codes whose balls would be smaller than this are not among those compared first.
const LEAST_NEAR: u32 = 4;
/// Values of the low bits between two looks at the observer, and how many a thread takes at once.
const ROUND: u64 = 1 << 15;
const BATCH: u64 = 64;

/// A sweep that goes on from where it was left.
pub(super) struct Sweeper<'a> {
    judge: &'a Judge,
    candidates: Candidates,
    distance: u32,
    level: Level,
    threads: usize,
    low_bits: u32,
    /// Up to this number candidates are decided already.
    decided: u64,
    /// All rotations of the codes found so far, their low bits, and their high bits.
    codes: Vec<u64>,
    lows: Vec<u32>,
    highs: Vec<u32>,
    balls: Balls,
}

impl<'a> Sweeper<'a> {
    /// Sweeps with the codes `found`, all that there are among the candidates up to number `decided`.
    pub(super) fn new(search: &super::Search, judge: &'a Judge, decided: u64, found: &[u64]) -> Sweeper<'a> {
        let candidates = search.recipe.candidates();
        let codes: Vec<u64> =
            found.iter().flat_map(|&number| judge.rotations(candidates.code(number))).collect();
        let low_bits = search.recipe.layout().bit_count() - HIGH_BITS;
        let lows = codes.iter().map(|code| (code & ((1 << low_bits) - 1)) as u32).collect();
        let highs = codes.iter().map(|code| (code >> low_bits) as u32).collect();
        Sweeper {
            judge,
            candidates,
            distance: search.recipe.distance(),
            level: search.level,
            threads: search.threads,
            low_bits,
            decided,
            codes,
            lows,
            highs,
            balls: Balls::new(),
        }
    }

    /// How many values the low bits have.
    pub(super) fn lows(&self) -> u64 {
        1 << self.low_bits
    }

    /// Goes through some more values of the low bits.
    pub(super) fn advance(&self, sweep: &mut Sweep) {
        let round = sweep.lows_done..(sweep.lows_done + ROUND).min(self.lows());
        let next = AtomicU64::new(round.start);
        let work = || {
            let mut desk = Desk::new(self.codes.len());
            let mut survivors = Vec::new();
            loop {
                let first = next.fetch_add(BATCH, Ordering::Relaxed);
                if first >= round.end {
                    return survivors;
                }
                let lows = first..(first + BATCH).min(round.end);
                self.level.run(Strike { sweeper: self, lows, desk: &mut desk });
                survivors.extend(desk.left.drain(..).filter_map(|code| self.surviving_number(code)));
            }
        };
        sweep.survivors.extend(super::on_threads(self.threads, work));
        sweep.lows_done = round.end;
    }

    /// The number of a candidate that is far from all codes, if it is not decided yet and the judge allows it.
    fn surviving_number(&self, code: u64) -> Option<u64> {
        let number = match self.candidates.number(code) {
            // The sequence begins with number 1 and comes to number 0 at its end.
            0 => 1 << (self.low_bits + HIGH_BITS),
            number => number,
        };
        (number > self.decided && self.judge.allows(code)).then_some(number)
    }
}

/// What a thread needs to work, kept from one value to the next.
struct Desk {
    forbidden: Forbidden,
    /// In how many of its low bits each code differs from the value.
    differences: Vec<u8>,
    /// Codes with balls that are struck out, by radius.
    struck: Vec<(u32, u32)>,
    near: Vec<u64>,
    /// Candidates that are far from all codes.
    left: Vec<u64>,
}

impl Desk {
    fn new(code_count: usize) -> Desk {
        Desk {
            forbidden: Forbidden::none(),
            // Filled up with differences that no code has.
            differences: vec![64; code_count.next_multiple_of(8)],
            struck: Vec::new(),
            near: Vec::new(),
            left: Vec::new(),
        }
    }
}

/// Finds the candidates with these low bits that are far from all codes.
struct Strike<'a> {
    sweeper: &'a Sweeper<'a>,
    lows: Range<u64>,
    desk: &'a mut Desk,
}

impl Kernel for Strike<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for low in self.lows {
            self.sweeper.sort(low as u32, self.desk);
            self.desk.forbidden.clear();
            for &(radius, high) in &self.desk.struck {
                self.desk.forbidden.forbid(&self.sweeper.balls, high, radius);
            }
            self.sweeper.compare(low, self.desk);
        }
    }
}

impl Sweeper<'_> {
    /// Picks the codes whose balls are struck out and those that are compared first.
    #[inline(always)]
    fn sort(&self, low: u32, desk: &mut Desk) {
        for (difference, code_low) in desk.differences.iter_mut().zip(&self.lows) {
            *difference = (code_low ^ low).count_ones() as u8;
        }
        let reach = (self.distance - 1).saturating_sub(LEAST_NEAR) as u8;
        desk.struck.clear();
        desk.near.clear();
        for group in 0..desk.differences.len() / 8 {
            let eight = desk.differences.as_chunks::<8>().0[group];
            // Eight differences at once: a high bit is left where one is at most `reach`.
            let above = u64::from_le_bytes(eight) + u64::from_le_bytes([0x7f - reach; 8]);
            let mut close = !above & 0x8080_8080_8080_8080;
            while close != 0 {
                self.place(group * 8 + close.trailing_zeros() as usize / 8, desk);
                close &= close - 1;
            }
        }
    }

    #[inline(always)]
    fn place(&self, code: usize, desk: &mut Desk) {
        let radius = self.distance - 1 - u32::from(desk.differences[code]);
        if radius >= LEAST_BALL {
            desk.struck.push((radius, self.highs[code]));
        } else {
            desk.near.push(self.codes[code]);
        }
    }

    /// Compares the candidates that are left, first with the codes that are most likely too close.
    #[inline(always)]
    fn compare(&self, low: u64, desk: &mut Desk) {
        for (place, &chunk) in desk.forbidden.chunks().iter().enumerate() {
            let mut allowed = !chunk;
            while allowed != 0 {
                let high = place as u64 * 64 + u64::from(allowed.trailing_zeros());
                allowed &= allowed - 1;
                let code = high << self.low_bits | low;
                // No closure takes part: it would be compiled without the level's instructions.
                if !any_within(code, &desk.near, self.distance)
                    && !any_within(code, &self.codes, self.distance)
                {
                    desk.left.push(code);
                }
            }
        }
    }
}
