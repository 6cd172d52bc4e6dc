//! A single picture of placed tags, for tests and benchmarks.

use crate::blur::{Blur, BlurScratch};
use crate::canvas::{Canvas, Window};
use crate::coverage::Coverage;
use crate::exposure::{Exposure, Light};
use crate::glare::{Glare, darken_corners};
use crate::motion::Motion;
use crate::placement::Placement;
use crate::random::{Normals, key_for};
use crate::texture::Background;
use crate::tone::Tone;

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photo {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// What is behind the tags.
    pub background: Background,
    /// Standard deviation of the Gaussian blur in pixels; 0 for none.
    pub blur_sigma: f32,
    /// What moves while the shutter is open.
    pub motion: Motion,
    /// A lamp mirrored in the scene.
    pub glare: Option<Glare>,
    /// The share of light that the corners of the picture lack, 0 to 1.
    pub vignetting: f32,
    /// The camera's curve between light and grey level.
    pub tone: Tone,
    /// The light that falls on everything.
    pub light: Light,
    /// Standard deviation of the noise in grey levels; 0 for none.
    pub noise_sigma: f32,
    /// Chooses the texture and the noise.
    pub seed: u64,
}

impl Default for Photo {
    /// A sharp 640x480 picture without noise, on a plain grey ground.
    fn default() -> Photo {
        Photo {
            width: 640,
            height: 480,
            background: Background::Plain(128.0),
            blur_sigma: 0.0,
            motion: Motion::default(),
            glare: None,
            vignetting: 0.0,
            tone: Tone::default(),
            light: Light::default(),
            noise_sigma: 0.0,
            seed: 1,
        }
    }
}

/// Takes a picture of the tags: `width * height` grey levels, row after row.
///
/// The tags are painted in the order of the list, each pixel by the exact area that the cells cover in it. Then come,
/// as in a camera, glare, motion, blur, vignetting, the tone curve, light, noise and rounding. The result is a pure function of the arguments, the same on every
/// machine.
pub fn photograph(photo: &Photo, tags: &[Placement]) -> Vec<u8> {
    let frame = Window::whole(photo.width, photo.height);
    let mut bytes = vec![0; photo.width * photo.height];
    if frame.is_empty() {
        return bytes;
    }
    let canvas = painted(photo, tags, frame);
    let normals = Normals::new();
    let exposure = Exposure {
        light: photo.light,
        noise_sigma: photo.noise_sigma,
        noise_key: key_for(photo.seed, u64::MAX),
        normals: &normals,
        frame,
    };
    for (y, row) in bytes.chunks_exact_mut(photo.width).enumerate() {
        exposure.develop(y, 0, canvas.row(y, frame.columns()).iter().copied(), row);
    }
    bytes
}

