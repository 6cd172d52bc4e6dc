//! Families of one's own, from a string of cells to a print and to a running service: nothing is built anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use image::{GrayImage, Luma};
use rustix::process::Signal;
use tagbus_family::Family;

use crate::families_of_others::{only_tag, picture_of};
use crate::generating::{family_of, generate};
use crate::support::{Bus, Folder, Running, Watchdog, printed, tagbus};

/// Nothing but a black ring in a white one and 5 x 5 cells of data.
const PLAIN: &str =
    "wwwwwwwww wbbbbbbbw wbdddddbw wbdddddbw wbdddddbw wbdddddbw wbdddddbw wbbbbbbbw wwwwwwwww";
/// A bright border, data inside and outside, and a hole in the middle for a smaller tag.
const HOLE: &str = "dddddddddd dbbbbbbbbd dbwwwwwwbd dbwddddwbd dbwdxxdwbd dbwdxxdwbd dbwddddwbd dbwwwwwwbd dbbbbbbbbd dddddddddd";
/// Data on both sides of a border that has white outside.
const BOTH_SIDES: &str = "xdddddx dwwwwwd dwbbbwd dwbdbwd dwbbbwd dwwwwwd xdddddx";
/// A disc: the corners of the square are not part of the tag. Its border is white outside, and the cell in the middle is
/// black in every tag.
const DISC: &str = "xxxxdddxxxx xxdddddddxx xdwwwwwwwdx xdwbbbbbwdx ddwbdddbwdd ddwbdbdbwdd ddwbdddbwdd xdwbbbbbwdx xdwwwwwwwdx xxdddddddxx xxxxdddxxxx";

/// Name of the family (and of its file), its cells, and the distance of its tags.
const FAMILIES: [(&str, &str, &str); 4] =
    [("plain", PLAIN, "9"), ("hole", HOLE, "15"), ("both-sides", BOTH_SIDES, "7"), ("disc", DISC, "12")];

/// Generates a family into a folder.
fn made(folder: &Path, (name, layout, distance): (&str, &str, &str)) -> Family {
    let file = folder.join(format!("{name}.toml"));
    let flags = ["--layout", layout, "--distance", distance, "--codes", "12", "--candidates", "3000000"];
    printed(&mut generate(&flags, &file), 0);
    family_of(&file).family
}

/// The last tag of a family, which is in its picture.
fn last_id(family: &Family) -> u32 {
    family.codes().len() as u32 - 1
}

/// Prints a tag as PNG and lays it on the middle of a sheet of paper.
fn print_of(family_file: &Path, id: u32, picture: &Path) {
    let mut print = tagbus(["family", "print"]);
    print.arg(family_file).args([&id.to_string(), "--printed-size", "15mm", "--output"]).arg(picture);
    printed(&mut print, 0);
    let tag = image::open(picture).unwrap().into_luma8();
    let mut paper = GrayImage::from_pixel(640, 480, Luma([255]));
    let [left, top] = [640 - tag.width(), 480 - tag.height()].map(|rest| i64::from(rest / 2));
    image::imageops::replace(&mut paper, &tag, left, top);
    paper.save(picture).unwrap();
}

/// A folder of families, each with a print of its last tag in the folder `pictures`; gives what is in the pictures.
fn families_with_prints(folder: &Path) -> BTreeSet<(String, u64)> {
    fs::create_dir(folder.join("pictures")).unwrap();
    let one = |wanted: (&str, &str, &str)| {
        let name = wanted.0;
        let id = last_id(&made(folder, wanted));
        assert!(id > 2, "{name}: only {} tags", id + 1);
        print_of(&folder.join(format!("{name}.toml")), id, &folder.join(format!("pictures/{name}.png")));
        (name.to_owned(), u64::from(id))
    };
    FAMILIES.map(one).into()
}

fn family_flag() -> String {
    format!("--family={}", FAMILIES.map(|(name, ..)| format!("{name}.toml")).join(","))
}

/// Reads frames until every tag of `truth` has been seen, and every picture could have come by a few times; gives all tags.
fn tags_of_frames(watch: &Running, truth: &BTreeSet<(String, u64)>) -> BTreeSet<(String, u64)> {
    let mut seen = BTreeSet::new();
    for frames in 0.. {
        if frames >= 5 * FAMILIES.len() && seen.is_superset(truth) {
            break;
        }
        for tag in watch.json()["detections"].as_array().unwrap() {
            seen.insert((tag["family"].as_str().unwrap().to_owned(), tag["id"].as_u64().unwrap()));
        }
    }
    seen
}

#[test]
fn tags_of_generated_families_are_found_in_prints_and_in_pictures_with_their_corners() {
    let _watchdog = Watchdog::of_seconds(300, "own families in pictures");
    let folder = Folder::new();
    for wanted in FAMILIES {
        let (family, name) = (made(&folder.0, wanted), wanted.0);
        let id = last_id(&family);
        let [file, picture] = ["toml", "png"].map(|ending| folder.file(&format!("{name}.{ending}")));
        let only_tag = || {
            let tag = only_tag(file.to_str().unwrap(), &picture);
            assert_eq!((tag["family"].as_str(), tag["id"].as_u64()), (Some(name), Some(u64::from(id))));
            tag
        };
        print_of(&file, id, &picture);
        only_tag();
        let truth = picture_of(&family, id, &picture);
        for (corner, [x, y]) in only_tag()["corners"].as_array().unwrap().iter().zip(truth) {
            let [found_x, found_y] = [0, 1].map(|axis| corner[axis].as_f64().unwrap());
            let distance = (found_x - x).hypot(found_y - y);
            assert!(distance < 0.5, "{name}: corner {found_x}, {found_y} is {distance} px from {x}, {y}");
        }
    }
}

#[test]
fn a_running_service_finds_the_tags_of_generated_families() {
    let _watchdog = Watchdog::of_seconds(300, "own families in a service");
    let (folder, bus) = (Folder::new(), Bus::new());
    let truth = families_with_prints(&folder.0);
    let source = format!("--source=replay:{}", folder.file("pictures").display());
    let mut service = bus.command("service", &[&family_flag()]);
    service.current_dir(&folder.0);
    let _service = Running::start(service);
    let _camera = bus.start("camera", &[&source]);
    let watch = bus.start("watch", &["--json"]);
    assert_eq!(tags_of_frames(&watch, &truth), truth);
}

#[test]
fn run_hands_families_on_to_its_service_also_by_relative_paths_and_from_the_configuration() {
    let _watchdog = Watchdog::of_seconds(300, "own families in run");
    let folder = Folder::new();
    let truth = families_with_prints(&folder.0);
    let list = FAMILIES.map(|(name, ..)| format!("\"./{name}.toml\"")).join(", ");
    fs::write(folder.file("run.toml"), format!("family = [{list}]\n")).unwrap();
    for families in [family_flag(), "--config=run.toml".to_owned()] {
        let bus = Bus::new();
        let mut run = bus.command("run", &["--json", "--source=replay:pictures", &families]);
        run.current_dir(&folder.0);
        let mut run = Running::start(run);
        assert_eq!(tags_of_frames(&run, &truth), truth, "{families}");
        run.send(Signal::INT);
        assert_eq!(run.wait().code(), Some(0));
        bus.wait_until_gone();
    }
}
