//! Every detector at every distance.

use tagbus_scene::TrueTag;

use super::landing::{FAMILY, Landing};
use crate::peers::{self, Hit, Peer};
use crate::sweep::{bar, score};

pub(super) type Failure = Box<dyn std::error::Error>;

/// The paper's range in metres (IV-A).
pub(super) const NEAREST_M: f64 = 0.08;
pub(super) const FARTHEST_M: f64 = 16.15;
/// From one distance to the next.
const STEP: f64 = 1.02;
/// Beyond this nobody looks any more: cells of the outermost tag are smaller than a pixel.
const HORIZON_M: f64 = 60.0;

/// How much is measured.
pub(crate) struct Plan {
    /// Decimation factors.
    pub(crate) factors: Vec<f64>,
    /// Frames of every distance.
    pub(crate) seeds: u64,
    /// Another seed gives other frames.
    pub(crate) seed: u64,
}

/// One detector at all distances, the nearest first.
pub(crate) struct Line {
    pub(super) name: String,
    pub(super) factor: f64,
    pub(super) distances: Vec<Seen>,
}

/// In how many frames of one distance something was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    pub(super) distance_m: f64,
    pub(super) frames: u32,
    /// Any of the three tags.
    pub(super) found: u32,
    /// The outermost, the middle and the innermost tag.
    pub(super) levels: [u32; 3],
    /// Hits that are none of the three tags.
    pub(super) wrong: u32,
}

impl Seen {
    /// At least nine of ten.
    pub(super) fn is_enough(&self, count: u32) -> bool {
        10 * count >= 9 * self.frames
    }

    fn add(&mut self, hits: &[Hit], truth: &[TrueTag]) {
        self.frames += 1;
        self.wrong += score(hits, truth).wrong;
        let mut any = false;
        for (count, tag) in self.levels.iter_mut().zip(truth) {
            let found = score(hits, std::slice::from_ref(tag)).hits;
            *count += found;
            any |= found > 0;
        }
        self.found += u32::from(any);
    }
}

/// Looks at the pad from the paper's range and on, until nobody finds it.
pub(crate) fn run(plan: &Plan) -> Result<Vec<Line>, Failure> {
    let landing = Landing::new()?;
    let mut peers: Vec<Box<dyn Peer>> = Vec::new();
    for factor in &plan.factors {
        peers.extend(peers::all(FAMILY, *factor)?);
    }
    let mut lines: Vec<Line> = peers.iter().map(|peer| empty_line(peer.as_ref())).collect();
    let distances = distances();
    let bar = bar(distances.len(), "recursive");
    for (index, distance_m) in distances.into_iter().enumerate() {
        let mut seen = vec![Seen { distance_m, ..Seen::default() }; peers.len()];
        for repetition in 0..plan.seeds {
            let frame = landing.frame(distance_m, seed_of(plan.seed, index as u64, repetition))?;
            for (peer, seen) in peers.iter_mut().zip(&mut seen) {
                let mut hits = Vec::new();
                peer.prepare(&frame.picture)?;
                peer.detect(&frame.picture, &mut hits);
                seen.add(&hits, &frame.truth);
            }
        }
        let nobody = seen.iter().all(|seen| seen.found == 0);
        for (line, seen) in lines.iter_mut().zip(seen) {
            line.distances.push(seen);
        }
        bar.inc(1);
        if nobody && distance_m > FARTHEST_M {
            break;
        }
    }
    bar.finish_and_clear();
    Ok(lines)
}

fn empty_line(peer: &dyn Peer) -> Line {
    Line { name: peer.name(), factor: peer.factor(), distances: Vec::new() }
}

/// The paper's range in steps of 2 %, its end, and the same steps on from there.
fn distances() -> Vec<f64> {
    let from = |first: f64| std::iter::successors(Some(first), |distance| Some(distance * STEP));
    let within = from(NEAREST_M).take_while(|distance| *distance < FARTHEST_M);
    within.chain(from(FARTHEST_M).take_while(|distance| *distance < HORIZON_M)).collect()
}

/// A seed of its own for every frame.
fn seed_of(seed: u64, index: u64, repetition: u64) -> u64 {
    (seed << 32) ^ (index << 12) ^ repetition
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_go_from_end_to_end_of_the_papers_range_in_steps_of_two_percent() {
        let distances = distances();
        let within: Vec<f64> = distances.iter().copied().filter(|distance| *distance <= FARTHEST_M).collect();
        assert_eq!((within[0], *within.last().unwrap()), (NEAREST_M, FARTHEST_M));
        assert_eq!(within.len(), 270);
        assert!(distances.windows(2).all(|pair| pair[1] / pair[0] < STEP + 1e-9));
    }

    #[test]
    fn the_tag_is_found_all_the_way_and_another_one_takes_over_from_time_to_time() {
        let landing = Landing::new().unwrap();
        let mut ours = peers::all(FAMILY, 1.0).unwrap().swap_remove(0);
        for (distance_m, expected) in [(0.08, 2), (0.3, 1), (10.0, 0)] {
            let mut seen = Seen::default();
            for seed in 0..5 {
                let frame = landing.frame(distance_m, seed).unwrap();
                let mut hits = Vec::new();
                ours.detect(&frame.picture, &mut hits);
                seen.add(&hits, &frame.truth);
            }
            assert_eq!(
                (seen.found, seen.levels[expected], seen.wrong),
                (5, 5, 0),
                "{distance_m} m: {seen:?}"
            );
        }
    }
}
