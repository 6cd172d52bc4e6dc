//! Formats that no driver here offers, and those that are deeper than 8 bits: tags are found in them where they are.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on says where")]

mod common;

use std::path::{Path, PathBuf};

use common::{Ground, WATCHDOG, receive};
use image::RgbImage;
use serde_json::Value;
use tagbus_camera::{Pace, Source, SourceOptions, parse_format};
use tagbus_detector::{Decimation, Detection, Detector, LumaView, Settings};
use tagbus_family::Family;
use tagbus_message::bus::Patience;
use tagbus_scene::{Scene, SceneConfig};

/// What the issue of these formats allows between a deep or packed frame and the same one in 8 bits. It is 0 as long as the
/// upper bits are what is published.
const DEEP_PX: f64 = 0.05;

/// Between the corners that the manifest of the real pictures states, by another detector, and ours. Seen: up to 0.21.
const PHOTOGRAPH_PX: f64 = 0.3;

/// The same in a mosaic, half of whose pixels are made up of their neighbours. Seen: up to 0.28.
const MOSAIC_PX: f64 = 0.4;

/// The shortest side of a tag that has to be found: of smaller ones a mosaic loses some.
const SHORTEST_SIDE_PX: f64 = 30.0;

/// Colour photographs with tags; the width of the first is odd.
const PHOTOGRAPHS: [&str; 5] = [
    "tags/swarmathon__34139872896_defdb2f8d9_c.jpg",
    "tags/frc2024__Amp_42in.jpg",
    "tags/frc2024__BackAmpZone_117in.jpg",
    "tags/frc2024__SpeakerCenter_143in.jpg",
    "seq/arseq__frame0000.jpg",
];

type Corners = [[f64; 2]; 4];

/// A picture's luma.
struct Grey {
    width: usize,
    luma: Vec<u8>,
}

fn detect(luma: &[u8], width: usize, height: usize) -> Vec<Detection> {
    let settings = Settings { decimation: Decimation::from_factor(1.0).unwrap(), ..Settings::default() };
    let mut detector = Detector::new(&[Family::published("tag36h11").unwrap()], &settings).unwrap();
    detector.detect(&LumaView::grey(luma, width, height).unwrap()).to_vec()
}

/// What is detected in a frame of a file that a camera replays; `format` only where the file does not say it.
fn detected_on_the_bus(
    file: &[u8],
    format: Option<&str>,
    width: usize,
    height: usize,
    copies: u32,
) -> Vec<Detection> {
    let ground = Ground::new();
    let path = ground.file("frames", file);
    let raw = format.is_some();
    let options = SourceOptions {
        width: raw.then_some(width as u32),
        height: raw.then_some(height as u32),
        format: format.map(|name| parse_format(name).unwrap()),
        pace: Pace::from_framerate(50.0).unwrap(),
        ..SourceOptions::default()
    };
    let camera = ground.camera(Source::Replay(path), options);
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    let (header, picture) = receive(&frames);
    drop(frames);
    camera.stop();
    assert_eq!((header.width as usize, header.height as usize), (width, height), "{format:?}");
    assert_eq!(header.copies, copies, "{format:?}");
    detect(&picture, width, height)
}

/// A picture as frames of a deep or packed format. Low bits are what they may be: anything.
fn stored(picture: &Grey, format: &str) -> Vec<u8> {
    let low = |index: usize, bits: u32| (index * 7 + 3) as u16 & ((1 << bits) - 1);
    let words = |bits: u32| -> Vec<u8> {
        let word =
            |(index, &value): (usize, &u8)| (u16::from(value) << bits | low(index, bits)).to_le_bytes();
        picture.luma.iter().enumerate().flat_map(word).collect()
    };
    match format {
        "GREY" => picture.luma.clone(),
        "Y10" => words(2),
        "Y12" => words(4),
        "Y16" => words(8),
        "Y10P" => picture.luma.chunks(picture.width).flat_map(|row| row.chunks(4).flat_map(packed)).collect(),
        _ => unreachable!("a format of this test"),
    }
}

fn packed(values: &[u8]) -> [u8; 5] {
    let mut bytes = [0, 0, 0, 0, 0b10_11_00_01];
    bytes[..values.len()].copy_from_slice(values);
    bytes
}

