//! Random tags in random places, drawn by the scene room.

use tagbus_detector::{Decimation, Detection, Settings};
use tagbus_family::Family;
use tagbus_scene::{Homography, Photo, Placement, Stream, Tag, Turn, View, homography_of, photograph};

/// One random picture of a tag.
pub(crate) struct Case {
    pub(crate) id: u32,
    pub(crate) homography: Homography,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) luma: Vec<u8>,
}

/// What a random picture may look like.
pub(crate) struct Range {
    pub(crate) cell_px: [f64; 2],
    pub(crate) tilt_degrees: [f64; 2],
    pub(crate) blur_sigma: [f64; 2],
    pub(crate) noise_sigma: [f64; 2],
    pub(crate) contrast: [f64; 2],
}

/// The range of the conditions that every family must be read under: at least 4 pixels a cell in the direction in which
/// tilt makes cells narrowest.
pub(crate) const READABLE: Range = Range {
    cell_px: [4.0, 12.0],
    tilt_degrees: [0.0, 60.0],
    blur_sigma: [0.0, 0.8],
    noise_sigma: [0.0, 5.0],
    contrast: [60.0, 200.0],
};

/// Draws a tag of `family`, turned by `quarter` quarter turns and up to 45 degrees either way.
pub(crate) fn random_case(family: &Family, range: &Range, quarter: u32, random: &mut Stream) -> Case {
    let between = |random: &mut Stream, [low, high]: [f64; 2]| random.between(low, high);
    let tilt_rad = between(random, range.tilt_degrees).to_radians();
    // The scene's cell size is that of the area; across the tilt a cell is narrower by the root of the cosine.
    let cell_px = between(random, range.cell_px) / tilt_rad.cos().sqrt();
    let side = (family.layout().total_width() as f64 * cell_px * 2.2) as usize + 40;
    let middle = side as f64 * 0.5;
    let turn = Turn {
        rotation_rad: (f64::from(quarter) * 90.0 + random.between(-45.0, 45.0)).to_radians(),
        tilt_rad,
        tilt_direction_rad: random.between(0.0, std::f64::consts::TAU),
    };
    let centre = [middle + random.between(-3.0, 3.0), middle + random.between(-3.0, 3.0)];
    let view = View { centre, cell_px, turn, focal_px: 2.0 * side as f64 };
    let homography = homography_of(family.layout(), &view);
    let id = random.below(family.codes().len() as u64) as u32;
    let contrast = between(random, range.contrast);
    let black = random.between(10.0, 245.0 - contrast);
    let mut placement =
        Placement::new(Tag::new(family, id).expect("the id is below the number of codes"), homography);
    placement.black = black as f32;
    placement.white = (black + contrast) as f32;
    let photo = Photo {
        width: side,
        height: side,
        blur_sigma: between(random, range.blur_sigma) as f32,
        noise_sigma: between(random, range.noise_sigma) as f32,
        seed: random.bits(),
        ..Photo::default()
    };
    Case { id, homography, width: side, height: side, luma: photograph(&photo, &[placement]) }
}

/// Settings with a decimation factor.
pub(crate) fn decimated(factor: f64) -> Settings {
    Settings {
        decimation: Decimation::from_factor(factor).expect("a possible factor"),
        ..Settings::default()
    }
}

/// The largest distance of a corner from where the homography of the truth puts it, pixels.
pub(crate) fn worst_corner(detection: &Detection, truth: &Homography) -> f64 {
    let expected = tagbus_scene::corners_of(truth);
    let distance = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]);
    detection.corners.iter().zip(&expected).map(distance).fold(0.0, f64::max)
}
