//! Whether four corners look like the projection of a square.

use super::rules::{BOX_SLACK, SHARPEST_COSINE};

/// Corners relative to the box's centre, clockwise: convex, no corner sharper than the critical angle, no side shorter
/// than `shortest_side`, all corners near the box of `size` (columns, rows).
#[inline(always)]
pub(super) fn is_tag_like(corners: &[[f64; 2]; 4], size: [f64; 2], shortest_side: f64) -> bool {
    let reach = size.map(|side| side * (0.5 + BOX_SLACK.0) + BOX_SLACK.1);
    (0..4).all(|k| {
        let (a, b, c) = (corners[k], corners[(k + 1) % 4], corners[(k + 2) % 4]);
        let (ux, uy, vx, vy) = (b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]);
        let (u, v) = ((ux * ux + uy * uy).sqrt(), (vx * vx + vy * vy).sqrt());
        let near_box = a[0].abs() <= reach[0] && a[1].abs() <= reach[1];
        let turns_right = ux * vy - uy * vx > 0.0;
        let not_sharp = (ux * vx + uy * vy).abs() <= SHARPEST_COSINE * u * v;
        near_box && turns_right && not_sharp && u >= shortest_side
    })
}

/// The length of the shortest side.
#[inline(always)]
pub(super) fn shortest_of(corners: &[[f32; 2]; 4]) -> f32 {
    let mut least = f32::MAX;
    for k in 0..4 {
        let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 4]);
        least = least.min((bx - ax) * (bx - ax) + (by - ay) * (by - ay));
    }
    least.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]];

    #[test]
    fn a_square_is_tag_like_and_its_mirror_image_is_not() {
        assert!(is_tag_like(&SQUARE, [20.0, 20.0], 8.0));
        let mirrored = [SQUARE[0], SQUARE[3], SQUARE[2], SQUARE[1]];
        assert!(!is_tag_like(&mirrored, [20.0, 20.0], 8.0));
    }

    #[test]
    fn a_short_side_a_dent_and_a_far_corner_are_refused() {
        assert!(!is_tag_like(&SQUARE, [20.0, 20.0], 21.0));
        let dented = [SQUARE[0], SQUARE[1], [-8.0, -8.0], SQUARE[3]];
        assert!(!is_tag_like(&dented, [20.0, 20.0], 1.0));
        assert!(!is_tag_like(&SQUARE, [10.0, 20.0], 8.0));
    }
}
