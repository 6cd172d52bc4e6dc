//! One tag, one detection: of detections of the same tag in the same place the better stays.

use crate::pipeline::Detection;

/// Keeps fewer wrong bits before a larger margin. Other tags in the same place are no matter of this step: a tag may lie in
/// the hole of another one.
pub(crate) fn keep_the_better(mut detections: Vec<Detection>) -> Vec<Detection> {
    detections.sort_by(|a, b| a.hamming.cmp(&b.hamming).then(b.margin.total_cmp(&a.margin)));
    let mut kept: Vec<Detection> = Vec::new();
    for detection in detections {
        let is_same = |other: &Detection| {
            (other.family, other.id) == (detection.family, detection.id)
                && overlap(&other.corners, &detection.corners)
        };
        if !kept.iter().any(is_same) {
            kept.push(detection);
        }
    }
    kept
}

/// Whether two convex quads share any area: no line along a side of either has them on different hands.
fn overlap(a: &[[f64; 2]; 4], b: &[[f64; 2]; 4]) -> bool {
    !sides(a).chain(sides(b)).any(|normal| {
        let (from_a, to_a) = extent(a, normal);
        let (from_b, to_b) = extent(b, normal);
        to_a <= from_b || to_b <= from_a
    })
}

/// Normals of the sides.
fn sides(corners: &[[f64; 2]; 4]) -> impl Iterator<Item = [f64; 2]> {
    let corner = |k: usize| corners[k % 4];
    (0..4).map(move |k| [corner(k)[1] - corner(k + 1)[1], corner(k + 1)[0] - corner(k)[0]])
}

/// The shadow of a quad on a line.
fn extent(corners: &[[f64; 2]; 4], [x, y]: [f64; 2]) -> (f64, f64) {
    let shadows = corners.iter().map(|corner| corner[0] * x + corner[1] * y);
    shadows.fold((f64::MAX, f64::MIN), |(from, to), at| (from.min(at), to.max(at)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> [[f64; 2]; 4] {
        [[x, y + side], [x + side, y + side], [x + side, y], [x, y]]
    }

    #[test]
    fn quads_overlap_when_they_share_area() {
        let one = square(0.0, 0.0, 10.0);
        assert!(overlap(&one, &square(9.0, 9.0, 10.0)));
        assert!(overlap(&one, &square(3.0, 3.0, 2.0)), "one inside the other");
        assert!(!overlap(&one, &square(10.0, 0.0, 10.0)), "touching");
        // Boxes overlap, the quads do not.
        let diamond = [[16.0, 8.0], [24.0, 16.0], [16.0, 24.0], [8.0, 16.0]];
        assert!(!overlap(&one, &diamond));
    }

    #[test]
    fn of_the_same_tag_the_one_with_fewer_wrong_bits_stays_and_other_tags_do_too() {
        let at = |id: u32, hamming: u32, margin: f64, corners| Detection {
            family: 0,
            id,
            hamming,
            margin,
            corners,
        };
        let here = square(0.0, 0.0, 10.0);
        let kept = keep_the_better(vec![
            at(1, 1, 90.0, here),
            at(1, 0, 20.0, square(1.0, 0.0, 9.0)),
            at(1, 0, 10.0, here),
            at(2, 2, 5.0, here),
            at(1, 2, 1.0, square(50.0, 0.0, 10.0)),
        ]);
        let facts: Vec<_> = kept.iter().map(|tag| (tag.id, tag.hamming, tag.margin)).collect();
        assert_eq!(facts, [(1, 0, 20.0), (2, 2, 5.0), (1, 2, 1.0)]);
    }
}
