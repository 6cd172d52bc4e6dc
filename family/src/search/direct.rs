//! Candidates in their order, in chunks. Most are dismissed, in any order, because they lie too close to a code found
//! before the chunk; the few that are left are decided one after the other.
//!
//! The sequence grows by a constant, so all candidates whose numbers agree in their low bits agree in their own low
//! bits: they share the codes that resemble them there, which are compared first.

use super::judge::Judge;
use super::level::{Kernel, Level};
use super::near::{Buckets, any_within};
use crate::candidates::Candidates;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Codes that are compared first: 32 KiB, as many as stay in the first cache.
const NEAR_CODES: usize = 4000;
/// Numbers of candidates a chunk, at least and at most.
const CHUNKS: (u64, u64) = (1 << 13, 1 << 26);
/// With fewer survivors than the first the next chunk is larger, with more than the second it is smaller.
const SURVIVORS: (usize, usize) = (2_000, 20_000);

/// The codes found so far and the size of the next chunk.
pub(super) struct Direct<'a> {
    judge: &'a Judge,
    candidates: Candidates,
    distance: u32,
    level: Level,
    threads: usize,
    buckets: Buckets,
    chunk: u64,
}

impl<'a> Direct<'a> {
    /// Goes on after the codes with the numbers `found`.
    pub(super) fn new(search: &'a super::Search, judge: &'a Judge, found: &[u64]) -> Direct<'a> {
        // Small families have too few codes for many buckets.
        let bits = if search.recipe.layout().bit_count() <= 25 { 8 } else { 12 };
        let mut direct = Direct {
            judge,
            candidates: search.recipe.candidates(),
            distance: search.recipe.distance(),
            level: search.level,
            threads: search.threads,
            buckets: Buckets::new(bits),
            chunk: CHUNKS.0,
        };
        found.iter().for_each(|&number| direct.keep(number));
        direct
    }

    fn keep(&mut self, number: u64) {
        for turned in self.judge.rotations(self.candidates.code(number)) {
            self.buckets.insert(turned);
        }
    }

    /// Decides the next candidates from `first` on, at most up to `last`; their codes are added to `found`. Returns the
    /// last that is decided.
    pub(super) fn advance(&mut self, first: u64, last: u64, found: &mut Vec<u64>) -> u64 {
        let end = last.min(first.saturating_add(self.chunk - 1));
        let survivors = self.survivors(first, end);
        self.resize(survivors.len());
        let begin = found.len();
        decide(self.judge, self.candidates, self.distance, &survivors, found);
        for &number in &found[begin..] {
            self.keep(number);
        }
        end
    }

    fn resize(&mut self, survivors: usize) {
        if survivors < SURVIVORS.0 {
            self.chunk = (self.chunk * 2).min(CHUNKS.1);
        } else if survivors > SURVIVORS.1 {
            self.chunk = (self.chunk / 2).max(CHUNKS.0);
        }
    }

    /// The numbers of the candidates that are far from every code found before, increasing.
    fn survivors(&self, first: u64, last: u64) -> Vec<u64> {
        let next = AtomicU64::new(0);
        let work = || {
            let mut survivors = Vec::new();
            let mut near = Vec::new();
            loop {
                let residue = next.fetch_add(1, Ordering::Relaxed);
                if residue >= self.buckets.values() as u64 {
                    return survivors;
                }
                self.residue_class(residue, first..=last, &mut near, &mut survivors);
            }
        };
        let mut survivors = super::on_threads(self.threads, work);
        survivors.sort_unstable();
        survivors
    }

    /// The candidates of a chunk whose numbers end in `residue`.
    fn residue_class(
        &self,
        residue: u64,
        chunk: std::ops::RangeInclusive<u64>,
        near: &mut Vec<u64>,
        survivors: &mut Vec<u64>,
    ) {
        let step = self.buckets.values() as u64;
        let first = chunk.start() + (residue.wrapping_sub(*chunk.start()) & (step - 1));
        if first > *chunk.end() {
            return;
        }
        let low = self.buckets.low(self.candidates.code(first));
        let reach = self.buckets.reach(NEAR_CODES);
        near.clear();
        self.buckets.around(low, 0..reach).for_each(|codes| near.extend_from_slice(codes));
        let numbers = Numbers { first, last: *chunk.end(), step };
        let begin = survivors.len();
        let dismiss =
            Dismiss { candidates: self.candidates, numbers, near, distance: self.distance, left: survivors };
        self.level.run(dismiss);
        self.sift(low, reach..self.buckets.values(), begin, survivors);
    }

    /// Drops those of the survivors from place `begin` on that the judge does not allow or that lie too close to codes
    /// further away in the buckets.
    fn sift(&self, low: u64, places: Range<usize>, begin: usize, survivors: &mut Vec<u64>) {
        let mut kept = begin;
        for place in begin..survivors.len() {
            let code = self.candidates.code(survivors[place]);
            if self.judge.allows(code) && !self.is_within(code, low, places.clone()) {
                survivors[kept] = survivors[place];
                kept += 1;
            }
        }
        survivors.truncate(kept);
    }

    fn is_within(&self, code: u64, low: u64, places: Range<usize>) -> bool {
        self.level.run(Around { buckets: &self.buckets, code, low, places, distance: self.distance })
    }
}

/// Decides candidates that are far from all codes but those of their own lot, one after the other by their increasing
/// `numbers`: the greedy step of the search.
pub(super) fn decide(
    judge: &Judge,
    candidates: Candidates,
    distance: u32,
    numbers: &[u64],
    found: &mut Vec<u64>,
) {
    let mut new = Vec::new();
    for &number in numbers {
        let code = candidates.code(number);
        if !any_within(code, &new, distance) {
            new.extend_from_slice(&judge.rotations(code));
            found.push(number);
        }
    }
}

/// An arithmetic sequence of candidate numbers.
struct Numbers {
    first: u64,
    last: u64,
    step: u64,
}

/// Collects the numbers whose candidates are far from all codes of `near`.
struct Dismiss<'a> {
    candidates: Candidates,
    numbers: Numbers,
    near: &'a [u64],
    distance: u32,
    left: &'a mut Vec<u64>,
}

impl Kernel for Dismiss<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut number = self.numbers.first;
        loop {
            if !any_within(self.candidates.code(number), self.near, self.distance) {
                self.left.push(number);
            }
            number = match number.checked_add(self.numbers.step) {
                Some(next) if next <= self.numbers.last => next,
                _ => return,
            };
        }
    }
}

/// Whether a code is too close to one of the buckets at these places.
struct Around<'a> {
    buckets: &'a Buckets,
    code: u64,
    low: u64,
    places: Range<usize>,
    distance: u32,
}

impl Kernel for Around<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        for codes in self.buckets.around(self.low, self.places) {
            if any_within(self.code, codes, self.distance) {
                return true;
            }
        }
        false
    }
}
