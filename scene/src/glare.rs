//! Uneven light that a lamp and a lens leave in a picture: a shining spot, and corners that are darker.

use crate::canvas::Canvas;
use crate::elementary::exponential_of_negative;
use crate::homography::Point;

/// A lamp that is mirrored in glossy paper: a round spot of light that fades out like a bell curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Middle of the spot in pixels.
    pub centre: Point,
    /// Standard deviation of the bell curve in pixels.
    pub radius_px: f64,
    /// Grey levels that the middle of the spot adds; what passes 255 is clipped when the picture is developed.
    pub strength: f32,
}

impl Glare {
    /// Adds the light of the spot.
    pub(crate) fn apply(&self, canvas: &mut Canvas) {
        if self.radius_px.is_nan() || self.radius_px <= 0.0 {
            return;
        }
        let bell = |distance: f64| {
            let deviations = distance / self.radius_px;
            exponential_of_negative(-0.5 * deviations * deviations) as f32
        };
        let window = canvas.window;
        let across: Vec<f32> = window.columns().map(|x| bell(x as f64 + 0.5 - self.centre[0])).collect();
        for y in window.rows() {
            let along = self.strength * bell(y as f64 + 0.5 - self.centre[1]);
            for (pixel, share) in canvas.row_mut(y, window.columns()).iter_mut().zip(&across) {
                *pixel += along * share;
            }
        }
    }
}

/// Darkens the whole picture towards its corners: light falls off with the square of the distance from the middle and
/// lacks the share `loss` (0 to 1) in the corners.
pub(crate) fn darken_corners(canvas: &mut Canvas, loss: f32) {
    if loss == 0.0 {
        return;
    }
    let (width, height) = (canvas.window.width as f32, canvas.window.height as f32);
    let corner_squared = width * width + height * height;
    for (y, row) in canvas.pixels.chunks_exact_mut(canvas.window.width.max(1)).enumerate() {
        let down = 2.0 * (y as f32 + 0.5) - height;
        for (x, pixel) in row.iter_mut().enumerate() {
            let right = 2.0 * (x as f32 + 0.5) - width;
            *pixel *= 1.0 - loss * (right * right + down * down) / corner_squared;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;

    #[test]
    fn a_spot_is_brightest_in_its_middle_and_round() {
        let mut canvas = Canvas::plain(Window::whole(40, 40), 100.0);
        Glare { centre: [20.5, 10.5], radius_px: 4.0, strength: 80.0 }.apply(&mut canvas);
        let at = |x: usize, y: usize| canvas.row(y, x..x + 1)[0];
        assert!((at(20, 10) - 180.0).abs() < 1e-3);
        assert!((at(24, 10) - at(20, 14)).abs() < 1e-3);
        // One standard deviation away the bell curve is at exp(-1/2).
        assert!((at(24, 10) - (100.0 + 80.0 * 0.60653)).abs() < 0.01);
        assert_eq!(at(39, 39), 100.0);
    }

    #[test]
    fn corners_lose_what_was_asked_and_the_middle_nothing() {
        let mut canvas = Canvas::plain(Window::whole(200, 100), 100.0);
        darken_corners(&mut canvas, 0.3);
        let at = |x: usize, y: usize| canvas.row(y, x..x + 1)[0];
        assert!((at(100, 50) - 100.0).abs() < 0.1);
        for (x, y) in [(0, 0), (199, 0), (0, 99), (199, 99)] {
            assert!((at(x, y) - 70.0).abs() < 0.5, "{}", at(x, y));
        }
    }
}
