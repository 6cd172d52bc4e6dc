//! Ours at every level, decimation and choice of families, and the C library, taking turns on each picture.

use std::path::PathBuf;

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Detector, Level, LumaView, Phase, Refinement, Settings};
use tagbus_family::Family;

use super::frames::{self, FAMILIES};
use crate::clock::{asking_us, cpu_us, now_us};
use crate::peers::{self, Peer};
use crate::sweep::bar;

pub(super) type Failure = Box<dyn std::error::Error>;

/// The phases in their order.
pub(super) const PHASES: [(Phase, &str); 4] = [
    (Phase::Binarize, "binarize"),
    (Phase::Cluster, "cluster"),
    (Phase::Fit, "fit"),
    (Phase::Identify, "identify"),
];

/// How much is measured.
pub(crate) struct Plan {
    /// A folder of natural pictures.
    pub(crate) pictures: Option<PathBuf>,
    pub(crate) factors: Vec<f64>,
    pub(crate) rounds: usize,
}

/// One choice of families and decimation on one group of frames.
pub(crate) struct Block {
    pub(super) group: &'static str,
    pub(super) frames: usize,
    pub(super) families: String,
    pub(super) factor: f64,
    /// Ours, the plainest level first.
    pub(super) levels: Vec<(Level, Vec<PhaseTimes>)>,
    /// The others' name, and the quickest round on each picture in microseconds.
    pub(super) others: Vec<(String, Vec<f64>)>,
}

/// CPU time of each phase in the round that was the quickest altogether, microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PhaseTimes(pub(super) [f64; 4]);

impl PhaseTimes {
    pub(super) fn total(&self) -> f64 {
        self.0.iter().sum()
    }
}

pub(crate) fn run(plan: &Plan) -> Result<Vec<Block>, Failure> {
    let choices = [FAMILIES[0].to_owned(), FAMILIES[1].to_owned(), FAMILIES.join("+")];
    let groups = frames::groups(plan.pictures.as_deref())?;
    let bar = bar(groups.len() * choices.len() * plan.factors.len(), "phases");
    let mut blocks = Vec::new();
    for group in &groups {
        for families in &choices {
            for factor in &plan.factors {
                blocks.push(block(group, families, *factor, plan.rounds)?);
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    Ok(blocks)
}

fn block(group: &frames::Group, families: &str, factor: f64, rounds: usize) -> Result<Block, Failure> {
    let mut ours = Level::available()
        .into_iter()
        .map(|level| Ok((level, detector(families, factor, level)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let mut others = peers::all(families, factor)?.split_off(1);
    let mut levels: Vec<_> = ours.iter().map(|(level, _)| (*level, Vec::new())).collect();
    let mut times: Vec<_> = others.iter().map(|peer| (peer.name(), Vec::new())).collect();
    let frames: Vec<_> = group.frames.iter().filter(|frame| frame.is_for(families)).collect();
    for frames::Frame { picture, .. } in &frames {
        let (phases, totals) = measure(&mut ours, &mut others, picture, rounds)?;
        levels.iter_mut().zip(phases).for_each(|((_, list), phases)| list.push(phases));
        times.iter_mut().zip(totals).for_each(|((_, list), total)| list.push(total));
    }
    Ok(Block {
        group: group.name,
        frames: frames.len(),
        families: families.to_owned(),
        factor,
        levels,
        others: times,
    })
}

/// With all that there is to refinement.
fn detector(families: &str, factor: f64, level: Level) -> Result<Detector, Failure> {
    let families: Result<Vec<Family>, _> = families.split('+').map(Family::published).collect();
    let decimation = Decimation::from_factor(factor)?;
    let settings = Settings { decimation, refinement: Refinement::Tag, ..Settings::default() };
    let mut detector = Detector::new(&families?, &settings)?;
    detector.set_level(level);
    Ok(detector)
}

/// The quickest rounds of all, after one that only warms up.
fn measure(
    ours: &mut [(Level, Detector)],
    others: &mut [Box<dyn Peer>],
    picture: &Picture,
    rounds: usize,
) -> Result<(Vec<PhaseTimes>, Vec<f64>), Failure> {
    let view = LumaView::grey(&picture.luma, picture.width, picture.height)?;
    let mut phases = vec![PhaseTimes([f64::INFINITY; 4]); ours.len()];
    let mut totals = vec![f64::INFINITY; others.len()];
    for round in 0..=rounds {
        for ((_, detector), best) in ours.iter_mut().zip(&mut phases) {
            let times = timed(detector, &view);
            if round > 0 && times.total() < best.total() {
                *best = times;
            }
        }
        for (peer, best) in others.iter_mut().zip(&mut totals) {
            peer.prepare(picture)?;
            let (us, ()) = cpu_us(|| peer.detect(picture, &mut Vec::new()));
            if round > 0 {
                *best = best.min(us);
            }
        }
    }
    Ok((phases, totals))
}

/// What it takes to ask the clock is taken off every phase, as it is taken off the others' only one.
fn timed(detector: &mut Detector, view: &LumaView) -> PhaseTimes {
    let (mut times, asking) = ([0.0; 4], asking_us());
    let mut before = now_us() + asking;
    detector.detect_observed(view, |phase| {
        let now = now_us();
        if let Some(place) = PHASES.iter().position(|(known, _)| *known == phase) {
            times[place] += now - before;
        }
        before = now + asking;
    });
    PhaseTimes(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_takes_time_and_together_they_are_the_search() {
        let picture = frames::groups(None).unwrap().pop().unwrap().frames.remove(0).picture;
        let view = LumaView::grey(&picture.luma, picture.width, picture.height).unwrap();
        let mut detector = detector("tag36h11+tagStandard41h12", 1.0, Level::SCALAR).unwrap();
        let (us, times) = cpu_us(|| timed(&mut detector, &view));
        assert!(times.0.iter().all(|us| *us > 0.0), "{times:?}");
        assert!(times.total() <= us);
    }
}
