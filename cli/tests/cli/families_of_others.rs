//! Families that are not ours: pictures of their tags are searched under the names that their users know.

use std::path::Path;

use image::GrayImage;
use serde_json::Value;
use tagbus_family::Family;
use tagbus_scene::{Photo, Placement, Tag, Turn, View, homography_of, photograph};

use crate::support::{Folder, json_lines, printed, tagbus};

/// Writes a picture of one tag, turned and tilted; gives its true corners.
pub(crate) fn picture_of(family: &Family, id: u32, file: &Path) -> [[f64; 2]; 4] {
    let turn = Turn { rotation_rad: 2.1, tilt_rad: 0.4, tilt_direction_rad: 0.3 };
    let homography = homography_of(family.layout(), &View { turn, ..View::default() });
    let placement = Placement::new(Tag::new(family, id).unwrap(), homography);
    let photo = Photo { blur_sigma: 0.5, noise_sigma: 2.0, ..Photo::default() };
    let luma = photograph(&photo, std::slice::from_ref(&placement));
    GrayImage::from_raw(640, 480, luma).unwrap().save(file).unwrap();
    placement.truth(640, 480)[0].corners
}

/// The one tag that is found in a picture.
pub(crate) fn only_tag(family: &str, file: &Path) -> Value {
    let text = printed(tagbus(["detect", "--json", "--family", family]).arg(file), 0);
    let picture = json_lines(&text).remove(0);
    assert_eq!(picture["detections"].as_array().unwrap().len(), 1, "{picture}");
    picture["detections"][0].clone()
}

#[test]
fn pictures_of_aruco_and_kalibr_tags_are_searched_under_the_names_that_opencv_and_kalibr_give_them() {
    let folder = Folder::new();
    let file = folder.file("tag.png");
    for (name, id) in [
        ("DICT_4X4_50", 17),
        ("DICT_6X6_250", 203),
        ("DICT_7X7_1000", 999),
        ("DICT_ARUCO_MIP_36h12", 249),
        ("DICT_ARUCO_ORIGINAL", 500),
        ("kalibr36h11", 586),
    ] {
        let truth = picture_of(&Family::published(name).unwrap(), id, &file);
        let tag = only_tag(&name.to_lowercase(), &file);
        assert_eq!((tag["family"].as_str(), tag["id"].as_u64()), (Some(name), Some(u64::from(id))), "{name}");
        for (corner, [x, y]) in tag["corners"].as_array().unwrap().iter().zip(truth) {
            let [found_x, found_y] = [0, 1].map(|axis| corner[axis].as_f64().unwrap());
            let distance = (found_x - x).hypot(found_y - y);
            assert!(distance < 0.5, "{name}: corner {found_x}, {found_y} is {distance} px from {x}, {y}");
        }
    }
}
