//! Grey levels between pixels (paper III-D).

use crate::picture::Picture;

/// How a grey level is read at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// That of the pixel in which the point lies: as before.
    Nearest,
    /// From the four pixels whose centres are nearest, weighed by their distance: the paper's choice.
    Bilinear,
}

/// The grey level at a point of the frame; `None` outside of it. Nearer to the rim than half a pixel the outermost
/// centres' values go on.
pub(crate) fn sample(picture: &Picture, [x, y]: [f64; 2], sampling: Sampling) -> Option<f64> {
    let inside = |v: f64, side: usize| (0.0..=side as f64).contains(&v);
    if !inside(x, picture.width()) || !inside(y, picture.height()) {
        return None;
    }
    Some(match sampling {
        Sampling::Nearest => {
            let pixel = |v: f64, side: usize| (v as usize).min(side - 1);
            f64::from(picture.at(pixel(x, picture.width()), pixel(y, picture.height())))
        }
        Sampling::Bilinear => bilinear(picture, [x, y]),
    })
}

fn bilinear(picture: &Picture, [x, y]: [f64; 2]) -> f64 {
    let (left, right, share_right) = neighbours(x, picture.width());
    let (above, below, share_below) = neighbours(y, picture.height());
    let along = |row: usize| {
        let [left, right] = [left, right].map(|column| f64::from(picture.at(column, row)));
        left + share_right * (right - left)
    };
    along(above) + share_below * (along(below) - along(above))
}

/// The pixels before and after a point on one axis, and the weight of the latter.
fn neighbours(v: f64, side: usize) -> (usize, usize, f64) {
    let from_first_centre = (v - 0.5).clamp(0.0, (side - 1) as f64);
    let before = from_first_centre.floor();
    let place = before as usize;
    (place, (place + 1).min(side - 1), from_first_centre - before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::Stream;

    #[test]
    fn bilinear_samples_of_a_plane_are_the_plane() {
        let plane = Picture::computed(20, 15, |x, y| (5 * x + 7 * y) as u8);
        let mut random = Stream::new(1);
        for _ in 0..1000 {
            let (x, y) = (random.between(0.5, 19.5), random.between(0.5, 14.5));
            let expected = 5.0 * (x - 0.5) + 7.0 * (y - 0.5);
            assert!((sample(&plane, [x, y], Sampling::Bilinear).unwrap() - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn both_ways_agree_in_the_centres_of_pixels() {
        let picture = Picture::computed(9, 8, |x, y| (x * 77 + y * 151) as u8);
        for (x, y) in (0..8).flat_map(|y| (0..9).map(move |x| (x, y))) {
            let centre = [x as f64 + 0.5, y as f64 + 0.5];
            let [nearest, bilinear] =
                [Sampling::Nearest, Sampling::Bilinear].map(|sampling| sample(&picture, centre, sampling));
            assert_eq!(nearest, bilinear);
            assert_eq!(nearest, Some(f64::from(picture.at(x, y))));
        }
    }

    #[test]
    fn nothing_is_read_outside_of_the_picture() {
        let picture = Picture::new(2, 1, vec![10, 20]).unwrap();
        for sampling in [Sampling::Nearest, Sampling::Bilinear] {
            assert_eq!(sample(&picture, [0.0, 0.0], sampling), Some(10.0));
            assert_eq!(sample(&picture, [2.0, 1.0], sampling), Some(20.0));
            for outside in [[-0.01, 0.5], [2.01, 0.5], [1.0, -0.01], [1.0, 1.01], [f64::NAN, 0.5]] {
                assert_eq!(sample(&picture, outside, sampling), None);
            }
        }
    }
}