/// One value of each pixel: that of the colour which the mosaic has there.
fn mosaic(colours: &RgbImage, format: &str) -> Vec<u8> {
    // Red, green and blue as 0, 1, 2: the first two pixels of the first row, then of the second.
    let pattern = match format {
        "GRBG" => [[1, 0], [2, 1]],
        "GBRG" => [[1, 2], [0, 1]],
        "RGGB" => [[0, 1], [1, 2]],
        "BA81" => [[2, 1], [1, 0]],
        _ => unreachable!("a format of this test"),
    };
    colours.enumerate_pixels().map(|(x, y, pixel)| pixel.0[pattern[y as usize % 2][x as usize % 2]]).collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// How far the farthest corner is from the nearest one of ours; the orders in which detectors go round differ.
fn apart(ours: &Corners, theirs: &Corners) -> f64 {
    let nearest = |corner: &[f64; 2]| ours.iter().map(|own| distance(*own, *corner)).fold(f64::MAX, f64::min);
    theirs.iter().map(nearest).fold(0.0, f64::max)
}

/// Every expected tag has to be there, this close.
fn hold_against(found: &[Detection], expected: &[(u32, Corners)], allowed_px: f64, what: &str) {
    for (id, corners) in expected {
        let of_this_id = found.iter().filter(|tag| tag.id == *id);
        let error = of_this_id.map(|tag| apart(&tag.corners, corners)).fold(f64::MAX, f64::min);
        assert!(error <= allowed_px, "{what}: tag {id} is {error:.3} px off, or missing");
    }
}

fn expected_in(found: &[Detection]) -> Vec<(u32, Corners)> {
    found.iter().map(|tag| (tag.id, tag.corners)).collect()
}

/// The real pictures' folder, and what is to be found in one of them by its manifest.
fn real_pictures() -> Option<(PathBuf, Value)> {
    let Some(data) = std::env::var_os("TAGBUS_TEST_DATA") else {
        eprintln!("SKIPPED: TAGBUS_TEST_DATA is not set, so no format was held against real pictures");
        return None;
    };
    let folder = Path::new(&data).join("real");
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    Some((folder, serde_json::from_str(&manifest).unwrap()))
}

fn expected_by(manifest: &Value, file: &str) -> Vec<(u32, Corners)> {
    let entries = manifest["files"].as_array().unwrap();
    let entry = entries.iter().find(|entry| entry["file"] == file).expect("the manifest names the picture");
    let corner = |value: &Value| [value[0].as_f64().unwrap(), value[1].as_f64().unwrap()];
    let corners = |tag: &Value| [0, 1, 2, 3].map(|place| corner(&tag["corners"][place]));
    let tags = entry["expected"].as_array().unwrap().iter();
    let tags = tags.map(|tag| (tag["id"].as_u64().unwrap() as u32, corners(tag)));
    let sides =
        |corners: &Corners| [0, 1, 2, 3].map(|place| distance(corners[place], corners[(place + 1) % 4]));
    tags.filter(|(_, corners)| sides(corners).into_iter().fold(f64::MAX, f64::min) >= SHORTEST_SIDE_PX)
        .collect()
}

#[test]
fn corners_in_frames_of_10_12_and_16_bits_and_in_packed_ones_are_those_of_8_bits() {
    // Its width is no multiple of four, so that rows of packed values end within a group.
    let (width, height) = (642, 480);
    let families = vec!["tag36h11".to_string(); 5];
    let scene = Scene::new(SceneConfig { width, height, families, ..SceneConfig::default() }).unwrap();
    let mut luma = vec![0; width * height];
    scene.render(0, &mut luma);
    let picture = Grey { width, luma };
    let plain = detected_on_the_bus(&stored(&picture, "GREY"), Some("GREY"), width, height, 0);
    assert!(plain.len() >= 3, "{} tags", plain.len());
    for format in ["Y10", "Y12", "Y16", "Y10P"] {
        let deep = detected_on_the_bus(&stored(&picture, format), Some(format), width, height, 1);
        assert_eq!(deep.len(), plain.len(), "{format}");
        for (deep, plain) in deep.iter().zip(&plain) {
            let error = deep.corners.iter().zip(&plain.corners).map(|(a, b)| distance(*a, *b));
            let worst = error.fold(0.0, f64::max);
            assert!(deep.id == plain.id && worst <= DEEP_PX, "{format}: {worst} px");
        }
    }
}

#[test]
fn tags_of_real_pictures_are_found_in_packed_frames_in_mosaics_and_in_videos_of_jpeg() {
    let Some((folder, manifest)) = real_pictures() else { return };
    for file in PHOTOGRAPHS {
        let expected = expected_by(&manifest, file);
        assert!(!expected.is_empty(), "{file}");
        let jpeg = std::fs::read(folder.join(file)).unwrap();
        let colours = image::load_from_memory(&jpeg).unwrap().into_rgb8();
        let (width, height) = (colours.width() as usize, colours.height() as usize);
        let luma = tagbus_camera::picture::load_grey(folder.join(file)).unwrap().luma;

        let video = detected_on_the_bus(&jpeg.repeat(2), None, width, height, 0);
        hold_against(&video, &expected, PHOTOGRAPH_PX, &format!("{file} MJPG"));

        let packed = stored(&Grey { width, luma }, "Y10P");
        let packed = detected_on_the_bus(&packed, Some("Y10P"), width, height, 1);
        hold_against(&packed, &expected_in(&video), DEEP_PX, &format!("{file} Y10P"));
        hold_against(&packed, &expected, PHOTOGRAPH_PX, &format!("{file} Y10P"));

        for format in ["GRBG", "GBRG", "RGGB", "BA81"] {
            let found = detected_on_the_bus(&mosaic(&colours, format), Some(format), width, height, 1);
            hold_against(&found, &expected, MOSAIC_PX, &format!("{file} {format}"));
        }
    }
}
