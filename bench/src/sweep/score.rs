//! What a list of hits is worth.

use tagbus_scene::{Point, TrueTag};

use crate::accuracy::{CornerErrors, in_order_of};
use crate::peers::Hit;

/// What a detector did on one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Score {
    /// Tags that are there.
    pub(crate) tags: u32,
    /// The corners of those that were found; `None` when there was none among them.
    pub(crate) found: Option<CornerErrors>,
    /// How many were found.
    pub(crate) hits: u32,
    /// Hits where there is no such tag: wrong ids, and right ids in the wrong place.
    pub(crate) wrong: u32,
}

/// A tag counts as found when a hit with its id has its middle within half a side of the tag's: what is farther off is
/// another thing, what is nearer counts with its full error.
const REACH_IN_SIDES: f64 = 0.5;

/// Matches hits with tags, each with one other at most.
pub(crate) fn score(hits: &[Hit], truth: &[TrueTag]) -> Score {
    let mut score = Score { tags: truth.len() as u32, ..Score::default() };
    let mut open: Vec<&TrueTag> = truth.iter().collect();
    for hit in hits {
        match open.iter().position(|tag| tag.id == hit.id && lies_at(hit, tag)) {
            Some(index) => {
                let tag = open.swap_remove(index);
                let errors = score.found.get_or_insert_default();
                errors.add(&in_order_of(&tag.corners, &hit.corners), &tag.corners);
                score.hits += 1;
            }
            None => score.wrong += 1,
        }
    }
    score
}

fn lies_at(hit: &Hit, tag: &TrueTag) -> bool {
    let ([x, y], [true_x, true_y]) = (middle(&hit.corners), middle(&tag.corners));
    let side = (tag.corners[0][0] - tag.corners[2][0]).hypot(tag.corners[0][1] - tag.corners[2][1])
        * std::f64::consts::FRAC_1_SQRT_2;
    (x - true_x).hypot(y - true_y) < REACH_IN_SIDES * side
}

fn middle(corners: &[Point; 4]) -> Point {
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Point; 4] = [[10.0, 20.0], [20.0, 20.0], [20.0, 10.0], [10.0, 10.0]];

    fn truth() -> [TrueTag; 1] {
        let homography = [5.0, 0.0, 15.0, 0.0, 5.0, 15.0, 0.0, 0.0, 1.0];
        [TrueTag {
            family: "tag36h11".to_owned(),
            id: 7,
            corners: CORNERS,
            homography,
            visible: true,
            cell_px: 1.0,
        }]
    }

    #[test]
    fn a_tag_counts_once_and_every_other_hit_is_wrong() {
        let right = Hit { id: 7, corners: CORNERS };
        let wrong_id = Hit { id: 8, ..right };
        let wrong_place = Hit { id: 7, corners: CORNERS.map(|[x, y]| [x + 30.0, y]) };
        let score = score(&[wrong_place, right, wrong_id, right], &truth());
        assert_eq!((score.tags, score.hits, score.wrong), (1, 1, 3));
        assert!(score.found.unwrap().rms() < 1e-12);
    }

    #[test]
    fn without_tags_every_hit_is_wrong() {
        let score = score(&[Hit { id: 7, corners: CORNERS }], &[]);
        assert_eq!((score.tags, score.hits, score.wrong), (0, 0, 1));
    }
}
