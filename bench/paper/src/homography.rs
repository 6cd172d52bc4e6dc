//! Perspective correction (paper III-C 4, equations 3 and 4): from the tag's plane to the frame.

use nalgebra::{SMatrix, SVector};

/// A projective map whose last element H33 is 1. That leaves out maps that take the tag's middle to infinity
/// (equation 4), and no such tag is ever seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography {
    /// H11, H12, H13, H21, H22, H23, H31, H32.
    h: SVector<f64, 8>,
}

/// The border edge's corners in the tag's plane, x right and y down: bottom-left first, counter-clockwise as seen.
pub(crate) const TAG_CORNERS: [[f64; 2]; 4] = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];

impl Homography {
    /// The map that takes the four corners of the border edge to `corners`; `None` when three of these lie on a line.
    ///
    /// Equation 3 without w: x1 (H31 x0 + H32 y0 + 1) = H11 x0 + H12 y0 + H13, and the same for y1, is two linear equations
    /// for each corner. Eight equations, eight unknowns, solved by Gaussian elimination.
    pub(crate) fn of_corners(corners: &[[f64; 2]; 4]) -> Option<Homography> {
        let mut system = SMatrix::<f64, 8, 8>::zeros();
        let mut right_side = SVector::<f64, 8>::zeros();
        for (k, ([x0, y0], [x1, y1])) in TAG_CORNERS.into_iter().zip(*corners).enumerate() {
            let for_x = [x0, y0, 1.0, 0.0, 0.0, 0.0, -x1 * x0, -x1 * y0];
            let for_y = [0.0, 0.0, 0.0, x0, y0, 1.0, -y1 * x0, -y1 * y0];
            system.set_row(2 * k, &SVector::from(for_x).transpose());
            system.set_row(2 * k + 1, &SVector::from(for_y).transpose());
            right_side[2 * k] = x1;
            right_side[2 * k + 1] = y1;
        }
        let h = system.lu().solve(&right_side)?;
        h.iter().all(|entry| entry.is_finite()).then_some(Homography { h })
    }

    /// Where a point of the tag's plane is seen.
    pub(crate) fn project(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let h = &self.h;
        let w = h[6] * x + h[7] * y + 1.0;
        [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Layout;
    use tagbus_scene::{Stream, Turn, View, corners_of, homography_of, project};

    #[test]
    fn the_map_of_a_tags_corners_is_the_one_that_put_them_there() {
        let layout = Layout::classic(10).unwrap();
        let mut random = Stream::new(2);
        for _ in 0..300 {
            let turn = Turn {
                rotation_rad: random.between(0.0, 7.0),
                tilt_rad: random.between(0.0, 1.2),
                tilt_direction_rad: random.between(0.0, 7.0),
            };
            let truth = homography_of(&layout, &View { turn, ..View::default() });
            let found = Homography::of_corners(&corners_of(&truth)).unwrap();
            for _ in 0..10 {
                let point = [random.between(-1.3, 1.3), random.between(-1.3, 1.3)];
                let ([x, y], [true_x, true_y]) = (found.project(point), project(&truth, point));
                assert!((x - true_x).hypot(y - true_y) < 1e-8, "{point:?}");
            }
        }
    }

    #[test]
    fn corners_on_a_line_have_no_map() {
        assert!(Homography::of_corners(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).is_none());
    }
}
