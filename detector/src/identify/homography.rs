//! Plane-to-plane maps (paper III-C): from a square to the quad that it is seen as.

use nalgebra::Matrix3;

use super::sample::LANES;

/// A projective map with its last element 1 (paper eq. 3).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography(Matrix3<f64>);

impl Homography {
    /// The map that takes (0,0), (side,0), (side,side), (0,side) to four corners in that order. With four points the eight
    /// unknowns have a closed form. `None` when three corners lie on a line.
    #[inline(always)]
    pub(crate) fn from_square(corners: &[[f64; 2]; 4], side: f64) -> Option<Self> {
        let [[x0, y0], [x1, y1], [x2, y2], [x3, y3]] = *corners;
        let (dx1, dx2, sx) = (x1 - x2, x3 - x2, x0 - x1 + x2 - x3);
        let (dy1, dy2, sy) = (y1 - y2, y3 - y2, y0 - y1 + y2 - y3);
        let determinant = dx1 * dy2 - dx2 * dy1;
        if determinant.abs() < 1e-9 {
            return None;
        }
        let g = (sx * dy2 - dx2 * sy) / determinant;
        let h = (dx1 * sy - sx * dy1) / determinant;
        Some(Self(Matrix3::new(
            (x1 - x0 + g * x1) / side,
            (x3 - x0 + h * x3) / side,
            x0,
            (y1 - y0 + g * y1) / side,
            (y3 - y0 + h * y3) / side,
            y0,
            g / side,
            h / side,
            1.0,
        )))
    }

    /// The map from the tag square [-1,1]^2 to the picture, from corners in reported order (bottom-left first). Corners
    /// that passed [`Self::from_square`] give a map here too; others the identity.
    pub(crate) fn of_tag(corners: &[[f64; 2]; 4]) -> Self {
        let [bottom_left, bottom_right, top_right, top_left] = *corners;
        let square = Self::from_square(&[top_left, top_right, bottom_right, bottom_left], 2.0);
        let shift = Matrix3::new(1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0);
        let map = square.map_or_else(Matrix3::identity, |square| square.0 * shift);
        Self(map / map[(2, 2)])
    }

    /// Where a point is seen.
    #[inline(always)]
    pub(crate) fn project(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let m = &self.0;
        let scale = 1.0 / (m[(2, 0)] * x + m[(2, 1)] * y + m[(2, 2)]);
        [
            (m[(0, 0)] * x + m[(0, 1)] * y + m[(0, 2)]) * scale,
            (m[(1, 0)] * x + m[(1, 1)] * y + m[(1, 2)]) * scale,
        ]
    }

    /// Where many points are seen, for samples between pixels: to 0.002 pixels in the largest frames.
    #[inline(always)]
    pub(crate) fn project_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [[f32; LANES]; 2] {
        let m = self.0.map(|v| v as f32);
        let mut seen = [[0.0; LANES]; 2];
        for i in 0..LANES {
            let scale = 1.0 / (m[(2, 0)] * x[i] + m[(2, 1)] * y[i] + m[(2, 2)]);
            seen[0][i] = (m[(0, 0)] * x[i] + m[(0, 1)] * y[i] + m[(0, 2)]) * scale;
            seen[1][i] = (m[(1, 0)] * x[i] + m[(1, 1)] * y[i] + m[(1, 2)]) * scale;
        }
        seen
    }

    /// As [`Self::project`], for many points.
    #[inline(always)]
    pub(crate) fn project_lanes(&self, [x, y]: &[[f64; LANES]; 2]) -> [[f64; LANES]; 2] {
        let mut seen = [[0.0; LANES]; 2];
        for i in 0..LANES {
            [seen[0][i], seen[1][i]] = self.project([x[i], y[i]]);
        }
        seen
    }

    /// From nine numbers, row by row.
    pub(crate) fn from_rows(rows: [f64; 9]) -> Self {
        Self(Matrix3::from_row_slice(&rows))
    }

    /// The map back. `None` when the plane is seen edge-on.
    pub(crate) fn inverse(&self) -> Option<Self> {
        let inverse = self.0.try_inverse()?;
        let scale = inverse[(2, 2)];
        (scale.abs() > 1e-12).then(|| Self(inverse / scale))
    }

    /// This map after another one.
    pub(crate) fn after(&self, first: &Matrix3<f64>) -> Self {
        let both = self.0 * first;
        Self(both / both[(2, 2)])
    }

    /// How fast the first and the second coordinate of the image of a point change, whatever the direction.
    #[inline(always)]
    pub(crate) fn stretch(&self, point: [f64; 2]) -> [f64; 2] {
        let m = &self.0;
        let image = self.project(point);
        let scale = 1.0 / (m[(2, 0)] * point[0] + m[(2, 1)] * point[1] + m[(2, 2)]);
        [0, 1].map(|a| {
            let along = |column: usize| (m[(a, column)] - image[a] * m[(2, column)]) * scale;
            along(0).hypot(along(1))
        })
    }

    /// Row by row.
    pub(crate) fn to_array(self) -> [f64; 9] {
        let m = self.0;
        [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 0)], m[(1, 1)], m[(1, 2)], m[(2, 0)], m[(2, 1)], m[(2, 2)]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 2]; 4] = [[100.0, 50.0], [180.0, 60.0], [170.0, 140.0], [95.0, 120.0]];

    fn assert_near(a: [f64; 2], b: [f64; 2]) {
        assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{a:?} is not {b:?}");
    }

    #[test]
    fn the_corners_of_the_square_go_to_the_corners_of_the_quad() {
        let map = Homography::from_square(&CORNERS, 8.0).unwrap();
        for (point, corner) in [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]].into_iter().zip(CORNERS) {
            assert_near(map.project(point), corner);
        }
    }

    #[test]
    fn many_points_are_seen_where_each_is_alone() {
        let map = Homography::from_square(&CORNERS, 8.0).unwrap();
        let (x, y) = ([0.5, 1.5, 7.5, 4.0, 3.0, 0.0, 8.0, 6.5], [0.5, 7.5, 1.5, 4.0, 0.0, 8.0, 8.0, 2.5]);
        let [seen_x, seen_y] = map.project_all(&x, &y);
        for i in 0..LANES {
            let alone = map.project([f64::from(x[i]), f64::from(y[i])]);
            assert!((f64::from(seen_x[i]) - alone[0]).hypot(f64::from(seen_y[i]) - alone[1]) < 1e-4);
        }
    }

    #[test]
    fn the_tag_square_has_its_first_corner_at_bottom_left() {
        let map = Homography::of_tag(&CORNERS);
        for (point, corner) in [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].into_iter().zip(CORNERS) {
            assert_near(map.project(point), corner);
        }
        assert_eq!(map.to_array()[8], 1.0);
    }

    #[test]
    fn corners_on_a_line_have_no_map() {
        assert!(Homography::from_square(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], 1.0).is_none());
    }
}
