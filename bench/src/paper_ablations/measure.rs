//! All cases taking turns on the same frames, beside our detector and, with the feature `peers`, the C library.

use tagbus_camera::picture::Picture;

use super::cases;
use crate::clock::cpu_us;
use crate::peers::{self, Hit, Paper, Peer, Work};
use crate::sets::Renderer;
use crate::sweep::{Score, bar, score};

type Failure = Box<dyn std::error::Error>;

/// One case, or one other detector, and what it did on every frame.
pub(crate) struct Line {
    pub(super) name: String,
    pub(super) factor: f64,
    pub(super) frames: Vec<Measured>,
}

/// One line on one frame.
pub(super) struct Measured {
    pub(super) score: Score,
    pub(super) hits: Vec<Hit>,
    /// CPU time of the quickest round, microseconds.
    pub(super) min_us: f64,
    /// Of the paper's pipeline only: the quickest round of each phase, and counts.
    pub(super) work: Option<Work>,
}

/// Who takes turns.
enum Contestant {
    Case { name: &'static str, paper: Box<Paper> },
    Other(Box<dyn Peer>),
}

impl Contestant {
    fn peer(&mut self) -> &mut dyn Peer {
        match self {
            Self::Case { paper, .. } => paper.as_mut(),
            Self::Other(peer) => peer.as_mut(),
        }
    }

    fn work(&self) -> Option<Work> {
        match self {
            Self::Case { paper, .. } => Some(paper.work()),
            Self::Other(_) => None,
        }
    }

    fn empty_line(&self) -> Line {
        let (name, factor) = match self {
            Self::Case { name, paper } => ((*name).to_owned(), paper.factor()),
            Self::Other(peer) => (format!("{}, {}", peer.name(), peer.variant()), peer.factor()),
        };
        Line { name, factor, frames: Vec::new() }
    }

    /// One more round on the picture that was prepared.
    fn take_turn(&mut self, picture: &Picture, measured: &mut Measured) {
        measured.hits.clear();
        let (us, ()) = cpu_us(|| self.peer().detect(picture, &mut measured.hits));
        measured.min_us = measured.min_us.min(us);
        measured.work = match (measured.work, self.work()) {
            (Some(before), Some(now)) => Some(before.quicker(now)),
            (_, now) => now,
        };
    }
}

/// Measures every case on the first `count` frames of a set. Frames live one at a time.
pub(crate) fn run(renderer: &Renderer, count: usize, rounds: usize) -> Result<Vec<Line>, Failure> {
    let family = renderer.family().name();
    let mut contestants = contestants(family)?;
    let mut lines: Vec<Line> = contestants.iter().map(Contestant::empty_line).collect();
    let bar = bar(count, &format!("{} {family}", renderer.recipe().name));
    for index in 0..count {
        let frame = renderer.frame(index)?;
        let mut results = measure(&mut contestants, &frame.picture, rounds)?;
        for measured in &mut results {
            measured.score = score(&measured.hits, &frame.truth);
        }
        lines.iter_mut().zip(results).for_each(|(line, measured)| line.frames.push(measured));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(lines)
}

/// In each round every contestant takes one turn, so that what else the machine does hits all alike.
fn measure(
    contestants: &mut [Contestant],
    picture: &Picture,
    rounds: usize,
) -> Result<Vec<Measured>, Failure> {
    for contestant in contestants.iter_mut() {
        contestant.peer().prepare(picture)?;
    }
    let untimed =
        || Measured { score: Score::default(), hits: Vec::new(), min_us: f64::INFINITY, work: None };
    let mut results: Vec<Measured> = contestants.iter().map(|_| untimed()).collect();
    for _ in 0..rounds {
        for (contestant, measured) in contestants.iter_mut().zip(&mut results) {
            contestant.take_turn(picture, measured);
        }
    }
    Ok(results)
}

/// The cases, and after them the others at the decimations that occur among the cases.
fn contestants(family: &str) -> Result<Vec<Contestant>, Failure> {
    let mut contestants = Vec::new();
    for case in cases::all() {
        let paper = Box::new(Paper::new(family, case.options, case.name)?);
        contestants.push(Contestant::Case { name: case.name, paper });
    }
    for factor in [1.0, 2.0] {
        contestants.extend(peers::all(family, factor)?.into_iter().map(Contestant::Other));
    }
    Ok(contestants)
}

#[cfg(test)]
mod tests {
    use super::super::cases::PAPER;
    use super::*;
    use crate::sets::named;
    use tagbus_family::Family;

    #[test]
    fn every_case_finds_near_tags_and_counts_what_it_does() {
        let renderer = Renderer::new(named("near").unwrap(), Family::published("tag36h11").unwrap(), 1);
        let lines = run(&renderer, 4, 1).unwrap();
        for line in &lines {
            assert_eq!(line.frames.len(), 4);
            assert!(line.frames.iter().all(|measured| measured.score.hits == 1), "{}", line.name);
            assert!(line.frames.iter().all(|measured| measured.min_us > 0.0), "{}", line.name);
        }
        let unions = |line: &Line| line.frames[0].work.map(|work| work.counts.unions);
        assert_eq!(lines[0].name, PAPER);
        assert!(unions(&lines[0]) < unions(&lines[1]), "line 6 of figure 5 saves unions");
        let others = lines.iter().filter(|line| unions(line).is_none()).count();
        assert!(others >= 2, "our detector at both decimations");
    }
}
