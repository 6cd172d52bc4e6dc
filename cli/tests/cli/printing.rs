//! `tagbus family print`: what is printed is rasterised by others' programs, and its tags are found where they should be.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::GrayImage;
use serde_json::Value;
use tagbus_family::Family;
use tagbus_family::published::FAMILIES;

use crate::support::{Folder, complained, json_lines, printed, tagbus};

const DOTS_AN_INCH: f64 = 300.0;
const PIXELS_A_MM: f64 = DOTS_AN_INCH / 25.4;
/// The farthest that a border edge may be from where it should be.
const MOST_MM: f64 = 0.1;
/// Families with more codes than this are looked at in a sample.
const WHOLE: usize = 600;
const SAMPLE: usize = 500;

fn print(arguments: &[&str], output: &Path) -> String {
    printed(tagbus(["family", "print"]).args(arguments).arg("--output").arg(output), 0)
}

fn refused(arguments: &[&str], output: &Path) -> String {
    complained(tagbus(["family", "print"]).args(arguments).arg("--output").arg(output), 2)
}

/// The page as resvg sees it, 300 dots an inch.
fn rasterised_svg(file: &Path) -> GrayImage {
    let options = resvg::usvg::Options { dpi: DOTS_AN_INCH as f32, ..Default::default() };
    let tree = resvg::usvg::Tree::from_data(&fs::read(file).unwrap(), &options).unwrap();
    let size = tree.size().to_int_size();
    let mut pixels = resvg::tiny_skia::Pixmap::new(size.width(), size.height()).unwrap();
    pixels.fill(resvg::tiny_skia::Color::WHITE);
    resvg::render(&tree, resvg::tiny_skia::Transform::default(), &mut pixels.as_mut());
    // Everything is grey, so one channel is as good as another.
    let luma = pixels.data().iter().step_by(4).copied().collect();
    GrayImage::from_raw(size.width(), size.height(), luma).unwrap()
}

/// The pages as hayro sees them, 300 dots an inch.
fn rasterised_pdf(file: &Path) -> Vec<GrayImage> {
    let pdf = hayro::Pdf::new(Arc::new(fs::read(file).unwrap())).unwrap();
    let scale = DOTS_AN_INCH as f32 / 72.0;
    let settings = hayro::RenderSettings { x_scale: scale, y_scale: scale, ..Default::default() };
    let render = |page| {
        let pixels = hayro::render(page, &hayro::InterpreterSettings::default(), &settings);
        let luma = pixels.data_as_u8_slice().iter().step_by(4).copied().collect();
        GrayImage::from_raw(u32::from(pixels.width()), u32::from(pixels.height()), luma).unwrap()
    };
    pdf.pages().iter().map(render).collect()
}

/// A picture of its own is laid on white, as a print on paper is.
fn on_white(picture: &GrayImage) -> GrayImage {
    let (width, height) = picture.dimensions();
    let mut paper = GrayImage::from_pixel(width + 200, height + 200, image::Luma([255]));
    image::imageops::replace(&mut paper, picture, 100, 100);
    paper
}

/// A found tag: id, and corners in pixels.
struct Found {
    family: String,
    id: u32,
    corners: [[f64; 2]; 4],
}

fn found(families: &str, page: &GrayImage, folder: &Folder) -> Vec<Found> {
    let file = folder.file("page.pgm");
    page.save(&file).unwrap();
    let text = printed(tagbus(["detect", "--json", "--family", families]).arg(&file), 0);
    let number = |value: &Value| value.as_f64().unwrap();
    let tag = |tag: &Value| Found {
        family: tag["family"].as_str().unwrap().to_owned(),
        id: tag["id"].as_u64().unwrap() as u32,
        corners: [0, 1, 2, 3].map(|corner| [0, 1].map(|axis| number(&tag["corners"][corner][axis]))),
    };
    json_lines(&text)[0]["detections"].as_array().unwrap().iter().map(tag).collect()
}

