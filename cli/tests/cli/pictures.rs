//! `tagbus detect` on pictures with known truth, and on files that are none.

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma};
use serde_json::Value;
use tagbus_family::Family;
use tagbus_scene::{Photo, Placement, Tag, Turn, View, homography_of, photograph};

use crate::support::{Folder, complaints, json_lines, printed, tagbus};

const FAMILY: &str = "tagStandard41h12";
const ID: u32 = 77;

/// Writes a picture of one tag; gives its true corners.
fn picture_of_a_tag(file: &Path, rotation_rad: f64) -> [[f64; 2]; 4] {
    let family = Family::published(FAMILY).unwrap();
    let turn = Turn { rotation_rad, tilt_rad: 0.5, tilt_direction_rad: 0.3 };
    let homography = homography_of(family.layout(), &View { turn, ..View::default() });
    let placement = Placement::new(Tag::new(&family, ID).unwrap(), homography);
    let photo = Photo { blur_sigma: 0.5, noise_sigma: 2.0, ..Photo::default() };
    let luma = photograph(&photo, std::slice::from_ref(&placement));
    GrayImage::from_raw(640, 480, luma).unwrap().save(file).unwrap();
    placement.truth(640, 480)[0].corners
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

#[test]
fn json_has_the_tag_where_it_is_and_a_time_for_every_search() {
    let folder = Folder::new();
    let file = folder.file("tag.png");
    let truth = picture_of_a_tag(&file, 2.1);
    for level in ["scalar", "best"] {
        let mut command = tagbus(["detect", "--json", "--repeat=3", "--family", FAMILY]);
        if level != "best" {
            command.args(["--level", level]);
        }
        let picture = &json_lines(&printed(command.arg(&file), 0))[0];
        assert_eq!(picture["image"], file.to_str().unwrap());
        assert_eq!((picture["width"].as_u64(), picture["height"].as_u64()), (Some(640), Some(480)));
        assert_eq!((numbers(&picture["detect_us"]).len(), numbers(&picture["cpu_us"]).len()), (3, 3));
        let stages: Vec<&String> = picture["stages_us"].as_object().unwrap().keys().collect();
        assert_eq!(stages, ["binarize", "cluster", "fit", "identify"]);
        let [tag] = picture["detections"].as_array().unwrap().as_slice() else { panic!("{picture}") };
        assert_eq!(
            (tag["family"].as_str(), tag["id"].as_u64(), tag["hamming"].as_u64()),
            (Some(FAMILY), Some(77), Some(0))
        );
        assert_eq!((numbers(&tag["homography"]).len(), tag.get("poses")), (9, None));
        for (corner, [x, y]) in tag["corners"].as_array().unwrap().iter().zip(truth) {
            let found = numbers(corner);
            let distance = (found[0] - x).hypot(found[1] - y);
            assert!(distance < 0.5, "corner {found:?} is {distance} px from {x}, {y}");
        }
    }
}

#[test]
fn ids_that_are_not_asked_for_are_not_found() {
    let folder = Folder::new();
    let file = folder.file("tag.png");
    picture_of_a_tag(&file, 0.0);
    let detect = |ids: &str, code| {
        printed(tagbus(["detect", "--json", "--family", FAMILY, "--ids", ids]).arg(&file), code)
    };
    assert!(detect("1-20,77", 0).contains("\"id\":77"));
    assert!(detect("1-76,78-300", 1).contains("\"detections\":[]"));
}

#[test]
fn a_folder_is_searched_in_the_order_of_its_numbers_and_drawn_pictures_are_written() {
    let folder = Folder::new();
    for number in [10, 9, 100] {
        picture_of_a_tag(&folder.file(&format!("frame{number}.png")), f64::from(number));
    }
    fs::write(folder.file("notes.txt"), "no picture and not meant to be one").unwrap();
    let drawn = folder.file("drawn");
    let text = printed(tagbus(["detect", "--family", FAMILY, "--stages"]).args([&drawn, &folder.0]), 0);
    let places: Vec<_> = [9, 10, 100].map(|number| text.find(&format!("frame{number}.png")).unwrap()).into();
    assert!(places.is_sorted() && text.matches("id 77").count() == 3, "{text}");
    let written: Vec<_> = fs::read_dir(&drawn).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(written.len(), 3);
    let picture = image::open(&written[0]).unwrap().into_rgb8();
    assert!(picture.pixels().any(|pixel| pixel.0[0] != pixel.0[1]), "nothing was drawn");
}

#[test]
fn pictures_that_cannot_be_searched_are_named_and_the_good_ones_still_are() {
    let folder = Folder::new();
    let file = |name: &str| folder.file(name);
    picture_of_a_tag(&file("good1.png"), 0.0);
    fs::write(file("text.jpg"), "this is no picture").unwrap();
    fs::write(file("empty.png"), "").unwrap();
    fs::write(file("zero.pgm"), "P5 0 0 255\n").unwrap();
    GrayImage::new(1, 1).save(file("single.png")).unwrap();
    GrayImage::from_pixel(16_385, 8, Luma([9])).save(file("wide.png")).unwrap();
    let whole = fs::read(file("good1.png")).unwrap();
    fs::write(file("cut.png"), &whole[..whole.len() / 2]).unwrap();
    picture_of_a_tag(&file("good2.png"), 1.0);
    let bad = ["text.jpg", "empty.png", "zero.pgm", "single.png", "wide.png", "cut.png", "missing.png"];
    let mut command = tagbus(["detect", "--json", "--family", FAMILY]);
    command.arg(file("good1.png")).args(bad.map(file)).arg(file("good2.png"));
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let good = json_lines(&String::from_utf8(output.stdout.clone()).unwrap());
    assert_eq!(good.len(), 2, "{good:?}");
    assert!(good.iter().all(|picture| picture["detections"].as_array().unwrap().len() == 1), "{good:?}");
    let said = complaints(&output);
    for name in bad {
        assert_eq!(said.lines().filter(|line| line.contains(name)).count(), 1, "{name}: {said}");
    }
    assert!(said.contains("16385x8") && said.contains("1x1"), "{said}");
}
