//! What each search finds that a quicker one does not.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[allow(dead_code, reason = "each test file uses its part")]
mod common;

use common::decimated;
use tagbus_detector::{Detector, LumaView, Sampling, Search, Settings};
use tagbus_family::Family;
use tagbus_scene::{Background, Photo, Placement, Stream, Tag, Turn, View, homography_of, photograph};

const SIDE: usize = 240;

/// How a tag and what is behind it look.
struct Look {
    cell_px: f64,
    black: f32,
    white: f32,
    behind: f32,
    noise_sigma: f32,
}

/// Draws a tag of this look, turned at random.
fn picture(family: &Family, look: &Look, random: &mut Stream) -> (u32, Vec<u8>) {
    let id = random.below(family.codes().len() as u64) as u32;
    let turn = Turn {
        rotation_rad: random.between(0.0, std::f64::consts::TAU),
        tilt_rad: random.between(0.0, 0.4),
        tilt_direction_rad: random.between(0.0, std::f64::consts::TAU),
    };
    let middle = SIDE as f64 * 0.5;
    let view = View { centre: [middle; 2], cell_px: look.cell_px, turn, focal_px: 800.0 };
    let tag = Tag::new(family, id).unwrap();
    let mut placement = Placement::new(tag, homography_of(family.layout(), &view));
    (placement.black, placement.white) = (look.black, look.white);
    let photo = Photo {
        width: SIDE,
        height: SIDE,
        background: Background::Plain(look.behind),
        blur_sigma: 0.6,
        noise_sigma: look.noise_sigma,
        seed: random.bits(),
        ..Photo::default()
    };
    (id, photograph(&photo, &[placement]))
}

/// Of `count` pictures, those in which the search finds the tag at full resolution; nothing else may be found.
fn found(search: Search, family: &Family, look: &Look, count: usize) -> usize {
    found_with(&Settings { search, ..decimated(1.0) }, family, look, count)
}

fn found_with(settings: &Settings, family: &Family, look: &Look, count: usize) -> usize {
    let mut detector = Detector::new(std::slice::from_ref(family), settings).unwrap();
    let mut random = Stream::new(31);
    let is_found = |_: &usize| {
        let (id, luma) = picture(family, look, &mut random);
        let tags = detector.detect(&LumaView::grey(&luma, SIDE, SIDE).unwrap());
        assert!(tags.len() <= 1 && tags.iter().all(|tag| tag.id == id), "{id}: {tags:?}");
        tags.len() == 1
    };
    (0..count).filter(is_found).count()
}

#[test]
fn a_fine_search_finds_tags_on_a_card_that_is_darker_than_what_lies_beside_it() {
    let look = Look { cell_px: 6.5, black: 12.0, white: 60.0, behind: 220.0, noise_sigma: 2.0 };
    let family = Family::published("tag36h11").unwrap();
    let [quick, fine, thorough] =
        [Search::Quick, Search::Fine, Search::Thorough].map(|search| found(search, &family, &look, 60));
    assert!(fine == 60 && thorough == 60, "fine {fine}, thorough {thorough} of 60");
    assert!(quick < 30, "a quick search finds {quick} of 60 too: the picture shows no difference");
}

#[test]
fn a_thorough_search_finds_tags_whose_contrast_is_hardly_more_than_the_noise_of_a_window() {
    let look = Look { cell_px: 9.0, black: 100.0, white: 110.0, behind: 110.0, noise_sigma: 2.5 };
    for name in ["tag36h11", "tagStandard41h12"] {
        let family = Family::published(name).unwrap();
        let [quick, thorough] =
            [Search::Quick, Search::Thorough].map(|search| found(search, &family, &look, 40));
        assert!(thorough >= 35, "{name}: {thorough} of 40");
        assert!(
            quick < 10,
            "{name}: a quick search finds {quick} of 40 too: the picture shows no difference"
        );
    }
}

#[test]
fn the_darkest_of_four_pixels_keeps_borders_that_points_break() {
    let look = Look { cell_px: 2.3, black: 30.0, white: 210.0, behind: 210.0, noise_sigma: 2.0 };
    let family = Family::published("tag36h11").unwrap();
    let [point, mean, darkest] = [Sampling::Point, Sampling::Mean, Sampling::Darkest].map(|sampling| {
        let settings = Settings { sampling, ..decimated(2.0) };
        found_with(&settings, &family, &look, 100)
    });
    assert!(darkest >= 90, "{darkest} of 100");
    assert!(darkest > mean + 5 && mean >= point, "darkest {darkest}, mean {mean}, point {point}");
}

#[test]
fn what_a_quick_search_finds_the_others_find_too_and_report_once() {
    let look = Look { cell_px: 5.0, black: 20.0, white: 200.0, behind: 128.0, noise_sigma: 3.0 };
    for name in ["tag36h11", "tagStandard41h12", "tagCustom48h12"] {
        let family = Family::published(name).unwrap();
        for search in [Search::Quick, Search::Fine, Search::Thorough] {
            assert_eq!(found(search, &family, &look, 30), 30, "{name}, {}", search.name());
        }
    }
}
