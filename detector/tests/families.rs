//! Every published family is read in every rotation.

#[allow(dead_code, reason = "each test file uses its part")]
mod common;

use common::{READABLE, decimated, random_case, worst_corner};
use tagbus_detector::{Detector, LumaView};
use tagbus_family::Family;
use tagbus_scene::Stream;

/// Cases a family, a quarter of them in each quarter turn.
const CASES: u32 = 200;
/// Corners are surely better than this at 4 pixels a cell; more would mean another corner order or a shifted grid.
const CORNER_TOLERANCE_PX: f64 = 1.0;

fn every_case_is_found(name: &str) {
    let family = Family::published(name).expect("a published name");
    let mut detector =
        Detector::new(std::slice::from_ref(&family), &decimated(1.0)).expect("possible settings");
    let mut random = Stream::new(0x7a6 + u64::from(family.layout().bit_count()));
    for case in 0..CASES {
        let picture = random_case(&family, &READABLE, case % 4, &mut random);
        let view =
            LumaView::grey(&picture.luma, picture.width, picture.height).expect("the picture fits its bytes");
        let found = detector.detect(&view);
        let right = found.iter().filter(|tag| tag.id == picture.id).collect::<Vec<_>>();
        assert_eq!(
            (found.len(), right.len()),
            (1, 1),
            "{name} case {case}: wanted id {}, got {found:?}",
            picture.id
        );
        let off = worst_corner(right[0], &picture.homography);
        assert!(off < CORNER_TOLERANCE_PX, "{name} case {case}: a corner is {off:.2} px off");
    }
}

macro_rules! found_in_all_cases {
    ($($test:ident: $name:literal,)*) => {
        $(#[test] fn $test() { every_case_is_found($name); })*
    };
}

found_in_all_cases! {
    tag_16h5_is_found_in_all_cases: "tag16h5",
    tag_25h9_is_found_in_all_cases: "tag25h9",
    tag_36h10_is_found_in_all_cases: "tag36h10",
    tag_36h11_is_found_in_all_cases: "tag36h11",
    tag_circle_21h7_is_found_in_all_cases: "tagCircle21h7",
    tag_circle_49h12_is_found_in_all_cases: "tagCircle49h12",
    tag_custom_48h12_is_found_in_all_cases: "tagCustom48h12",
    tag_standard_41h12_is_found_in_all_cases: "tagStandard41h12",
    tag_standard_52h13_is_found_in_all_cases: "tagStandard52h13",
}
