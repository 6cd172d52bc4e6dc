//! Where a tag in space appears in the picture: a pinhole camera without distortion.
//!
//! ```text
//!            z (forward)                 tag frame: x right, y down, z into the tag
//!           /
//!   camera *────▶ x (right)              a tag that is parallel to the picture and upright
//!          │                             has the rotation 1
//!          ▼ y (down)
//! ```

use crate::elementary::sine_cosine;
use crate::homography::{Homography, Point};
use tagbus_family::Layout;

/// A rotation as a row-major 3x3 matrix; its columns are the tag's x, y and z axes in the camera frame.
pub type Rotation = [[f64; 3]; 3];

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Where the optical axis meets the picture, in pixels.
    pub principal: Point,
}

/// Where a tag is, in the camera frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// From the tag frame to the camera frame.
    pub rotation: Rotation,
    /// The tag's centre, in the unit in which the tag's half side (half the border edge) is given.
    pub translation: [f64; 3],
}

impl Camera {
    /// A camera that looks at the middle of a picture, with a horizontal field of view below half a turn.
    pub fn with_field_of_view(width: usize, height: usize, horizontal_rad: f64) -> Camera {
        let (sine, cosine) = sine_cosine(horizontal_rad / 2.0);
        let principal = [width as f64 / 2.0, height as f64 / 2.0];
        Camera { focal_px: principal[0] * cosine / sine, principal }
    }

    /// The direction in which a pixel looks, as `[x, y, 1]` in the camera frame.
    pub fn direction_of(&self, [x, y]: Point) -> [f64; 3] {
        [(x - self.principal[0]) / self.focal_px, (y - self.principal[1]) / self.focal_px, 1.0]
    }

    /// The homography from the border square [-1, 1]^2 of a tag to the picture. `half_side` is half the length of
    /// the border edge, in the unit of the pose; the tag's centre has to lie in front of the camera (z > 0).
    pub fn homography_of(&self, pose: &Pose, half_side: f64) -> Homography {
        let columns = [0, 1].map(|axis| [0, 1, 2].map(|row| pose.rotation[row][axis] * half_side));
        let [x, y, t] = [columns[0], columns[1], pose.translation].map(|column| self.onto_picture(column));
        [x[0], y[0], t[0], x[1], y[1], t[1], x[2], y[2], t[2]].map(|entry| entry / t[2])
    }

    /// The camera's matrix times a vector.
    fn onto_picture(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [self.focal_px * x + self.principal[0] * z, self.focal_px * y + self.principal[1] * z, z]
    }
}

/// How a tag is turned towards whoever looks at it along its axis: spun in its own plane, then tilted.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Turn {
    /// Rotation in the tag's own plane, in radians; positive turns are clockwise as seen in the picture.
    pub rotation_rad: f64,
    /// Angle between the tag's axis and the line of sight, in radians: 0 is seen straight on.
    pub tilt_rad: f64,
    /// The direction in the picture in which the tilted tag recedes, in radians from right (0) towards down.
    pub tilt_direction_rad: f64,
}

impl Turn {
    /// The rotation of a tag on the optical axis.
    pub fn rotation(&self) -> Rotation {
        let away = about_axis(self.tilt_direction_rad);
        let back = about_axis(self.rotation_rad - self.tilt_direction_rad);
        product(&product(&away, &receding_to_the_right(self.tilt_rad)), &back)
    }

    /// The rotation of a tag that is seen in the given direction (z > 0), the tilt being counted from the line of
    /// sight to it.
    pub fn rotation_towards(&self, direction: [f64; 3]) -> Rotation {
        product(&from_axis_to(direction), &self.rotation())
    }
}

/// A tag as it appears in a picture, given by what matters for finding it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the tag's centre appears, in pixels.
    pub centre: Point,
    /// Average width of a cell at the tag's centre, in pixels: the square root of the area that a cell covers there.
    /// A tilt by `t` makes cells narrower by sqrt(cos t) in its direction and wider by as much across it.
    pub cell_px: f64,
    /// How the tag is turned.
    pub turn: Turn,
    /// Focal length in pixels; the shorter, the stronger the perspective. The optical axis goes through the tag's
    /// centre, so that this view is the same all over the picture.
    pub focal_px: f64,
}

impl Default for View {
    /// Cells of 8 px in the middle of a 640x480 picture, seen straight on, by a camera with 56 degrees of view.
    fn default() -> View {
        View { centre: [320.0, 240.0], cell_px: 8.0, turn: Turn::default(), focal_px: 600.0 }
    }
}

/// The homography of a tag with this layout, seen as `view` says. Tags that come so near that a part of their print
/// lies behind the camera (a print much wider than the focal length, tilted) have no picture.
///
/// ```
/// use tagbus_family::Family;
/// use tagbus_scene::{Turn, View, corners_of, homography_of};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let family = Family::published("tag36h11")?;
/// let view = View { turn: Turn { tilt_rad: 1.0, ..Turn::default() }, ..View::default() };
/// let corners = corners_of(&homography_of(family.layout(), &view));
/// let (left, right) = (corners[0][1] - corners[3][1], corners[1][1] - corners[2][1]);
/// assert!(right < left, "the right edge recedes");
/// # Ok(())
/// # }
/// ```
pub fn homography_of(layout: &Layout, view: &View) -> Homography {
    let (_, foreshortening) = sine_cosine(view.turn.tilt_rad);
    let straight_on_px = view.cell_px / foreshortening.max(f64::MIN_POSITIVE).sqrt();
    let half_side_px = straight_on_px * layout.width_at_border() as f64 / 2.0;
    let camera = Camera { focal_px: view.focal_px, principal: view.centre };
    let pose = Pose { rotation: view.turn.rotation(), translation: [0.0, 0.0, view.focal_px / half_side_px] };
    camera.homography_of(&pose, 1.0)
}

