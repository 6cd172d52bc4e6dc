//! Where an outline may have its corners: where a line fits the points on both sides worst (III-C 3, after AprilTag 2).

use crate::line::{LineError, RunningMoments};

/// A window reaches over a twelfth of the outline to either side, so that it does not span a whole side of a quad, and
/// over no more than this many points. AprilTag's values; no paper names them.
const WINDOW_SHARE: usize = 12;
const MAX_WINDOW: usize = 20;
/// So many of the worst places are kept.
const MAX_CORNERS: usize = 10;

/// The places of up to ten possible corners, in the order of the outline.
pub(crate) fn possible_corners(points: &RunningMoments, how: LineError) -> Vec<usize> {
    let errors = smooth(&window_errors(points, how));
    let mut places = maxima(&errors);
    places.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
    places.truncate(MAX_CORNERS);
    places.sort_unstable();
    places
}

/// For each point the error of the line through the window around it.
fn window_errors(points: &RunningMoments, how: LineError) -> Vec<f64> {
    let count = points.count();
    let reach = (count / WINDOW_SHARE).min(MAX_WINDOW);
    let window = |place: usize| points.stretch((place + count - reach) % count, (place + reach) % count);
    (0..count).map(|place| window(place).line_error(how)).collect()
}

/// A Gaussian of a standard deviation of one point, around the closed row: boundary points step by whole pixels, and
/// every step would be a maximum of its own.
fn smooth(errors: &[f64]) -> Vec<f64> {
    const REACH: usize = 3;
    let count = errors.len();
    let weight = |step: usize| (-0.5 * (step as f64 - REACH as f64).powi(2)).exp();
    let sum: f64 = (0..=2 * REACH).map(weight).sum();
    let around = |place: usize, step: usize| errors[(place + count + step - REACH) % count];
    let smoothed =
        |place: usize| (0..=2 * REACH).map(|step| weight(step) * around(place, step)).sum::<f64>() / sum;
    (0..count).map(smoothed).collect()
}

/// Places above the one before and not below the one after, around the closed row.
fn maxima(errors: &[f64]) -> Vec<usize> {
    let count = errors.len();
    let is_maximum = |place: &usize| {
        let (before, after) = (errors[(place + count - 1) % count], errors[(place + 1) % count]);
        errors[*place] > before && errors[*place] >= after
    };
    (0..count).filter(is_maximum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_a_square_are_its_four_corners() {
        // Clockwise from the top-left corner, a point every quarter pixel times four.
        let side = 120;
        let along = (0..side).map(|at| [4 * at, 0]);
        let down = (0..side).map(|at| [4 * side, 4 * at]);
        let back = (0..side).map(|at| [4 * (side - at), 4 * side]);
        let up = (0..side).map(|at| [0, 4 * (side - at)]);
        let points: Vec<[i64; 2]> = along.chain(down).chain(back).chain(up).collect();
        for how in [LineError::Eigenvalue, LineError::Normal] {
            assert_eq!(possible_corners(&RunningMoments::over(&points), how), [0, 120, 240, 360]);
        }
    }

    #[test]
    fn maxima_are_found_across_the_end_and_on_plateaus_once() {
        assert_eq!(maxima(&[5.0, 1.0, 3.0, 3.0, 0.0, 2.0]), [0, 2]);
        assert!(maxima(&[1.0; 6]).is_empty());
    }

    #[test]
    fn smoothing_keeps_the_sum() {
        let errors: Vec<f64> = (0..29).map(|at| f64::from(at * at % 17)).collect();
        let sums = [&errors, &smooth(&errors)].map(|errors| errors.iter().sum::<f64>());
        assert!((sums[0] - sums[1]).abs() < 1e-9);
    }
}
