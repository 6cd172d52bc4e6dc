//! A picture with its tags drawn in.

use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};
use tagbus_camera::picture::Picture;
use tagbus_detector::Detection;

use crate::outcome::Failure;

/// Sides in the order of the corners: bottom, right, top, left. The bottom side shows which way the tag is turned.
const SIDE_COLOURS: [Rgb<u8>; 4] =
    [Rgb([255, 40, 40]), Rgb([40, 220, 40]), Rgb([40, 220, 40]), Rgb([60, 120, 255])];

/// Writes the picture as `NAME.tags.png` into the folder; NAME has its folders in it, so that no two are the same.
pub(super) fn write(
    folder: &Path,
    path: &Path,
    picture: &Picture,
    detections: &[Detection],
) -> Result<(), Failure> {
    let mut drawn = in_colours(picture);
    for detection in detections {
        draw_tag(&mut drawn, detection);
    }
    let file = folder.join(name_of(path));
    let failure = |error| Failure::new(format!("{}: cannot be written: {error}", file.display()));
    drawn.save(&file).map_err(failure)
}

fn name_of(path: &Path) -> PathBuf {
    let whole = path.display().to_string();
    format!("{}.tags.png", whole.trim_start_matches(['/', '.']).replace('/', "_")).into()
}

fn in_colours(picture: &Picture) -> RgbImage {
    RgbImage::from_fn(picture.width as u32, picture.height as u32, |x, y| {
        Rgb([picture.luma[y as usize * picture.width + x as usize]; 3])
    })
}

fn draw_tag(drawn: &mut RgbImage, detection: &Detection) {
    for (side, colour) in SIDE_COLOURS.into_iter().enumerate() {
        draw_line(drawn, detection.corners[side], detection.corners[(side + 1) % 4], colour);
    }
}

/// A line of points half a pixel apart; what lies outside the picture is left out.
fn draw_line(drawn: &mut RgbImage, from: [f64; 2], to: [f64; 2], colour: Rgb<u8>) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    // A side that is wildly outside has no more points than one across the largest picture.
    let steps = (2.0 * dx.abs().max(dy.abs())).clamp(1.0, 1e5);
    for step in 0..=steps as u32 {
        let along = f64::from(step) / steps;
        let (x, y) = (from[0] + along * dx, from[1] + along * dy);
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(drawn.width()) && y < f64::from(drawn.height());
        if inside {
            drawn.put_pixel(x as u32, y as u32, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_one_name_in_two_folders_stay_two() {
        assert_eq!(name_of(Path::new("./a/1.jpg")), Path::new("a_1.jpg.tags.png"));
        assert_ne!(name_of(Path::new("/a/1.jpg")), name_of(Path::new("/b/1.jpg")));
    }

    #[test]
    fn lines_reach_both_ends_and_stop_at_the_rim() {
        let mut drawn = RgbImage::new(10, 10);
        draw_line(&mut drawn, [2.5, 3.5], [7.5, 3.5], SIDE_COLOURS[0]);
        draw_line(&mut drawn, [5.0, 5.0], [1e9, -1e9], SIDE_COLOURS[1]);
        assert_eq!(*drawn.get_pixel(2, 3), SIDE_COLOURS[0]);
        assert_eq!(*drawn.get_pixel(7, 3), SIDE_COLOURS[0]);
        assert_eq!(*drawn.get_pixel(8, 3), Rgb([0; 3]));
    }
}
