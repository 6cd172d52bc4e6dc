//! Corners to a fraction of a pixel on the frame at full resolution (after AprilTag 2).
//!
//! Along each side, profiles across it are searched for the place where grey changes most: the mean of all places, each
//! weighed by the square of its change. Changes the other way round belong to some other edge. A new line through these
//! places takes the side's place, and new corners lie where these lines meet.

use tagbus_family::Border;

use crate::line::{Covariance, Line};
use crate::picture::Picture;
use crate::quad::Quad;
use crate::sample::{Sampling, sample};

/// Whether corners are refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// Corners are where the lines through the boundary points meet.
    None,
    /// Sides are moved to where grey changes most.
    Gradients,
}

/// At least so many profiles a side, and one for so many pixels of it. AprilTag's values; no paper names them.
const MIN_PROFILES: usize = 16;
const PIXELS_A_PROFILE: f64 = 8.0;
/// Places on a profile are a quarter of a pixel apart.
const STEPS_A_PIXEL: f64 = 4.0;

/// The quad with refined corners; sides without any place to go to stay where they are. `factor` is that of the
/// decimation, which is how far off sides may be.
pub(crate) fn refine(picture: &Picture, quad: &Quad, factor: f64) -> Quad {
    let lines = [0, 1, 2, 3].map(|k| refined_side(picture, quad, k, factor + 1.0));
    let corner = |k: usize| lines[(k + 3) % 4].meet(&lines[k]).unwrap_or(quad.corners[k]);
    Quad { corners: [0, 1, 2, 3].map(corner), ..*quad }
}

/// The line of the side that begins at corner `k`.
fn refined_side(picture: &Picture, quad: &Quad, k: usize, reach: f64) -> Line {
    let (from, to) = (quad.corners[k], quad.corners[(k + 1) % 4]);
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    let direction = [dx / length, dy / length];
    // Counter-clockwise as seen, what is to the right on the way lies outside.
    let outwards = [-direction[1], direction[0]];
    let profiles = MIN_PROFILES.max((length / PIXELS_A_PROFILE) as usize);
    let places: Vec<[f64; 2]> = (1..=profiles)
        .filter_map(|number| {
            let share = number as f64 / (profiles + 1) as f64;
            let start = [from[0] + share * dx, from[1] + share * dy];
            let off = edge_off(picture, start, outwards, quad.border, reach)?;
            Some(along(start, outwards, off))
        })
        .collect();
    line_through(&places).unwrap_or(Line { point: from, direction })
}

fn along([x, y]: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [x + distance * direction[0], y + distance * direction[1]]
}

/// How far outwards from `start` the edge lies; `None` where nothing changes in the right direction.
fn edge_off(
    picture: &Picture,
    start: [f64; 2],
    outwards: [f64; 2],
    border: Border,
    reach: f64,
) -> Option<f64> {
    let sign = match border {
        Border::Normal => 1.0,
        Border::Reversed => -1.0,
    };
    let steps = (reach * STEPS_A_PIXEL) as i32;
    let (mut weights, mut weighed) = (0.0, 0.0);
    for off in (-steps..=steps).map(|step| f64::from(step) / STEPS_A_PIXEL) {
        let grey = |off: f64| sample(picture, along(start, outwards, off), Sampling::Bilinear);
        let (Some(outer), Some(inner)) = (grey(off + 1.0), grey(off - 1.0)) else { continue };
        let change = (sign * (outer - inner)).max(0.0);
        weights += change * change;
        weighed += change * change * off;
    }
    (weights > 0.0).then(|| weighed / weights)
}

/// The line that fits the places best; `None` for fewer than two of them.
fn line_through(places: &[[f64; 2]]) -> Option<Line> {
    if places.len() < 2 {
        return None;
    }
    let mean_of =
        |value: &dyn Fn(&[f64; 2]) -> f64| places.iter().map(value).sum::<f64>() / places.len() as f64;
    let [x, y] = [mean_of(&|place| place[0]), mean_of(&|place| place[1])];
    let covariance = Covariance {
        xx: mean_of(&|place| (place[0] - x).powi(2)),
        xy: mean_of(&|place| (place[0] - x) * (place[1] - y)),
        yy: mean_of(&|place| (place[1] - y).powi(2)),
    };
    Some(Line { point: [x, y], direction: covariance.longer_axis() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Family;
    use tagbus_scene::{Photo, Placement, Stream, Tag, Turn, View, corners_of, homography_of, photograph};

    #[test]
    fn corners_that_are_off_by_more_than_half_a_pixel_are_brought_back() {
        let mut random = Stream::new(31);
        for name in ["tag36h11", "tagStandard41h12"] {
            let family = Family::published(name).unwrap();
            let border = family.layout().border();
            for _ in 0..20 {
                let turn = Turn { rotation_rad: random.between(0.0, 7.0), ..Turn::default() };
                let view = View { centre: [160.0, 120.0], cell_px: 12.0, turn, ..View::default() };
                let map = homography_of(family.layout(), &view);
                let placement = Placement::new(Tag::new(&family, 3).unwrap(), map);
                let photo =
                    Photo { width: 320, height: 240, blur_sigma: 0.7, noise_sigma: 2.0, ..Photo::default() };
                let picture = Picture::new(320, 240, photograph(&photo, &[placement])).unwrap();
                let truth = corners_of(&map);
                let moved =
                    truth.map(|[x, y]| [x + random.between(-0.7, 0.7), y + random.between(-0.7, 0.7)]);
                let refined = refine(&picture, &Quad { corners: moved, border }, 1.0);
                for ([x, y], [true_x, true_y]) in refined.corners.iter().zip(truth) {
                    let off = (x - true_x).hypot(y - true_y);
                    assert!(off < 0.15, "{name}: {off} px");
                }
            }
        }
    }

    #[test]
    fn a_flat_picture_leaves_corners_where_they_are() {
        let flat = Picture::computed(60, 60, |_, _| 90);
        let corners = [[10.0, 50.0], [50.0, 48.0], [45.0, 12.0], [12.0, 10.0]];
        let refined = refine(&flat, &Quad { corners, border: Border::Normal }, 1.0);
        for (a, b) in refined.corners.iter().zip(corners) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9);
        }
    }
}
