//! All detectors taking turns on the same frames.

use indicatif::{ProgressBar, ProgressStyle};
use tagbus_camera::picture::Picture;
use tagbus_scene::Stream;

use super::score::{Score, score};
use crate::clock::cpu_us;
use crate::peers::{self, Choice, Hit, Peer};
use crate::sets::{Bin, Renderer};

/// Of the orders in which detectors take their turns.
pub(crate) const ORDER_SEED: u64 = 1;

type Failure = Box<dyn std::error::Error>;

/// How much is measured.
pub(crate) struct Plan {
    pub(crate) frames: usize,
    pub(crate) rounds: usize,
    pub(crate) detectors: Choice,
}

/// One configuration of one detector and what it did on every frame.
pub(crate) struct Line {
    pub(crate) family: String,
    pub(crate) name: String,
    pub(crate) factor: f64,
    pub(crate) variant: String,
    pub(crate) frames: Vec<Measured>,
}

/// One detector on one frame.
pub(crate) struct Measured {
    pub(crate) bin: Bin,
    pub(crate) score: Score,
    pub(crate) times: Times,
}

/// CPU time of the quickest and of the middle round (between the two middle ones of an even number), microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Times {
    pub(crate) min_us: f64,
    pub(crate) median_us: f64,
}

impl Times {
    pub(crate) fn of(mut rounds_us: Vec<f64>) -> Times {
        rounds_us.sort_by(f64::total_cmp);
        let at = |index: usize| rounds_us.get(index).copied().unwrap_or(0.0);
        let (low, high) = (rounds_us.len().saturating_sub(1) / 2, rounds_us.len() / 2);
        Times { min_us: at(0), median_us: 0.5 * (at(low) + at(high)) }
    }
}

/// Measures all detectors on the first frames of a set. Frames live one at a time.
pub(crate) fn run(renderer: &Renderer, plan: &Plan) -> Result<Vec<Line>, Failure> {
    let family = renderer.family().name();
    let mut peers = peers::sweep(family, &plan.detectors)?;
    let mut lines: Vec<Line> = peers.iter().map(|peer| empty_line(family, peer.as_ref())).collect();
    let bar = bar(plan.frames, &format!("{} {family}", renderer.recipe().name));
    let mut random = Stream::new(ORDER_SEED);
    for index in 0..plan.frames {
        let frame = renderer.frame(index)?;
        if index == 0 {
            measure(&mut peers, &frame.picture, 1, &mut random)?;
        }
        let results = measure(&mut peers, &frame.picture, plan.rounds, &mut random)?;
        for (line, (hits, times)) in lines.iter_mut().zip(results) {
            line.frames.push(Measured { bin: frame.bin, score: score(&hits, &frame.truth), times });
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(lines)
}

/// In each round every detector takes one turn, so that what else the machine does hits all alike; in an order drawn anew, so
/// that none always follows one that leaves it the caches as it needs them, or full of something else.
pub(crate) fn measure(
    peers: &mut [Box<dyn Peer>],
    picture: &Picture,
    rounds: usize,
    random: &mut Stream,
) -> Result<Vec<(Vec<Hit>, Times)>, Failure> {
    let mut hits = vec![Vec::new(); peers.len()];
    let mut times = vec![Vec::with_capacity(rounds); peers.len()];
    for peer in peers.iter_mut() {
        peer.prepare(picture)?;
    }
    for _ in 0..rounds {
        for turn in shuffled(peers.len(), random) {
            let (peer, hits) = (&mut peers[turn], &mut hits[turn]);
            hits.clear();
            // So that where a detector lies is not looked up in its time: tables of pages that others have driven out to memory take
            // microseconds.
            std::hint::black_box(peer.factor());
            let (us, ()) = cpu_us(|| peer.detect(picture, hits));
            times[turn].push(peer.own_cpu_us().unwrap_or(us));
        }
    }
    Ok(hits.into_iter().zip(times.into_iter().map(Times::of)).collect())
}

/// The numbers below `count` in an order that is as likely as any other.
fn shuffled(count: usize, random: &mut Stream) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for end in (1..count).rev() {
        order.swap(end, random.below(end as u64 + 1) as usize);
    }
    order
}

pub(super) fn empty_line(family: &str, peer: &dyn Peer) -> Line {
    Line {
        family: family.to_owned(),
        name: peer.name(),
        factor: peer.factor(),
        variant: peer.variant(),
        frames: Vec::new(),
    }
}

/// A bar on a terminal, and nothing elsewhere. It draws only when it is told to: no thread of its own that would be
/// measured with the detectors.
pub(crate) fn bar(count: usize, title: &str) -> ProgressBar {
    let bar = ProgressBar::new(count as u64).with_message(title.to_owned());
    match ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sets::named;
    use tagbus_family::Family;

    #[test]
    fn times_are_the_least_and_the_middle_one() {
        assert_eq!(Times::of(vec![5.0, 1.0, 9.0]), Times { min_us: 1.0, median_us: 5.0 });
        assert_eq!(Times::of(vec![9.0, 1.0, 5.0, 2.0]), Times { min_us: 1.0, median_us: 3.5 });
        assert_eq!(Times::of(Vec::new()), Times { min_us: 0.0, median_us: 0.0 });
    }

    #[test]
    fn every_detector_takes_one_turn_a_round_in_changing_orders() {
        let mut random = Stream::new(3);
        let orders: Vec<Vec<usize>> = (0..20).map(|_| shuffled(5, &mut random)).collect();
        for order in &orders {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4]);
        }
        for place in 0..5 {
            assert!((0..5).all(|turn| orders.iter().any(|order| order[place] == turn)), "place {place}");
        }
    }

    #[test]
    fn our_detector_finds_near_tags_of_both_polarities_with_good_corners() {
        for family in ["tag36h11", "tagStandard41h12"] {
            let renderer = Renderer::new(named("near").unwrap(), Family::published(family).unwrap(), 1);
            let detectors = Choice { only: "tagbus".to_owned(), python: None };
            let lines = run(&renderer, &Plan { frames: 12, rounds: 1, detectors }).unwrap();
            assert_eq!(lines[0].factor, 1.0);
            for measured in &lines[0].frames {
                let errors = measured.score.found.expect("tags of 5 pixels a cell and more are found");
                assert!(errors.worst() < 0.5, "{:?}: {}", measured.bin, errors.worst());
                assert_eq!(measured.score.wrong, 0);
            }
        }
    }
}