/// Turns x towards y: clockwise as seen in the picture.
fn about_axis(angle_rad: f64) -> Rotation {
    let (sine, cosine) = sine_cosine(angle_rad);
    [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
}

/// Turns x towards z: the right-hand side goes away from the camera.
fn receding_to_the_right(angle_rad: f64) -> Rotation {
    let (sine, cosine) = sine_cosine(angle_rad);
    [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]]
}

/// The shortest rotation that takes the optical axis to a direction with z > 0 (Rodrigues' formula with the sine and
/// cosine taken from the vectors).
fn from_axis_to([x, y, z]: [f64; 3]) -> Rotation {
    let length = (x * x + y * y + z * z).sqrt();
    let (x, y, z) = (x / length, y / length, z / length);
    let bend = 1.0 / (1.0 + z);
    [[1.0 - x * x * bend, -x * y * bend, x], [-x * y * bend, 1.0 - y * y * bend, y], [-x, -y, z]]
}

fn product(left: &Rotation, right: &Rotation) -> Rotation {
    let entry = |row: usize, column: usize| (0..3).map(|k| left[row][k] * right[k][column]).sum();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| entry(row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::homography::{corners_of, project, smallest_scale_at};
    use crate::random::Stream;
    use tagbus_family::Family;

    const ROUNDING: f64 = 1e-9;

    fn random_turn(stream: &mut Stream) -> Turn {
        Turn {
            rotation_rad: stream.between(-7.0, 7.0),
            tilt_rad: stream.between(0.0, 1.2),
            tilt_direction_rad: stream.between(-4.0, 4.0),
        }
    }

    fn determinant([a, b, c]: &Rotation) -> f64 {
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        a.iter().zip(cross).map(|(left, right)| left * right).sum()
    }

    #[test]
    fn every_turn_is_a_rotation_whose_axis_has_the_tilt_asked_for() {
        let mut stream = Stream::new(21);
        for _ in 0..200 {
            let turn = random_turn(&mut stream);
            let direction = [stream.between(-1.0, 1.0), stream.between(-1.0, 1.0), 1.0];
            let rotation = turn.rotation_towards(direction);
            let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
            let along = (0..3).map(|row| rotation[row][2] * direction[row]).sum::<f64>() / length;
            assert!((along - turn.tilt_rad.cos()).abs() < ROUNDING, "{turn:?}");
            assert!((determinant(&rotation) - 1.0).abs() < ROUNDING, "{turn:?}");
        }
    }

    #[test]
    fn the_homography_agrees_with_projecting_the_corners_in_space() {
        let camera = Camera::with_field_of_view(640, 480, 1.05);
        let mut stream = Stream::new(22);
        for _ in 0..200 {
            let translation =
                [stream.between(-1.0, 1.0), stream.between(-1.0, 1.0), stream.between(4.0, 9.0)];
            let pose = Pose { rotation: random_turn(&mut stream).rotation(), translation };
            let [x, y] = project(&camera.homography_of(&pose, 0.3), [1.0, -1.0]);
            let in_space: Vec<f64> = (0..3)
                .map(|row| translation[row] + 0.3 * (pose.rotation[row][0] - pose.rotation[row][1]))
                .collect();
            assert!((x - (320.0 + camera.focal_px * in_space[0] / in_space[2])).abs() < ROUNDING);
            assert!((y - (240.0 + camera.focal_px * in_space[1] / in_space[2])).abs() < ROUNDING);
        }
    }

    #[test]
    fn cells_cover_the_area_asked_for_at_the_centre_of_the_tag() {
        let family = Family::published("tagStandard41h12").unwrap();
        let mut stream = Stream::new(23);
        for _ in 0..200 {
            let turn = random_turn(&mut stream);
            let view = View { cell_px: 6.0, turn, centre: [50.0, 70.0], focal_px: 600.0 };
            let homography = homography_of(family.layout(), &view);
            let [x, y] = project(&homography, [0.0, 0.0]);
            assert!((x - 50.0).abs() < ROUNDING && (y - 70.0).abs() < ROUNDING);
            let narrow = smallest_scale_at(&homography, [0.0, 0.0]) * 2.0 / 5.0;
            assert!((narrow - 6.0 * turn.tilt_rad.cos().sqrt()).abs() < ROUNDING, "{turn:?}");
        }
    }

    #[test]
    fn a_quarter_turn_clockwise_moves_the_first_corner_to_the_top_left() {
        let family = Family::published("tag36h11").unwrap();
        let quarter = Turn { rotation_rad: std::f64::consts::FRAC_PI_2, ..Turn::default() };
        let upright = corners_of(&homography_of(family.layout(), &View::default()));
        let turned = corners_of(&homography_of(family.layout(), &View { turn: quarter, ..View::default() }));
        assert!(upright[0][0] < upright[1][0] && upright[0][1] > upright[3][1]);
        for (now, before) in turned.iter().zip([upright[3], upright[0], upright[1], upright[2]]) {
            assert!((now[0] - before[0]).abs() < ROUNDING && (now[1] - before[1]).abs() < ROUNDING);
        }
    }

    #[test]
    fn a_tag_recedes_in_the_direction_of_its_tilt() {
        let family = Family::published("tag36h11").unwrap();
        let down = Turn { tilt_rad: 0.8, tilt_direction_rad: std::f64::consts::FRAC_PI_2, ..Turn::default() };
        let corners = corners_of(&homography_of(family.layout(), &View { turn: down, ..View::default() }));
        assert!(
            corners[1][0] - corners[0][0] < corners[2][0] - corners[3][0],
            "the bottom edge is farther away"
        );
    }
}
