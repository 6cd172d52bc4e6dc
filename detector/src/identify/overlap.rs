//! One tag, one detection: of detections in the same place the better stays. A tag inside the hole of another is no
//! overlap: nested tags of a recursive family are all kept.

use super::reader::Reader;
use crate::detection::Detection;

/// Removes the worse of every two detections that overlap.
pub(crate) fn keep_the_better(readers: &[Reader], detections: &mut Vec<Detection>) {
    // A stable sort would allocate.
    detections.sort_unstable_by(|a, b| {
        sureness(readers, a).total_cmp(&sureness(readers, b)).then(b.margin.total_cmp(&a.margin))
    });
    let mut kept = 0;
    for candidate in 0..detections.len() {
        let (better, rest) = detections.split_at(kept);
        let current = rest[candidate - kept];
        if !better.iter().any(|other| overlaps(readers, other, &current)) {
            detections[kept] = current;
            kept += 1;
        }
    }
    detections.truncate(kept);
}

/// The smaller, the surer: the chance of such a reading from random bits.
fn sureness(readers: &[Reader], detection: &Detection) -> f64 {
    readers[detection.family].chance(detection.hamming)
}

/// Inside this share of a tag's half width from its middle its hole may hold another tag.
const HOLE_REACH: f64 = 0.4;

/// Whether the middle of the smaller one lies inside the larger one and not in its hole.
fn overlaps(readers: &[Reader], a: &Detection, b: &Detection) -> bool {
    let (area_a, area_b) = (area(&a.corners), area(&b.corners));
    let (small, large, ratio) =
        if area_a < area_b { (a, b, area_a / area_b) } else { (b, a, area_b / area_a) };
    if !contains(&large.corners, small.center) {
        return false;
    }
    let middle_off = (small.center[0] - large.center[0]).hypot(small.center[1] - large.center[1]);
    let nested = readers[large.family].has_hole
        && ratio < HOLE_REACH * HOLE_REACH
        && middle_off < HOLE_REACH * 0.5 * area_a.max(area_b).sqrt();
    !nested
}

fn area(corners: &[[f64; 2]; 4]) -> f64 {
    let doubled: f64 = (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
            ax * by - bx * ay
        })
        .sum();
    doubled.abs() * 0.5
}

/// Whether a point lies on the same hand of all four sides.
fn contains(corners: &[[f64; 2]; 4], [x, y]: [f64; 2]) -> bool {
    let hand = |k: usize| {
        let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    };
    (0..4).all(|k| hand(k) > 0.0) || (0..4).all(|k| hand(k) < 0.0)
}
