//! `tagbus detect --decimate 1` on real pictures, beside what the AprilTag C library finds in them at full resolution.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;
use tagbus_family::Family;

use crate::support::{json_lines, tagbus, test_data};

/// Share of all expected tags that must be found, and the least mean of the shares over pictures.
const LEAST_RECALL: f64 = 0.99;
const LEAST_MEAN_RECALL: f64 = 0.98;
/// The farthest that a corner may be from the reference's, on tags whose shortest side is longer than this.
const MOST_CORNER_PX: f64 = 0.6;
const LARGE_SIDE_PX: f64 = 20.0;
/// Corners so near to the rim are not compared: there the window in which the reference looks for an edge is cut off by the
/// rim, and its corner is drawn to one side.
const RIM_PX: f64 = 2.0;
/// Corners that are known to be farther from the reference's: file, id, and how far in pixels.
const KNOWN_CORNERS: [(&str, u64, f64); 1] =
    // Seen so flat that a row of cells is little more than a pixel high. Sides meet at 15 degrees, so a quarter of a pixel
    // between two lines moves their corner by one; which of the two is right cannot be told by eye.
    [("tags/swarmathon__34139872896_defdb2f8d9_c.jpg", 0, 0.98)];
/// What a known distance may grow by before it counts as a new one, in pixels.
const KNOWN_SLACK_PX: f64 = 0.1;
/// Corrected bits of the reference, as the manifest's line `tool` says; they are our defaults.
const CORRECTED: [(&str, u32); 8] = [
    ("tag16h5", 0),
    ("tag25h9", 2),
    ("tag36h11", 2),
    ("tagStandard41h12", 2),
    ("tagStandard52h13", 1),
    ("tagCircle49h12", 1),
    ("tagCustom48h12", 1),
    ("tagCircle21h7", 1),
];