/// Background and tags as the lens and the sensor's curve leave them.
fn painted(photo: &Photo, tags: &[Placement], frame: Window) -> Canvas {
    let mut canvas = Canvas::plain(frame, 0.0);
    photo.background.fill(&mut canvas, photo.seed);
    let mut coverage = Coverage::default();
    for placement in tags {
        placement.print().paint(&mut canvas, &mut coverage);
    }
    if let Some(glare) = photo.glare {
        glare.apply(&mut canvas);
    }
    photo.motion.apply(&mut canvas);
    Blur::new(photo.blur_sigma).apply(&mut canvas, &mut BlurScratch::default());
    darken_corners(&mut canvas, photo.vignetting);
    photo.tone.apply(&mut canvas);
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Turn, View, homography_of};
    use crate::homography::{Homography, project};
    use crate::random::Stream;
    use crate::tag::Tag;
    use tagbus_family::{Family, Layout};

    fn tag(name: &str, id: u32) -> (Tag, Layout) {
        let family = Family::published(name).unwrap();
        (Tag::new(&family, id).unwrap(), family.layout().clone())
    }

    /// Where an edge crosses the middle of a row: the area that is dark, counted in pixels from `start` on.
    fn dark_width(row: &[u8], black: f32, white: f32) -> f64 {
        row.iter().map(|&byte| f64::from((white - f32::from(byte)) / (white - black))).sum()
    }

    fn close_up(turn: Turn, centre: [f64; 2]) -> View {
        View { centre, cell_px: 28.0, turn, focal_px: 900.0 }
    }

    /// The picture's x at which the left border edge of the tag crosses the row with this y.
    fn left_edge_at(homography: &Homography, y: f64) -> f64 {
        let [bottom, top] = [project(homography, [-1.0, 1.0]), project(homography, [-1.0, -1.0])];
        bottom[0] + (y - bottom[1]) / (top[1] - bottom[1]) * (top[0] - bottom[0])
    }

    #[test]
    fn edges_lie_where_truth_says_within_a_fiftieth_of_a_pixel() {
        let (tag, layout) = tag("tag36h11", 7);
        let mut stream = Stream::new(51);
        for case in 0..100 {
            let turn = Turn {
                rotation_rad: stream.between(-0.3, 0.3),
                tilt_rad: stream.between(0.0, 0.7),
                tilt_direction_rad: stream.between(-3.0, 3.0),
            };
            let centre = [stream.between(195.0, 205.0), stream.between(195.0, 205.0)];
            let homography = homography_of(&layout, &close_up(turn, centre));
            let placement = Placement { black: 0.0, white: 255.0, ..Placement::new(tag.clone(), homography) };
            let blur_sigma = stream.between(0.0, 0.8) as f32;
            let photo = Photo { width: 400, height: 400, blur_sigma, ..Photo::default() };
            let bytes = photograph(&photo, &[placement]);
            // A row through the middle: white ring, then the black border ring, of which the first half is used.
            let edge = left_edge_at(&homography, 200.5);
            let (start, end) = (edge as usize - 10, edge as usize + 10);
            let found = end as f64 - dark_width(&bytes[200 * 400 + start..200 * 400 + end], 0.0, 255.0);
            assert!((found - edge).abs() < 0.02, "case {case}: edge at {edge}, found {found}");
        }
    }

    #[test]
    fn the_middle_of_every_cell_has_the_colour_of_the_grid() {
        let mut stream = Stream::new(52);
        for name in Family::PUBLISHED {
            let (tag, layout) = tag(name, 11);
            let turn = Turn {
                rotation_rad: stream.between(-4.0, 4.0),
                tilt_rad: stream.between(0.0, 1.0),
                tilt_direction_rad: stream.between(-4.0, 4.0),
            };
            let view = View { centre: [200.0, 200.0], cell_px: 9.0, turn, ..View::default() };
            let homography = homography_of(&layout, &view);
            let photo = Photo { width: 400, height: 400, ..Photo::default() };
            let bytes = photograph(&photo, &[Placement::new(tag.clone(), homography)]);
            let to_pixels = tag.cells_to_pixels(&homography);
            for (x, y) in (0..layout.total_width() as i64).flat_map(|y| (0..y).map(move |x| (x, y))) {
                let [px, py] = project(&to_pixels, [x as f64 + 0.5, y as f64 + 0.5]);
                let expected = match tag.paint_at(x, y) {
                    tagbus_family::Paint::White => 215,
                    tagbus_family::Paint::Black => 35,
                    tagbus_family::Paint::Clear => 128,
                };
                assert_eq!(bytes[py as usize * 400 + px as usize], expected, "{name}: cell {x}, {y}");
            }
        }
    }

    #[test]
    fn the_nested_tag_is_where_truth_says() {
        let (outer, layout) = tag("tagCustom48h12", 3);
        let (inner, inner_layout) = tag("tag36h11", 8);
        let nested = outer.nest(inner.clone()).unwrap();
        let view = View { centre: [200.2, 199.7], cell_px: 34.0, focal_px: 900.0, ..View::default() };
        let placement = Placement::new(nested, homography_of(&layout, &view));
        let truth = placement.truth(400, 400);
        let bytes = photograph(&Photo { width: 400, height: 400, ..Photo::default() }, &[placement]);
        let cell_px = 34.0 * 2.0 / inner_layout.total_width() as f64;
        assert!((truth[1].cell_px - cell_px).abs() < 1e-9);
        let [left, bottom] = truth[1].corners[0];
        // Through the middle of the inner tag's bottom border row: white ring, then black.
        let y = (bottom - cell_px / 2.0) as usize;
        let start = (left - cell_px / 2.0) as usize;
        let end = (left + cell_px / 2.0) as usize;
        let found = end as f64 - dark_width(&bytes[y * 400 + start..y * 400 + end], 35.0, 215.0);
        assert!((found - left).abs() < 0.02, "edge at {left}, found {found}");
    }

    #[test]
    fn later_tags_hide_earlier_ones() {
        let (tag, layout) = tag("tag16h5", 0);
        let placement = Placement::new(tag, homography_of(&layout, &View::default()));
        let hidden = Placement { black: 90.0, white: 100.0, ..placement.clone() };
        let photo = Photo::default();
        let alone = photograph(&photo, std::slice::from_ref(&placement));
        assert_eq!(photograph(&photo, &[hidden, placement]), alone);
    }

    #[test]
    fn the_same_arguments_give_the_same_bytes_and_other_seeds_others() {
        let (tag, layout) = tag("tagStandard52h13", 100);
        let placement = [Placement::new(tag, homography_of(&layout, &View::default()))];
        let background = Background::Textured { level: 120.0, amplitude: 60.0 };
        let photo = Photo { background, blur_sigma: 0.8, noise_sigma: 5.0, ..Photo::default() };
        let first = photograph(&photo, &placement);
        assert_eq!(first, photograph(&photo, &placement));
        assert_ne!(first, photograph(&Photo { seed: 2, ..photo }, &placement));
    }

    #[test]
    fn a_picture_without_pixels_is_empty() {
        assert!(photograph(&Photo { width: 0, ..Photo::default() }, &[]).is_empty());
        assert!(photograph(&Photo { height: 0, ..Photo::default() }, &[]).is_empty());
    }
}
