//! The data sets by name.

use tagbus_scene::{Background, Tone};

use super::recipe::{Card, Gloss, Ids, Recipe, Span};

/// The names that [`named`] knows.
pub(crate) const NAMES: [&str; 24] = [
    "paper", "wall", "textured", "empty", "base", "low1", "low2", "dark", "motion2", "motion4", "motion6",
    "noise5", "noise8", "tilt", "margin05", "margin0", "defocus", "jpeg50", "jpeg25", "specular", "gamma",
    "clip", "ink", "near",
];

/// Camera and tags of all sets: a lens of 2.9 mm on pixels of 3.75 micrometres, 1296x964 of them. Focal length, blur and
/// noise are chosen so that the AprilTag C library 3.4.5 at decimation 1 finds 0.88 of tag36h11 and 0.895 of
/// tagStandard41h12, each +-0.02. Found with seed 1 and 100 frames of every distance and tilt (200 tags a family and
/// distance): 0.879 and 0.903. Frozen: a test holds the hash of the first frames.
const TEXTURED: Recipe = Recipe {
    name: "textured",
    about: "a room full of structure, tags on a white card, 20 to 200 cm",
    size: [1296, 964],
    focal_px: 770.0,
    distances_cm: Span { first: 20, last: 200, step: 20 },
    tilts_deg: [0, 45],
    repetitions: 200,
    ids: Ids::Any,
    card: Card::Margin { width_cm: 1.0 },
    ink: [35.0, 215.0],
    ink_spread_cells: 0.0,
    background: Background::FullRoom,
    blur_sigma: 0.6,
    noise_sigma: 2.5,
    vignetting: 0.25,
    motion_px: 0.0,
    tone: Tone { exposure: 1.0, gamma: 1.0 },
    gloss: Gloss::Matt,
    jpeg_quality: None,
};

/// A light wall without structure, as in the paper's Figure 6.
const WALL: Recipe = Recipe {
    name: "wall",
    about: "a plain light wall, 20 to 200 cm",
    background: Background::Gradient { top_left: 212.0, bottom_right: 188.0 },
    noise_sigma: 1.5,
    repetitions: 10,
    ..TEXTURED
};

/// The paper's own numbers (III-E): ten tags of a family, 20 to 160 cm, 160 frames.
const PAPER: Recipe = Recipe {
    name: "paper",
    about: "the paper's set: ten tags, plain light wall, 20 to 160 cm",
    distances_cm: Span { first: 20, last: 160, step: 20 },
    ids: Ids::Ten,
    ..WALL
};

/// What the harder sets start from: smaller frames, so that many of them cost little, and only distances that are hard.
const BASE: Recipe = Recipe {
    name: "base",
    about: "small frames, 60 to 200 cm: what the harder sets start from",
    size: [480, 360],
    distances_cm: Span { first: 60, last: 200, step: 20 },
    repetitions: 10,
    ..TEXTURED
};

/// The data set of this name.
pub(crate) fn named(name: &str) -> Result<Recipe, String> {
    let lens = |motion_px: f64| Recipe { motion_px, about: "motion blur", ..BASE };
    let noisy = |noise_sigma: f32| Recipe { noise_sigma, about: "sensor noise", ..BASE };
    let jpeg = |quality: u8| Recipe { jpeg_quality: Some(quality), about: "JPEG at low quality", ..BASE };
    let inked = |black: f32, white: f32, about: &'static str| Recipe { ink: [black, white], about, ..BASE };
    let narrow = |cells: f64| Recipe { card: Card::Narrow { cells }, about: "narrow white margin", ..BASE };
    let recipe = match name {
        "paper" => PAPER,
        "wall" => WALL,
        "textured" => TEXTURED,
        "empty" => Recipe { ids: Ids::None, repetitions: 50, about: "the room without any tag", ..TEXTURED },
        "base" => BASE,
        "low1" => inked(95.0, 120.0, "25 grey levels of contrast"),
        "low2" => inked(80.0, 90.0, "10 grey levels of contrast"),
        "dark" => inked(12.0, 60.0, "a dim card in a bright room"),
        "motion2" => lens(2.0),
        "motion4" => lens(4.0),
        "motion6" => lens(6.0),
        "noise5" => noisy(5.0),
        "noise8" => noisy(8.0),
        "tilt" => Recipe { tilts_deg: [60, 70], about: "steep views", ..BASE },
        "margin05" => narrow(0.5),
        "margin0" => narrow(0.0),
        "defocus" => Recipe { blur_sigma: 1.2, about: "out of focus", ..BASE },
        "jpeg50" => jpeg(50),
        "jpeg25" => jpeg(25),
        "specular" => Recipe { gloss: Gloss::Glossy, about: "a lamp mirrored in the tag", ..BASE },
        "gamma" => Recipe { tone: Tone { exposure: 1.0, gamma: 2.2 }, about: "gamma 2.2", ..BASE },
        "clip" => Recipe { tone: Tone { exposure: 1.5, gamma: 1.0 }, about: "white is clipped", ..BASE },
        "ink" => Recipe { ink_spread_cells: 0.1, about: "ink has spread by a tenth of a cell", ..BASE },
        "near" => Recipe {
            distances_cm: Span { first: 10, last: 60, step: 10 },
            about: "small frames, 10 to 60 cm",
            ..BASE
        },
        other => return Err(format!("there is no set {other}: use one of {}", NAMES.join(", "))),
    };
    let name = NAMES.into_iter().find(|known| *known == name).unwrap_or(recipe.name);
    Ok(Recipe { name, ..recipe })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_set_that_calls_itself_so() {
        for name in NAMES {
            assert_eq!(named(name).unwrap().name, name);
        }
        assert!(named("papers").unwrap_err().contains("use one of paper, wall"));
    }

    #[test]
    fn the_papers_set_has_160_frames_a_family_and_the_textured_one_200_a_distance_and_tilt() {
        assert_eq!(named("paper").unwrap().frame_count(), 160);
        assert_eq!(named("textured").unwrap().frame_count(), 4000);
        assert_eq!(named("empty").unwrap().frame_count(), 1000);
        assert_eq!(named("low1").unwrap().frame_count(), 160);
    }
}
