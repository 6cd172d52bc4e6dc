//! All detectors taking turns on the costly frames and on natural pictures of the same size.

use std::path::PathBuf;

use tagbus_camera::picture::Picture;
use tagbus_scene::Stream;

use super::frames::PATTERNS;
use crate::memory::peak_during;
use crate::peers::{self, Peer};
use crate::sweep::{ORDER_SEED, Times, bar, load_scaled, measure};

type Failure = Box<dyn std::error::Error>;

/// Sizes of frames in pixels.
const SIZES: [[usize; 2]; 2] = [[1296, 964], [1920, 1080]];
/// One family of either polarity, and both.
const FAMILIES: [&str; 3] = ["tag36h11", "tagStandard41h12", "tag36h11+tagStandard41h12"];

/// How much is measured.
pub(crate) struct Plan {
    pub(crate) pictures: PathBuf,
    pub(crate) factors: Vec<f64>,
    pub(crate) rounds: usize,
}

/// The detectors for one choice of families on the frames of one size.
pub(crate) struct Group {
    pub(super) size: [usize; 2],
    pub(super) factor: f64,
    pub(super) families: &'static str,
    /// Ours first.
    pub(super) detectors: Vec<String>,
    /// Means over all natural pictures, a value a detector.
    pub(super) natural: Vec<Times>,
    pub(super) natural_count: usize,
    pub(super) rows: Vec<Row>,
}

/// All detectors of a group on one frame.
pub(super) struct Row {
    pub(super) frame: String,
    pub(super) times: Vec<Times>,
    /// What ours reports; there is nothing to be found.
    pub(super) hits: usize,
    /// The most bytes that a fresh detector of ours allocates for this frame.
    pub(super) bytes: usize,
}

pub(crate) fn run(plan: &Plan) -> Result<Vec<Group>, Failure> {
    let mut groups = Vec::new();
    for size in SIZES {
        let natural = load_scaled(&plan.pictures, size.map(|side| side as u32))?;
        for factor in &plan.factors {
            for families in FAMILIES {
                groups.push(group(size, *factor, families, &natural, plan.rounds)?);
            }
        }
    }
    Ok(groups)
}

fn group(
    size: [usize; 2],
    factor: f64,
    families: &'static str,
    natural: &[Picture],
    rounds: usize,
) -> Result<Group, Failure> {
    let mut peers = peers::all(families, factor)?;
    let bar = bar(natural.len() + PATTERNS.len(), &format!("{families} {}x{}", size[0], size[1]));
    let mut times = Vec::new();
    let mut random = Stream::new(ORDER_SEED);
    for picture in natural {
        // The first round warms up.
        measure(&mut peers, picture, 1, &mut random)?;
        times.push(
            measure(&mut peers, picture, rounds, &mut random)?.into_iter().map(|(_, times)| times).collect(),
        );
        bar.inc(1);
    }
    let mut rows = Vec::new();
    for pattern in PATTERNS {
        rows.push(row(&mut peers, families, pattern.name(), &pattern.picture(size), rounds)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let detectors = peers.iter().map(|peer| peer.name()).collect();
    let natural_count = natural.len();
    Ok(Group { size, factor, families, detectors, natural: means(&times), natural_count, rows })
}

fn row(
    peers: &mut [Box<dyn Peer>],
    families: &str,
    frame: String,
    picture: &Picture,
    rounds: usize,
) -> Result<Row, Failure> {
    let bytes = bytes_of_a_fresh_detector(families, peers[0].factor(), picture)?;
    let mut random = Stream::new(ORDER_SEED);
    measure(peers, picture, 1, &mut random)?;
    let results = measure(peers, picture, rounds, &mut random)?;
    let hits = results.first().map_or(0, |(hits, _)| hits.len());
    Ok(Row { frame, times: results.into_iter().map(|(_, times)| times).collect(), hits, bytes })
}

/// For the frame alone: tables of codes are made with the detector and do not depend on what is seen.
fn bytes_of_a_fresh_detector(families: &str, factor: f64, picture: &Picture) -> Result<usize, Failure> {
    let mut fresh = peers::ours(families, factor)?;
    Ok(peak_during(|| fresh.detect(picture, &mut Vec::new())))
}

/// Means over pictures, a value a detector.
fn means(pictures: &[Vec<Times>]) -> Vec<Times> {
    let count = pictures.len().max(1) as f64;
    let detectors = pictures.first().map_or(0, Vec::len);
    let mean = |value: &dyn Fn(&Times) -> f64, detector: usize| {
        pictures.iter().map(|times| value(&times[detector])).sum::<f64>() / count
    };
    (0..detectors)
        .map(|detector| Times {
            min_us: mean(&|times| times.min_us, detector),
            median_us: mean(&|times| times.median_us, detector),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_taken_over_pictures_for_each_detector() {
        let times = |min_us: f64| Times { min_us, median_us: 2.0 * min_us };
        let means = means(&[vec![times(1.0), times(10.0)], vec![times(3.0), times(20.0)]]);
        assert_eq!(means, [times(2.0), times(15.0)]);
    }

    #[test]
    fn no_costly_frame_is_a_tag() {
        let size = [480, 360];
        for pattern in PATTERNS {
            let mut peers = vec![peers::ours(FAMILIES[2], 1.0).unwrap()];
            let row = row(&mut peers, FAMILIES[2], pattern.name(), &pattern.picture(size), 1).unwrap();
            assert_eq!(row.hits, 0, "{pattern:?}");
        }
    }
}
