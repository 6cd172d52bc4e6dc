//! The points of a contour in the order in which a line of sight that turns around its middle meets them (III-C 3).
//!
//! Angles are those from the middle of the contour's box, x right and y down, so that they grow clockwise as seen:
//!
//! ```text
//!         -90
//!    III   |   IV        eq. 2, from its least key to its largest:
//!  180 ----+---- 0  x        x < 0, y < 0    -2^16 + y/x   III
//!     II   |   I             x > 0, y < 0          - x/y   IV
//!          90                x > 0, y > 0     2^16 + y/x   I
//!          y                 x < 0, y > 0     2^17 - x/y   II
//! ```

use tagbus_family::Border;

use crate::contours::BoundaryPoint;

/// Contours of fewer points are not looked at: six a side. AprilTag's value; no paper names it.
const MIN_POINTS: usize = 24;

/// What stands for the angle of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortKey {
    /// Quadrant and slope (equation 2).
    Slope,
    /// The angle itself, as before.
    Atan2,
}

/// Larger than any slope in a picture of at most 2^13 pixels a side, in quarter pixels.
const QUADRANT: f64 = 65_536.0;

impl SortKey {
    /// The key of a point relative to the middle; keys of both kinds order points alike.
    ///
    /// Equation 2 has no case for points on an axis. They get what keeps the order of atan2, which begins right after
    /// 180 degrees, ends at 180 degrees and calls the middle itself 0 degrees.
    fn of(self, [x, y]: [i64; 2]) -> f64 {
        let (fx, fy) = (x as f64, y as f64);
        match (self, x.signum(), y.signum()) {
            (SortKey::Atan2, _, _) => fy.atan2(fx),
            (SortKey::Slope, -1, -1) => -QUADRANT + fy / fx,
            (SortKey::Slope, 0, -1) => 0.0,
            (SortKey::Slope, 1, -1) => -fx / fy,
            (SortKey::Slope, 0 | 1, 0) => QUADRANT,
            (SortKey::Slope, 1, _) => QUADRANT + fy / fx,
            (SortKey::Slope, 0, _) => 2.0 * QUADRANT,
            (SortKey::Slope, _, 0) => 3.0 * QUADRANT,
            (SortKey::Slope, _, _) => 2.0 * QUADRANT - fx / fy,
        }
    }
}

/// A contour in the order of its angles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outline {
    /// The middle of its box, in quarter pixels from the top-left corner of the decimated picture.
    pub(crate) middle: [i64; 2],
    /// Its points from there, in quarter pixels: whole numbers, so that sums over them are exact.
    pub(crate) points: Vec<[i64; 2]>,
    /// Which side of it is white.
    pub(crate) border: Border,
}

/// Quarter pixels in a pixel.
pub(crate) const QUARTERS: f64 = 4.0;

/// The outline of a contour, unless that is too short.
pub(crate) fn outline(contour: &[BoundaryPoint], key: SortKey) -> Option<Outline> {
    if contour.len() < MIN_POINTS {
        return None;
    }
    let middle = middle_of_box(contour);
    let mut keyed: Vec<(f64, [i64; 2])> = contour
        .iter()
        .map(|point| {
            let from_middle = relative(point, middle);
            (key.of(from_middle), from_middle)
        })
        .collect();
    // Stable: points in the same direction stay in the order of the contour, whatever the key.
    keyed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let points = keyed.into_iter().map(|(_, point)| point).collect();
    Some(Outline { middle, points, border: border(contour, middle) })
}

/// In quarter pixels, where it is a whole number.
fn middle_of_box(contour: &[BoundaryPoint]) -> [i64; 2] {
    [0, 1].map(|axis| {
        let along = contour.iter().map(|point| i64::from(point.at[axis]));
        along.clone().min().unwrap_or(0) + along.max().unwrap_or(0)
    })
}

fn relative(point: &BoundaryPoint, middle: [i64; 2]) -> [i64; 2] {
    [0, 1].map(|axis| 2 * i64::from(point.at[axis]) - middle[axis])
}

/// White outside when most points, weighed by their distance, lead away from the middle on their way to white.
fn border(contour: &[BoundaryPoint], middle: [i64; 2]) -> Border {
    let outwards = |point: &BoundaryPoint| {
        let [x, y] = relative(point, middle);
        x * i64::from(point.to_white[0]) + y * i64::from(point.to_white[1])
    };
    match contour.iter().map(outwards).sum::<i64>() > 0 {
        true => Border::Normal,
        false => Border::Reversed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::Stream;

    #[test]
    fn both_keys_order_every_pair_of_a_small_square_alike() {
        let reach = -9..=9;
        let all: Vec<[i64; 2]> = reach.clone().flat_map(|y| reach.clone().map(move |x| [x, y])).collect();
        for a in &all {
            for b in &all {
                let order = |key: SortKey| key.of(*a).total_cmp(&key.of(*b));
                assert_eq!(order(SortKey::Slope), order(SortKey::Atan2), "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn both_keys_order_points_of_the_largest_picture_alike() {
        let mut random = Stream::new(7);
        let mut coordinate = || random.below(1 << 15) as i64 - (1 << 14);
        for _ in 0..200_000 {
            let (a, [dx, dy]) = ([coordinate(), coordinate()], [coordinate() % 3, coordinate() % 3]);
            let b = [a[0] + dx, a[1] + dy];
            let order = |key: SortKey| key.of(a).total_cmp(&key.of(b));
            assert_eq!(order(SortKey::Slope), order(SortKey::Atan2), "{a:?} and {b:?}");
        }
    }

    /// Points on a circle, black inside.
    fn ring(sign: i32) -> Vec<BoundaryPoint> {
        let at = |step: usize| (step as f64 * 0.1).sin_cos();
        (0..60)
            .map(|step| {
                let (sine, cosine) = at(step * 7 % 60);
                let round = |v: f64| (40.0 * v).round() as i32;
                let to_white = [cosine, sine].map(|v| sign * v.round() as i32);
                BoundaryPoint { at: [100 + round(cosine), 80 + round(sine)], to_white }
            })
            .collect()
    }

    #[test]
    fn an_outline_goes_round_once_and_knows_on_which_side_white_is() {
        for (sign, border) in [(1, Border::Normal), (-1, Border::Reversed)] {
            let outlines = [SortKey::Slope, SortKey::Atan2].map(|key| outline(&ring(sign), key).unwrap());
            assert_eq!(outlines[0], outlines[1]);
            assert_eq!(outlines[0].border, border);
            let angles = outlines[0].points.iter().map(|[x, y]| (*y as f64).atan2(*x as f64));
            assert!(angles.is_sorted());
        }
    }

    #[test]
    fn the_middle_is_that_of_the_box_and_short_contours_are_dropped() {
        let points = &ring(1);
        let outline = outline(points, SortKey::Slope).unwrap();
        for (axis, middle) in [(0, outline.middle[0]), (1, outline.middle[1])] {
            let reach = |v: i64| outline.points.iter().map(|point| v * point[axis]).max();
            assert_eq!(reach(1), reach(-1));
            assert!((middle - [200, 160][axis]).abs() <= 2);
        }
        assert!(super::outline(&points[..MIN_POINTS - 1], SortKey::Slope).is_none());
    }
}