fn manifest(data: &Path) -> Vec<Value> {
    let text = fs::read_to_string(data.join("real/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    manifest["files"].as_array().unwrap().clone()
}

fn in_folder<'a>(files: &'a [Value], folder: &str) -> Vec<&'a Value> {
    files.iter().filter(|file| text(&file["file"]).split('/').next() == Some(folder)).collect()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

fn point(value: &Value) -> [f64; 2] {
    [0, 1].map(|axis| value[axis].as_f64().unwrap())
}

fn corners(tag: &Value) -> [[f64; 2]; 4] {
    [0, 1, 2, 3].map(|corner| point(&tag["corners"][corner]))
}

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

fn shortest_side(tag: &Value) -> f64 {
    let corners = corners(tag);
    (0..4).map(|side| distance(corners[side], corners[(side + 1) % 4])).fold(f64::INFINITY, f64::min)
}

fn tags(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

/// What is found in these files, in their order.
fn detect(data: &Path, families: &str, files: &[&Value]) -> Vec<Value> {
    let paths = files.iter().map(|file| data.join("real").join(text(&file["file"])));
    let output =
        tagbus(["detect", "--json", "--decimate", "1", "--family", families]).args(paths).output().unwrap();
    let pictures = json_lines(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(pictures.len(), files.len(), "{}", String::from_utf8_lossy(&output.stderr));
    pictures
}

/// What was compared, over all pictures.
#[derive(Default)]
struct Score {
    expected: usize,
    found: usize,
    shares: Vec<f64>,
    /// The worst corner of each large tag away from the rim.
    corners: Vec<f64>,
    exceptions: Vec<String>,
    unknown_corners: usize,
}

impl Score {
    fn picture(&mut self, file: &Value, picture: &Value) {
        let expected = tags(&file["expected"]);
        let mut left: Vec<&Value> = tags(&picture["detections"]).iter().collect();
        let mut found = 0;
        for tag in expected {
            match take_nearest(&mut left, tag) {
                Some(detection) => {
                    found += 1;
                    self.compare_corners(file, tag, detection);
                }
                None => self.except(file, tag, "was not found"),
            }
        }
        (self.expected, self.found) = (self.expected + expected.len(), self.found + found);
        if !expected.is_empty() {
            self.shares.push(found as f64 / expected.len() as f64);
        }
    }

    fn compare_corners(&mut self, file: &Value, tag: &Value, detection: &Value) {
        if shortest_side(tag) <= LARGE_SIDE_PX {
            return;
        }
        let apart = corners(tag).into_iter().zip(corners(detection)).map(|(a, b)| distance(a, b));
        let worst = apart.fold(0.0, f64::max);
        if is_at_rim(file, tag) {
            if worst > MOST_CORNER_PX {
                self.except(file, tag, &format!("has a corner {worst:.2} px off, at the rim"));
            }
            return;
        }
        self.corners.push(worst);
        if worst > MOST_CORNER_PX {
            self.unknown_corners += usize::from(!is_known(file, tag, worst));
            self.except(file, tag, &format!("has a corner {worst:.2} px off"));
        }
    }

    fn except(&mut self, file: &Value, tag: &Value, what: &str) {
        let side = shortest_side(tag);
        let (file, family, id) = (text(&file["file"]), text(&tag["family"]), &tag["id"]);
        self.exceptions.push(format!("{file}: {family} {id} (shortest side {side:.1} px) {what}"));
    }

    fn recall(&self) -> f64 {
        self.found as f64 / self.expected as f64
    }

    fn mean_recall(&self) -> f64 {
        self.shares.iter().sum::<f64>() / self.shares.len() as f64
    }

    fn print(&mut self) {
        self.corners.sort_unstable_by(f64::total_cmp);
        let part = |part: f64| self.corners[(part * (self.corners.len() - 1) as f64) as usize];
        println!(
            "{} of {} tags found ({:.4}), mean over {} pictures {:.4}",
            self.found,
            self.expected,
            self.recall(),
            self.shares.len(),
            self.mean_recall()
        );
        println!(
            "worst corners of {} tags: half within {:.3} px, 95 % within {:.3} px, all within {:.3} px",
            self.corners.len(),
            part(0.5),
            part(0.95),
            part(1.0)
        );
        self.exceptions.iter().for_each(|exception| println!("{exception}"));
    }
}

/// The nearest detection of the same tag whose centre is within half of the tag's shortest side; it is used up.
fn take_nearest<'a>(left: &mut Vec<&'a Value>, tag: &Value) -> Option<&'a Value> {
    let apart = |detection: &Value| distance(point(&detection["center"]), point(&tag["center"]));
    let same = |detection: &Value| {
        detection["family"] == tag["family"]
            && detection["id"] == tag["id"]
            && apart(detection) <= shortest_side(tag) / 2.0
    };
    let candidates = left.iter().enumerate().filter(|(_, detection)| same(detection));
    let (place, _) = candidates.min_by(|(_, a), (_, b)| apart(a).total_cmp(&apart(b)))?;
    Some(left.swap_remove(place))
}

fn is_at_rim(file: &Value, tag: &Value) -> bool {
    let [width, height] = ["width", "height"].map(|side| file[side].as_f64().unwrap());
    let inside = |at: f64, size: f64| (RIM_PX..=size - RIM_PX).contains(&at);
    !corners(tag).iter().all(|&[x, y]| inside(x, width) && inside(y, height))
}

fn is_known(file: &Value, tag: &Value, apart: f64) -> bool {
    let same = |&(name, id, known): &(&str, u64, f64)| {
        file["file"] == name && tag["id"] == id && apart <= known + KNOWN_SLACK_PX
    };
    KNOWN_CORNERS.iter().any(same)
}

#[test]
fn the_reference_corrects_as_many_bits_as_we_do_by_default() {
    for (name, corrected) in CORRECTED {
        assert_eq!(Family::published(name).unwrap().default_hamming(), corrected, "{name}");
    }
}

#[test]
fn what_the_reference_finds_in_real_pictures_is_found_in_the_same_place() {
    let Some(data) = test_data() else { return };
    let files = manifest(&data);
    let mut by_families: BTreeMap<String, Vec<&Value>> = BTreeMap::new();
    for file in in_folder(&files, "tags") {
        let families: Vec<&str> = tags(&file["families"]).iter().map(text).collect();
        by_families.entry(families.join(",")).or_default().push(file);
    }
    let mut score = Score::default();
    for (families, files) in &by_families {
        for (file, picture) in files.iter().zip(detect(&data, families, files)) {
            score.picture(file, &picture);
        }
    }
    score.print();
    assert!(score.recall() >= LEAST_RECALL, "{} of {}", score.found, score.expected);
    assert!(score.mean_recall() >= LEAST_MEAN_RECALL, "{}", score.mean_recall());
    assert_eq!(score.unknown_corners, 0, "{:#?}", score.exceptions);
}

#[test]
fn nothing_is_found_in_real_pictures_without_tags() {
    let Some(data) = test_data() else { return };
    let files = manifest(&data);
    let empty = [in_folder(&files, "neg-natural"), in_folder(&files, "neg-hard")].concat();
    assert!(!empty.is_empty());
    let pictures = detect(&data, "tag36h11,tag36h10,tagStandard41h12", &empty);
    let mut wrong = Vec::new();
    for (file, picture) in empty.iter().zip(&pictures) {
        let ignored = file.get("ignore_families").map(tags).unwrap_or_default();
        let found = tags(&picture["detections"]).iter().filter(|tag| !ignored.contains(&tag["family"]));
        wrong.extend(found.map(|tag| format!("{}: {} {}", file["file"], tag["family"], tag["id"])));
    }
    println!("{} pictures without tags, {} found", empty.len(), wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_tag_of_a_real_video_is_found() {
    let Some(data) = test_data() else { return };
    let files = manifest(&data);
    let mut score = Score::default();
    let frames = in_folder(&files, "seq");
    for (frame, picture) in frames.iter().zip(detect(&data, "tag36h11", &frames)) {
        score.picture(frame, &picture);
    }
    score.print();
    // Corners are only printed: no limit was ever chosen on this video, and none shall be.
    assert_eq!(score.found, score.expected);
}
