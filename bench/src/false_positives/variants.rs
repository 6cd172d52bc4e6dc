//! One picture in many sizes and rotations.

use image::GrayImage;
use image::imageops::{FilterType, resize};
use tagbus_paper::Picture;

/// Sizes as multiples of the original.
pub(super) const SCALES: [f64; 5] = [0.5, 0.71, 1.0, 1.41, 2.0];
/// Rotations in degrees. A quarter turn would show the same quads again.
pub(super) const TURNS_DEG: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

/// The picture scaled and then rotated about its middle. Only the largest upright rectangle of its proportions that lies
/// wholly inside the rotated picture is kept, so that no edge is seen that the picture does not have.
pub(super) fn variant(original: &GrayImage, scale: f64, turn_deg: f64) -> Option<Picture> {
    let scaled = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    let scaled =
        resize(original, scaled(original.width()), scaled(original.height()), FilterType::CatmullRom);
    let turned = if turn_deg == 0.0 { scaled } else { rotated(&scaled, turn_deg.to_radians())? };
    Picture::new(turned.width() as usize, turned.height() as usize, turned.into_raw()).ok()
}

fn rotated(picture: &GrayImage, turn_rad: f64) -> Option<GrayImage> {
    // Pixel centres span one pixel less than the picture.
    let spans = [picture.width(), picture.height()].map(|side| f64::from(side) - 1.0);
    let [width, height] = inner(spans, turn_rad).map(|side| side as usize);
    let (sine, cosine) = turn_rad.sin_cos();
    let mut luma = Vec::with_capacity(width * height);
    for y in 0..height {
        let down = y as f64 - (height as f64 - 1.0) / 2.0;
        luma.extend((0..width).map(|x| {
            let right = x as f64 - (width as f64 - 1.0) / 2.0;
            let at = [right * cosine - down * sine, right * sine + down * cosine];
            bilinear(picture, [at[0] + spans[0] / 2.0, at[1] + spans[1] / 2.0])
        }));
    }
    GrayImage::from_raw(width as u32, height as u32, luma)
}

/// Sides of the largest rectangle with these proportions that fits when it is rotated.
fn inner([width, height]: [f64; 2], turn_rad: f64) -> [f64; 2] {
    let (sine, cosine) = (turn_rad.sin().abs(), turn_rad.cos().abs());
    let share = (width / (width * cosine + height * sine)).min(height / (width * sine + height * cosine));
    [width * share, height * share]
}

fn bilinear(picture: &GrayImage, [x, y]: [f64; 2]) -> u8 {
    let last = [picture.width() - 1, picture.height() - 1];
    let [left, top] = [(x as u32).min(last[0]), (y as u32).min(last[1])];
    let [right, bottom] = [(left + 1).min(last[0]), (top + 1).min(last[1])];
    let grey = |x: u32, y: u32| f64::from(picture.get_pixel(x, y).0[0]);
    let (u, v) = (x - f64::from(left), y - f64::from(top));
    let row = |y: u32| grey(left, y) * (1.0 - u) + grey(right, y) * u;
    (row(top) * (1.0 - v) + row(bottom) * v).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_of_a_rotated_picture_lies_wholly_inside_of_it() {
        for [width, height] in [[481.0, 321.0], [320.0, 320.0], [100.0, 900.0]] {
            for turn_deg in TURNS_DEG {
                let turn_rad = f64::to_radians(turn_deg);
                let [w, h] = inner([width, height], turn_rad);
                let (sine, cosine) = turn_rad.sin_cos();
                let reach = [w * cosine + h * sine, w * sine + h * cosine];
                assert!(reach[0] <= width + 1e-9 && reach[1] <= height + 1e-9, "{turn_deg}");
                assert!(reach[0] > width - 1e-9 || reach[1] > height - 1e-9, "more fits at {turn_deg}");
            }
        }
    }

    #[test]
    fn a_rotated_slope_keeps_its_steepness() {
        let slope = GrayImage::from_fn(200, 100, |x, _| image::Luma([x as u8]));
        let turned = rotated(&slope, f64::to_radians(60.0)).unwrap();
        let middle = [turned.width() / 2, turned.height() / 2];
        let grey = |x: u32, y: u32| f64::from(turned.get_pixel(x, y).0[0]);
        let across = (grey(middle[0] + 10, middle[1]) - grey(middle[0] - 10, middle[1])) / 20.0;
        let down = (grey(middle[0], middle[1] + 10) - grey(middle[0], middle[1] - 10)) / 20.0;
        assert!((across - 0.5).abs() < 0.06 && (down + 0.866).abs() < 0.06, "{across} {down}");
    }

    #[test]
    fn sizes_change_with_the_scale() {
        let plain = GrayImage::from_pixel(64, 48, image::Luma([7]));
        let half = variant(&plain, 0.5, 0.0).unwrap();
        assert_eq!((half.width(), half.height()), (32, 24));
    }
}
