//! Detectors with different numbers of threads taking turns on each picture.

use std::path::PathBuf;
use std::time::Duration;

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Detector, LumaView, Settings};
use tagbus_family::Family;

use super::contest::{Contest, Walls};
use super::cores::Cores;
use super::frames::{self, Group};
use crate::sweep::bar;

pub(super) type Failure = Box<dyn std::error::Error>;

/// One family of either border, so that both planes are searched.
pub(crate) const FAMILIES: [&str; 2] = ["tag36h11", "tagStandard41h12"];

/// How much is measured.
pub(crate) struct Plan {
    /// A folder of natural pictures.
    pub(crate) pictures: Option<PathBuf>,
    pub(crate) factor: f64,
    /// The first is what others are compared with.
    pub(crate) threads: Vec<usize>,
    pub(crate) rounds: usize,
    /// Rest before each search, in which threads fall asleep as they do between the frames of a camera.
    pub(crate) pause: Duration,
}

/// Wall time on one picture, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Times {
    pub(super) least: f64,
    pub(super) median: f64,
}

/// A number of threads on a group of frames.
pub(crate) struct Line {
    pub(super) group: String,
    pub(super) threads: usize,
    pub(super) tags: usize,
    /// For each picture: workers keep off the caller's core.
    pub(super) times: Vec<Times>,
    /// For each picture: the quickest round where the kernel puts threads, milliseconds.
    pub(super) free: Vec<f64>,
    /// For each picture: the quickest round of as many detectors of one thread, all at once, milliseconds.
    pub(super) apart: Vec<f64>,
}

/// A list for each group: a line for each number of threads.
pub(crate) fn run(plan: &Plan) -> Result<Vec<Vec<Line>>, Failure> {
    let groups = frames::groups(plan.pictures.as_deref())?;
    let cores = Cores::of_this_thread()?;
    let bar = bar(groups.iter().map(|group| group.pictures.len()).sum(), "threads");
    let block = |group: &Group| {
        let lines = block(group, plan, &cores, || bar.inc(1));
        lines.map_err(|error| format!("{}: {error}", group.name).into())
    };
    let blocks = groups.iter().map(block).collect();
    cores.set_free()?;
    bar.finish_and_clear();
    blocks
}

fn block(group: &Group, plan: &Plan, cores: &Cores, done: impl Fn()) -> Result<Vec<Line>, Failure> {
    let Group { name, size: [width, height], pictures } = group;
    let contest = |threads: &usize| Contest::new(*threads, cores, |threads| detector(plan, threads));
    let mut contests = plan.threads.iter().map(contest).collect::<Result<Vec<_>, _>>()?;
    let line = |threads: &usize| Line {
        group: format!("{name} {width}x{height}"),
        threads: *threads,
        tags: 0,
        times: Vec::new(),
        free: Vec::new(),
        apart: Vec::new(),
    };
    let mut lines: Vec<Line> = plan.threads.iter().map(line).collect();
    for picture in pictures {
        let tags = found_by_all(&mut contests, picture)?;
        for (line, rounds) in lines.iter_mut().zip(measure(&mut contests, picture, plan, cores)?) {
            line.tags += tags;
            line.add(&rounds);
        }
        done();
    }
    Ok(lines)
}

impl Line {
    /// Adds a picture.
    fn add(&mut self, rounds: &[Walls]) {
        let least = |wall: fn(&Walls) -> f64| rounds.iter().map(wall).fold(f64::INFINITY, f64::min);
        self.times.push(times_of(rounds.iter().map(|walls| walls.pinned).collect()));
        self.free.push(least(|walls| walls.free));
        self.apart.push(least(|walls| walls.apart));
    }
}

fn detector(plan: &Plan, threads: usize) -> Result<Detector, Failure> {
    let families: Result<Vec<Family>, _> = FAMILIES.into_iter().map(Family::published).collect();
    let decimation = Decimation::from_factor(plan.factor)?;
    Ok(Detector::new(&families?, &Settings { decimation, threads, ..Settings::default() })?)
}

/// Warms up, and refuses to time detectors that do not agree.
fn found_by_all(contests: &mut [Contest], picture: &Picture) -> Result<usize, Failure> {
    let view = LumaView::grey(&picture.luma, picture.width, picture.height)?;
    let detectors = contests.iter_mut().flat_map(Contest::detectors);
    let mut found = detectors.map(|detector| detector.detect(&view).to_vec());
    let first = found.next().unwrap_or_default();
    match found.all(|tags| tags == first) {
        true => Ok(first.len()),
        false => Err("detectors with different numbers of threads disagree".into()),
    }
}

/// The rounds of each number of threads.
fn measure(
    contests: &mut [Contest],
    picture: &Picture,
    plan: &Plan,
    cores: &Cores,
) -> Result<Vec<Vec<Walls>>, Failure> {
    let view = LumaView::grey(&picture.luma, picture.width, picture.height)?;
    let mut rounds = vec![Vec::new(); contests.len()];
    for _ in 0..plan.rounds.max(1) {
        for (contest, rounds) in contests.iter_mut().zip(&mut rounds) {
            rounds.push(contest.walls(&view, cores, plan.pause)?);
        }
    }
    Ok(rounds)
}

fn times_of(mut walls: Vec<f64>) -> Times {
    walls.sort_by(f64::total_cmp);
    Times { least: walls[0], median: walls[walls.len() / 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_threads_is_timed_on_every_picture() {
        let plan =
            Plan { pictures: None, factor: 2.0, threads: vec![1, 2], rounds: 1, pause: Duration::ZERO };
        let blocks = run(&plan).unwrap();
        for lines in &blocks {
            assert_eq!(lines.iter().map(|line| line.threads).collect::<Vec<_>>(), [1, 2]);
            assert_eq!(lines[0].times.len(), lines[1].times.len());
            assert!(lines.iter().flat_map(|line| &line.times).all(|times| times.least > 0.0));
            for others in lines.iter().flat_map(|line| [&line.free, &line.apart]) {
                assert_eq!(others.len(), lines[0].times.len());
                assert!(others.iter().all(|ms| *ms > 0.0));
            }
        }
        assert!(blocks.iter().any(|lines| lines[0].tags > 10), "the scene's tags were not found");
    }

    #[test]
    fn each_way_is_told_by_its_own_times() {
        let walls = |pinned, free, apart| Walls { pinned, free, apart };
        let mut line =
            Line { group: String::new(), threads: 2, tags: 0, times: vec![], free: vec![], apart: vec![] };
        line.add(&[walls(3.0, 9.0, 5.0), walls(1.0, 8.0, 6.0), walls(2.0, 7.0, 4.0)]);
        assert_eq!(line.times, [Times { least: 1.0, median: 2.0 }]);
        assert_eq!((line.free, line.apart), (vec![7.0], vec![4.0]));
    }

    #[test]
    fn the_least_and_the_middle_of_wall_times_are_kept() {
        assert_eq!(times_of(vec![3.0, 1.0, 2.0]), Times { least: 1.0, median: 2.0 });
    }
}
