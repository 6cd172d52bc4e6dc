//! Detectors with different numbers of threads taking turns on each picture.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Detector, LumaView, Settings};
use tagbus_family::Family;

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
    /// For each picture.
    pub(super) times: Vec<Times>,
}

/// A list for each group: a line for each number of threads.
pub(crate) fn run(plan: &Plan) -> Result<Vec<Vec<Line>>, Failure> {
    let groups = frames::groups(plan.pictures.as_deref())?;
    let bar = bar(groups.iter().map(|group| group.pictures.len()).sum(), "threads");
    let block = |group: &Group| {
        let lines = block(group, plan, || bar.inc(1));
        lines.map_err(|error| format!("{}: {error}", group.name).into())
    };
    let blocks = groups.iter().map(block).collect();
    bar.finish_and_clear();
    blocks
}

fn block(group: &Group, plan: &Plan, done: impl Fn()) -> Result<Vec<Line>, Failure> {
    let Group { name, size: [width, height], pictures } = group;
    let mut detectors =
        plan.threads.iter().map(|threads| detector(plan, *threads)).collect::<Result<Vec<_>, _>>()?;
    let line = |threads: &usize| Line {
        group: format!("{name} {width}x{height}"),
        threads: *threads,
        tags: 0,
        times: Vec::new(),
    };
    let mut lines: Vec<Line> = plan.threads.iter().map(line).collect();
    for picture in pictures {
        let tags = found_by_all(&mut detectors, picture)?;
        for (line, times) in lines.iter_mut().zip(measure(&mut detectors, picture, plan)?) {
            line.tags += tags;
            line.times.push(times);
        }
        done();
    }
    Ok(lines)
}

fn detector(plan: &Plan, threads: usize) -> Result<Detector, Failure> {
    let families: Result<Vec<Family>, _> = FAMILIES.into_iter().map(Family::published).collect();
    let decimation = Decimation::from_factor(plan.factor)?;
    Ok(Detector::new(&families?, &Settings { decimation, threads, ..Settings::default() })?)
}

/// Warms up, and refuses to time detectors that do not agree.
fn found_by_all(detectors: &mut [Detector], picture: &Picture) -> Result<usize, Failure> {
    let view = LumaView::grey(&picture.luma, picture.width, picture.height)?;
    let mut found = detectors.iter_mut().map(|detector| detector.detect(&view).to_vec());
    let first = found.next().unwrap_or_default();
    match found.all(|tags| tags == first) {
        true => Ok(first.len()),
        false => Err("detectors with different numbers of threads disagree".into()),
    }
}

fn measure(detectors: &mut [Detector], picture: &Picture, plan: &Plan) -> Result<Vec<Times>, Failure> {
    let view = LumaView::grey(&picture.luma, picture.width, picture.height)?;
    let mut walls = vec![Vec::new(); detectors.len()];
    for _ in 0..plan.rounds.max(1) {
        for (detector, walls) in detectors.iter_mut().zip(&mut walls) {
            std::thread::sleep(plan.pause);
            let start = Instant::now();
            detector.detect(&view);
            walls.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(walls.into_iter().map(times_of).collect())
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
        }
        assert!(blocks.iter().any(|lines| lines[0].tags > 10), "the scene's tags were not found");
    }

    #[test]
    fn the_least_and_the_middle_of_wall_times_are_kept() {
        assert_eq!(times_of(vec![3.0, 1.0, 2.0]), Times { least: 1.0, median: 2.0 });
    }
}
