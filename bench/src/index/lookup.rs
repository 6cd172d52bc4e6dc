//! How long a look-up takes.

use std::hint::black_box;

use tagbus_family::{Family, Index};
use tagbus_scene::Stream;

use super::probe::{random_code, tag_with_errors};
use crate::clock::cpu_us;
use crate::sweep::Times;

/// Different codes of one round: enough that no branch is foretold by what it was the round before.
const CODES: usize = 20_000;

/// Nanoseconds of CPU time a look-up: the means of the quickest and of the middle round.
pub(super) struct LookupNs {
    pub(super) least: f64,
    pub(super) median: f64,
}

impl LookupNs {
    fn of(times: Times, count: usize) -> LookupNs {
        let each = |us: f64| us * 1e3 / count as f64;
        LookupNs { least: each(times.min_us), median: each(times.median_us) }
    }
}

/// Looks up random codes: what background gives.
pub(super) fn of_random_codes(family: &Family, index: &Index, rounds: usize, seed: u64) -> LookupNs {
    let mut random = Stream::new(seed);
    let codes: Vec<u64> = (0..CODES).map(|_| random_code(family, &mut random)).collect();
    time(&codes, rounds, |code| usize::from(index.lookup(code).is_some()))
}

/// Looks up tags in any rotation with as many wrong bits as are corrected.
pub(super) fn of_tags(family: &Family, index: &Index, rounds: usize, seed: u64) -> LookupNs {
    let mut random = Stream::new(seed);
    let tag = |_| tag_with_errors(family, index.hamming(), &mut random);
    let codes: Vec<u64> = (0..CODES).map(tag).collect();
    time(&codes, rounds, |code| usize::from(index.lookup(code).is_some()))
}

/// Looks up each random code in all families, one after the other, so that they drive each other out of the caches.
pub(super) fn in_all(loaded: &[(Family, Index)], rounds: usize, seed: u64) -> LookupNs {
    let mut random = Stream::new(seed);
    let codes: Vec<u64> = (0..CODES).map(|_| random.bits()).collect();
    time(&codes, rounds, |code| loaded.iter().filter(|(_, index)| index.lookup(code).is_some()).count())
}

/// Times `look_up`, which says in how many families it found the code.
fn time(codes: &[u64], rounds: usize, look_up: impl Fn(u64) -> usize) -> LookupNs {
    let round = |_| cpu_us(|| black_box(codes.iter().map(|&code| look_up(code)).sum::<usize>())).0;
    // The first round is a warm-up.
    let times = (0..=rounds).map(round).skip(1).collect();
    LookupNs::of(Times::of(times), codes.len())
}
