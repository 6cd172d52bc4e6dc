//! Maps from the plane of a tag to the picture.
//!
//! A homography is a row-major 3x3 matrix with H33 = 1 that maps tag coordinates, in which the border edge is the
//! square [-1, 1]^2 (x right, y down), to pixels ((0, 0) is the top-left corner of the top-left pixel).

/// Row-major 3x3 matrix, scaled so that the last entry is 1.
pub type Homography = [f64; 9];

/// A point in the picture in pixels, or in the plane of a tag, as `[x, y]`.
pub type Point = [f64; 2];

/// The border corners in tag coordinates: bottom-left first, then counter-clockwise as seen in the picture.
const CORNERS: [Point; 4] = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];

/// Where a point of the tag's plane appears in the picture. Not finite on the horizon of the plane.
pub fn project(homography: &Homography, [x, y]: Point) -> Point {
    let h = homography;
    let depth = depth_of(h, [x, y]);
    [(h[0] * x + h[1] * y + h[2]) / depth, (h[3] * x + h[4] * y + h[5]) / depth]
}

/// The four border corners in the picture: `c[0]` is the bottom-left one of the upright tag, and they go on
/// counter-clockwise as seen in the picture. The order follows the tag, whatever way it is turned.
///
/// ```text
///   c[3] ┌──────┐ c[2]
///        │ tag  │
///   c[0] └──────┘ c[1]
/// ```
pub fn corners_of(homography: &Homography) -> [Point; 4] {
    CORNERS.map(|corner| project(homography, corner))
}

/// The distance of a point of the tag's plane from the camera, relative to that of the tag's centre. Points with a
/// depth that is not positive lie behind the camera.
pub(crate) fn depth_of(homography: &Homography, [x, y]: Point) -> f64 {
    homography[6] * x + homography[7] * y + homography[8]
}

/// The map that first applies `x -> scale * x + shift` on both axes of the plane, then `homography`.
pub(crate) fn after_scale_and_shift(homography: &Homography, scale: f64, shift: f64) -> Homography {
    let h = homography;
    let row = |i: usize| [h[i] * scale, h[i + 1] * scale, (h[i] + h[i + 1]) * shift + h[i + 2]];
    let ([a, b, c], [d, e, f], [g, i, j]) = (row(0), row(3), row(6));
    [a / j, b / j, c / j, d / j, e / j, f / j, g / j, i / j, 1.0]
}

/// Pixels per unit of the tag's plane at a point, along the direction in which it is smallest (the smaller singular
/// value of the map's derivative).
pub(crate) fn smallest_scale_at(homography: &Homography, point: Point) -> f64 {
    let h = homography;
    let [px, py] = project(h, point);
    let depth = depth_of(h, point);
    let derivative = |row: usize, column: usize, at: f64| (h[row * 3 + column] - at * h[6 + column]) / depth;
    let (a, b) = (derivative(0, 0, px), derivative(0, 1, px));
    let (c, d) = (derivative(1, 0, py), derivative(1, 1, py));
    let turning = ((a + d) * (a + d) + (c - b) * (c - b)).sqrt();
    let stretching = ((a - d) * (a - d) + (b + c) * (b + c)).sqrt();
    (turning - stretching).abs() / 2.0
}

/// The smallest scale over the four border corners: a plane seen at a slant is smallest where it is farthest away.
pub(crate) fn smallest_scale(homography: &Homography) -> f64 {
    CORNERS.map(|corner| smallest_scale_at(homography, corner)).into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHRINKING: Homography = [30.0, -5.0, 100.0, 4.0, 20.0, 80.0, 0.1, -0.05, 1.0];

    #[test]
    fn an_upright_tag_has_its_first_corner_at_the_bottom_left() {
        let corners = corners_of(&[10.0, 0.0, 50.0, 0.0, 10.0, 50.0, 0.0, 0.0, 1.0]);
        assert_eq!(corners, [[40.0, 60.0], [60.0, 60.0], [60.0, 40.0], [40.0, 40.0]]);
    }

    #[test]
    fn scaling_and_shifting_first_gives_the_same_pixels() {
        let inner = after_scale_and_shift(&SHRINKING, 0.25, 0.5);
        let (direct, nested) = (project(&SHRINKING, [0.75, 0.25]), project(&inner, [1.0, -1.0]));
        assert!((direct[0] - nested[0]).abs() < 1e-9 && (direct[1] - nested[1]).abs() < 1e-9);
        assert_eq!(inner[8], 1.0);
    }

    #[test]
    fn the_smallest_scale_is_the_shortest_step_over_all_directions() {
        const STEP: f64 = 1e-6;
        let centre = project(&SHRINKING, [0.2, 0.3]);
        let shortest = (0..3600)
            .map(|tenth_degree| {
                let (sine, cosine) = (f64::from(tenth_degree) / 10.0).to_radians().sin_cos();
                let [x, y] = project(&SHRINKING, [0.2 + STEP * cosine, 0.3 + STEP * sine]);
                (x - centre[0]).hypot(y - centre[1]) / STEP
            })
            .fold(f64::INFINITY, f64::min);
        assert!((smallest_scale_at(&SHRINKING, [0.2, 0.3]) - shortest).abs() < 1e-3);
    }
}