fn apart([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

/// All four sides and both diagonals are those of a square with this side.
fn assert_square(tag: &Found, side_mm: f64, pixels_a_mm: f64) {
    let Found { family, id, corners } = tag;
    let pairs =
        [(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0), (3, 0, 1.0), (0, 2, 2f64.sqrt()), (1, 3, 2f64.sqrt())];
    for (one, other, times) in pairs {
        let length = apart(corners[one], corners[other]) / pixels_a_mm;
        let expected = times * side_mm;
        assert!(
            (length - expected).abs() < MOST_MM,
            "{family} {id}: corners {one} and {other} are {length} mm apart, not {expected}"
        );
    }
}

/// Every id of a small family, and a sample of a large one.
fn ids_of(family: &Family) -> BTreeSet<u32> {
    let count = family.codes().len();
    if count <= WHOLE {
        return (0..count as u32).collect();
    }
    // Spread by the golden ratio over the whole family, its first and last code among them.
    let spread = |place: usize| (place as f64 * 0.618_033_988_749_895).fract() * count as f64;
    let mut ids = BTreeSet::from([count as u32 - 1]);
    let mut places = 0..count;
    while let Some(place) = places.next().filter(|_| ids.len() < SAMPLE) {
        ids.insert(spread(place) as u32);
    }
    ids
}

fn list(ids: &BTreeSet<u32>) -> String {
    ids.iter().map(u32::to_string).collect::<Vec<_>>().join(",")
}

/// The pages of a print, however many they are.
fn pages_of(folder: &Folder, told: &str) -> Vec<PathBuf> {
    let files = told.lines().filter(|line| line.ends_with(".svg"));
    files.map(|line| folder.file(Path::new(line).file_name().unwrap().to_str().unwrap())).collect()
}

#[test]
fn every_printed_tag_is_found_in_its_size_when_another_program_has_rasterised_it() {
    for name in FAMILIES.iter().map(|family| family.name) {
        let folder = Folder::new();
        let ids = ids_of(&Family::published(name).unwrap());
        let told = print(&[name, &list(&ids), "--tag-size", "12mm"], &folder.file("tags.svg"));
        let mut seen = BTreeSet::new();
        for page in pages_of(&folder, &told) {
            for tag in found(name, &rasterised_svg(&page), &folder) {
                assert!(seen.insert(tag.id), "{name}: {} is found twice", tag.id);
                assert_square(&tag, 12.0, PIXELS_A_MM);
            }
        }
        println!("{name}: {} of {} found", seen.len(), ids.len());
        assert_eq!(seen, ids, "{name}");
    }
}

#[test]
fn tags_in_pdf_and_png_are_those_in_svg() {
    let folder = Folder::new();
    let expected: BTreeSet<u32> = (0..4).collect();
    for name in ["tag36h11", "tagCircle49h12", "tagStandard52h13"] {
        let pdf = folder.file(&format!("{name}.pdf"));
        print(&[name, "0-3", "--tag-size", "40mm", "--per-page", "2"], &pdf);
        let pages = rasterised_pdf(&pdf);
        assert_eq!(pages.len(), 2);
        let tags: Vec<Found> = pages.iter().flat_map(|page| found(name, page, &folder)).collect();
        tags.iter().for_each(|tag| assert_square(tag, 40.0, PIXELS_A_MM));
        assert_eq!(tags.iter().map(|tag| tag.id).collect::<BTreeSet<_>>(), expected, "{name}");

        for (page, count) in [("bare", 4), ("a4", 1)] {
            let png = folder.file(&format!("{name}-{page}.png"));
            print(&[name, "0-3", "--tag-size", "40mm", "--page", page], &png);
            let files = fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().path());
            let is_page = |file: &PathBuf| {
                let file = file.file_name().unwrap().to_str().unwrap();
                file.starts_with(&format!("{name}-{page}")) && file.ends_with(".png")
            };
            let files: Vec<PathBuf> = files.filter(is_page).collect();
            assert!(files.len() >= count, "{name} {page}: {files:?}");
            let mut ids = BTreeSet::new();
            for file in files {
                let picture = on_white(&image::open(&file).unwrap().into_luma8());
                for tag in found(name, &picture, &folder) {
                    assert_square(&tag, 40.0, pixels_a_mm(&file));
                    ids.insert(tag.id);
                }
            }
            assert_eq!(ids, expected, "{name} {page}");
        }
    }
}

/// What the file says of the size of its pixels: its chunk pHYs holds pixels a metre, twice, and 1 for metres.
fn pixels_a_mm(file: &Path) -> f64 {
    let bytes = fs::read(file).unwrap();
    let place = bytes.windows(4).position(|chunk| chunk == b"pHYs").unwrap() + 4;
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((number(place), bytes[place + 8]), (number(place + 4), 1));
    f64::from(number(place)) / 1000.0
}

/// Length of the black ruler at the foot of a page, in pixels.
fn ruler(page: &GrayImage) -> f64 {
    let run = |y: u32| {
        let black: Vec<u32> = (0..page.width()).filter(|&x| page.get_pixel(x, y).0[0] < 128).collect();
        match (black.first(), black.last()) {
            (Some(first), Some(last)) if black.len() as u32 == last - first + 1 => black.len(),
            _ => 0,
        }
    };
    let foot = page.height() - (20.0 * PIXELS_A_MM) as u32..page.height();
    foot.map(run).max().unwrap() as f64
}

#[test]
fn the_ruler_is_as_long_as_it_says() {
    let folder = Folder::new();
    let (svg, pdf) = (folder.file("tag.svg"), folder.file("tag.pdf"));
    for page in ["a4", "letter", "300x200mm"] {
        let flags = ["tag25h9", "3", "--printed-size", "90mm", "--force", "--page", page];
        print(&flags, &svg);
        print(&flags, &pdf);
        for picture in [rasterised_svg(&svg), rasterised_pdf(&pdf).remove(0)] {
            let mm = ruler(&picture) / PIXELS_A_MM;
            // A line's width is added, half of it at each end.
            assert!((100.0 - MOST_MM..100.3).contains(&mm), "{page}: {mm} mm");
        }
    }
}

/// The tags of an exported geometry: family, id, corners in metres.
fn geometry_of(file: &Path) -> Vec<Found> {
    let text = fs::read_to_string(file).unwrap();
    let geometry: Value = match file.extension().unwrap().to_str() {
        Some("json") => serde_json::from_str(&text).unwrap(),
        _ => toml::from_str(&text).unwrap(),
    };
    assert_eq!(geometry["unit"], "m");
    let tags = geometry["boards"][0]["tags"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let tag = |tag: &Value| Found {
        family: tag["family"].as_str().unwrap().to_owned(),
        id: tag["id"].as_u64().unwrap() as u32,
        corners: [0, 1, 2, 3].map(|corner| [0, 1].map(|axis| number(&tag["corners"][corner][axis]))),
    };
    tags.iter().map(tag).collect()
}

/// Every tag of the geometry is found, and all corners lie as it says, from the first found corner on.
fn assert_lies_as_said(geometry: &[Found], found: &[Found]) {
    assert_eq!(geometry.len(), found.len());
    let pixels = |[x, y]: [f64; 2]| [x * 1000.0 * PIXELS_A_MM, y * 1000.0 * PIXELS_A_MM];
    let seen = |said: &Found| {
        found.iter().find(|tag| (&tag.family, tag.id) == (&said.family, said.id)).unwrap_or_else(|| {
            panic!("{} {} is not found", said.family, said.id);
        })
    };
    let origin = {
        let ([x, y], [said_x, said_y]) = (seen(&geometry[0]).corners[0], pixels(geometry[0].corners[0]));
        [x - said_x, y - said_y]
    };
    for said in geometry {
        for (corner, said_corner) in seen(said).corners.iter().zip(said.corners) {
            let [x, y] = pixels(said_corner);
            let off_mm = apart(*corner, [x + origin[0], y + origin[1]]) / PIXELS_A_MM;
            assert!(off_mm < MOST_MM, "{} {} is {off_mm} mm off", said.family, said.id);
        }
    }
}

#[test]
fn boards_are_where_their_geometry_says() {
    let folder = Folder::new();
    let (svg, toml) = (folder.file("board.svg"), folder.file("board.toml"));
    let flags = ["tagStandard41h12", "30-41", "--tag-size", "20mm", "--board", "3x4", "--spacing", "9.5mm"];
    print(&[&flags[..], &["--margin", "4mm", "--geometry", toml.to_str().unwrap()]].concat(), &svg);
    let tags = found("tagStandard41h12", &rasterised_svg(&svg), &folder);
    let geometry = geometry_of(&toml);
    assert_eq!(geometry.iter().map(|tag| tag.id).collect::<Vec<_>>(), Vec::from_iter(30..42));
    assert_lies_as_said(&geometry, &tags);
}

#[test]
fn nested_tags_are_all_found_each_a_fifth_of_the_one_outside() {
    let folder = Folder::new();
    let (pdf, json) = (folder.file("nest.pdf"), folder.file("nest.json"));
    let nest = "tagCustom48h12:0,tagCustom48h12:17,tagCustom48h12:42210";
    print(&["--nest", nest, "--printed-size", "190mm", "--geometry", json.to_str().unwrap()], &pdf);
    let tags = found("tagCustom48h12", &rasterised_pdf(&pdf)[0], &folder);
    let geometry = geometry_of(&json);
    assert_lies_as_said(&geometry, &tags);
    let side = |tag: &Found| apart(tag.corners[0], tag.corners[1]);
    for pair in geometry.windows(2) {
        assert!((side(&pair[0]) / side(&pair[1]) - 5.0).abs() < 1e-6);
    }
}

#[test]
fn there_is_no_seam_where_the_black_of_nested_tags_meets() {
    let folder = Folder::new();
    let (svg, pdf) = (folder.file("nest.svg"), folder.file("nest.pdf"));
    for file in [&svg, &pdf] {
        print(&["--nest", "tagCustom48h12:0,tagCustom48h12:1", "--printed-size", "149.7mm"], file);
    }
    for page in [rasterised_svg(&svg), rasterised_pdf(&pdf).remove(0)] {
        let tags = found("tagCustom48h12", &page, &folder);
        let [[left, foot], [right, _], ..] = tags.iter().find(|tag| tag.id == 1).unwrap().corners;
        // The print ends two cells outside of the border edge, which is six wide.
        let end = (foot + (right - left) / 3.0) as u32;
        let columns = (left as u32..right as u32).map(|x| [end - 5, end + 5].map(|y| (x, y)));
        let is_black = |&(x, y): &(u32, u32)| page.get_pixel(x, y).0[0] == 0;
        let black: Vec<_> = columns.filter(|ends| ends.iter().all(is_black)).collect();
        assert!(black.len() > 20, "black meets in {} columns", black.len());
        for [(x, top), (_, bottom)] in black {
            assert!((top..bottom).all(|y| is_black(&(x, y))), "a seam at {x}, {end}");
        }
    }
}

#[test]
fn a_layout_of_ones_own_is_printed_and_found() {
    let folder = Folder::new();
    let (file, picture) = (folder.file("mine.toml"), folder.file("tag.png"));
    let flags = ["--layout", "circle:9", "--distance", "7", "--codes", "5", "--candidates", "3000000"];
    printed(tagbus(["family", "generate"]).args(flags).arg("--output").arg(&file), 0);
    let family = file.to_str().unwrap();
    print(&[family, "2", "--printed-size", "60mm"], &picture);
    let tags = found(family, &on_white(&image::open(&picture).unwrap().into_luma8()), &folder);
    assert_eq!(tags.iter().map(|tag| (tag.family.as_str(), tag.id)).collect::<Vec<_>>(), [("mine", 2)]);
}

#[test]
fn what_cannot_be_printed_is_refused_and_nothing_is_written() {
    let folder = Folder::new();
    let svg = folder.file("tags.svg");
    let size = ["--tag-size", "20mm"];
    for (arguments, part) in [
        (vec!["tag16h5", "28-30", "--tag-size", "20mm"], "tag16h5 has no id 30: it has 30 tags, ids 0 to 29"),
        (vec!["tag16h5", "1,2,1", "--tag-size", "20mm"], "id 1 is named twice"),
        (vec!["tag16h5", "1"], "--tag-size or --printed-size"),
        (vec!["tag16h5", "1", "--tag-size", "20"], "write a number from 0 to 5 m with its unit"),
        (vec!["tag16h5", "1", "--tag-size", "0mm"], "0 mm"),
        (vec!["tag16h5", "1", "--tag-size", "20mm", "--printed-size", "30mm"], "cannot be used with"),
        (vec!["tag16h5", "1", "--tag-size", "400mm"], "the largest tag size is"),
        (vec!["tag16h5", "1", "--tag-size", "20mm", "--page", "a5"], "write a4, letter, or width and height"),
        (
            vec!["tag16h5", "0-4", "--tag-size", "20mm", "--board", "2x2", "--spacing", "5mm"],
            "do not fill boards of 2 x 2",
        ),
        (
            vec!["tag16h5", "0-3", "--tag-size", "20mm", "--per-page", "999"],
            "999 a page are asked for, but A4 (210 x 297 mm) holds",
        ),
        (vec!["tag16h5", "0-3", "--tag-size", "20mm", "--format", "gif"], "\"gif\" is no format"),
        (vec!["--nest", "tag36h11:0,tag16h5:0", "--tag-size", "90mm"], "tag36h11 has no hole"),
        (vec!["--nest", "tag36h11", "--tag-size", "90mm"], "write NAME:ID"),
    ] {
        let message = refused(&arguments, &svg);
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert!(!svg.exists(), "{arguments:?}");
    }
    print(&[&["tag16h5", "1"], &size[..]].concat(), &svg);
    let before = fs::read(&svg).unwrap();
    let message = refused(&[&["tag16h5", "2"], &size[..]].concat(), &svg);
    assert!(message.contains("exists and is left as it is"), "{message}");
    assert_eq!(fs::read(&svg).unwrap(), before);
}

#[test]
fn a_configuration_file_for_cameras_does_not_disturb_printing() {
    let folder = Folder::new();
    let (config, svg) = (folder.file("tagbus.toml"), folder.file("tag.svg"));
    fs::write(&config, "format = \"NV12\"\n").unwrap();
    print(&["--config", config.to_str().unwrap(), "tag16h5", "1", "--tag-size", "20mm"], &svg);
    assert!(svg.exists());
}
