//! Families that are not ours: pictures of their tags are searched under the names that their users know.

use std::fs;
use std::path::Path;

use image::GrayImage;
use serde_json::Value;
use tagbus_family::Family;
use tagbus_scene::{Photo, Placement, Tag, Turn, View, homography_of, photograph};

use crate::support::{Folder, complained, json_lines, printed, tagbus, test_data};

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

/// The ids that are found in a picture of the folder of real ones, in order.
fn real_ids(family: &str, picture: &Path) -> Vec<u64> {
    let picture = &json_lines(&printed(tagbus(["detect", "--json", "--family", family]).arg(picture), 0))[0];
    let tags = picture["detections"].as_array().unwrap();
    let mut ids: Vec<u64> = tags.iter().map(|tag| tag["id"].as_u64().unwrap()).collect();
    ids.sort_unstable();
    ids
}

#[test]
fn real_boards_of_opencv_and_kalibr_are_read() {
    let Some(folder) = test_data().map(|data| data.join("real/neg-hard")) else { return };
    for shot in ["20469", "25558"] {
        let name = format!("charuco__Microsoft_LifeCam_HD-3000_output_2024-05-07T0727{shot}.jpg");
        assert_eq!(real_ids("DICT_4X4_50", &folder.join(name)), Vec::from_iter(0..32), "{shot}");
    }
    // 6 x 6 tags; one of them may be missed, as long as none is made up.
    let mut grid = real_ids("kalibr36h11", &folder.join("kalibr__EuRoC.png"));
    assert!(grid.len() >= 35 && grid.iter().all(|&id| id < 36), "{grid:?}");
    grid.dedup();
    assert!(grid.len() >= 35, "{grid:?}");
}

/// The first markers of a family as a dictionary of OpenCV.
fn dictionary(family: &Family, count: usize) -> String {
    let layout = family.layout();
    let (width, bits) = (layout.width_at_border() - 2, layout.bit_count() as usize);
    let codes = family.codes()[..count].iter().map(|&code| layout.to_row_major(code));
    let markers: String =
        codes.enumerate().map(|(id, rows)| format!("marker_{id}: \"{rows:0bits$b}\"\n")).collect();
    format!("%YAML:1.0\n---\nnmarkers: {count}\nmarkersize: {width}\nmaxCorrectionBits: 9\n{markers}")
}

#[test]
fn an_imported_family_is_found_in_pictures() {
    let folder = Folder::new();
    let [table, output, picture] = ["mine.yml", "mine.toml", "tag.png"].map(|name| folder.file(name));
    let family = Family::published("DICT_6X6_250").unwrap();
    fs::write(&table, dictionary(&family, 30)).unwrap();
    let mut import = tagbus(["family", "import"]);
    let said = import.arg(&table).arg("--output").arg(&output).output().unwrap();
    let warned = String::from_utf8(said.stderr).unwrap();
    assert!(warned.contains("claims a distance of 19, but its codes are only 14 bits apart"), "{warned}");
    let told = String::from_utf8(said.stdout).unwrap();
    assert!(told.starts_with("mine: 30 tags of 36 bits, at least 14 bits apart"), "{told}");
    picture_of(&family, 29, &picture);
    let tag = only_tag(output.to_str().unwrap(), &picture);
    assert_eq!((tag["family"].as_str(), tag["id"].as_u64()), (Some("mine"), Some(29)));
    picture_of(&family, 30, &picture);
    printed(tagbus(["detect", "--family"]).arg(&output).arg(&picture), 1);
}

#[test]
fn tables_that_are_wrong_and_outputs_that_exist_are_refused_and_nothing_is_written() {
    let folder = Folder::new();
    let [table, output] = ["mine.yml", "mine.toml"].map(|name| folder.file(name));
    let family = Family::published("DICT_4X4_50").unwrap();
    let import = |flags: &[&str]| {
        let mut command = tagbus(["family", "import"]);
        command.arg(&table).arg("--output").arg(&output).args(flags);
        command
    };
    fs::write(&table, dictionary(&family, 5).replace("0000111110011010", "00001111")).unwrap();
    let error = complained(&mut import(&[]), 2);
    assert!(error.contains("mine.yml: line 7: marker_1 must be 16 times 0 or 1"), "{error}");
    let error = complained(&mut import(&["--format", "java"]), 2);
    assert!(error.contains("mine.yml: line"), "{error}");
    let error = complained(&mut import(&["--format", "svg"]), 2);
    assert!(error.contains("auto, c, java, opencv"), "{error}");
    fs::write(&table, dictionary(&family, 5)).unwrap();
    let error = complained(&mut import(&["--name", "a name that does not fit into a message"]), 2);
    assert!(error.contains("1 to 32 fit into a message"), "{error}");
    assert!(!output.exists());
    fs::write(&output, "of somebody").unwrap();
    let error = complained(&mut import(&[]), 2);
    assert!(error.contains("mine.toml exists") && error.contains("--force"), "{error}");
    assert_eq!(fs::read_to_string(&output).unwrap(), "of somebody");
    printed(&mut import(&["--force", "--name", "forced"]), 0);
    assert!(printed(tagbus(["family", "show"]).arg(&output), 0).starts_with("forced: 5 tags"));
    fs::remove_file(&table).unwrap();
    let error = complained(&mut import(&["--force"]), 2);
    assert!(error.contains("mine.yml: No such file"), "{error}");
}
