//! Threads change how long a frame takes, and nothing else.

#[allow(dead_code, reason = "each test file uses its part")]
mod common;

use common::decimated;
use tagbus_detector::{Detection, Detector, Level, LumaView, Refinement, Settings, SettingsError};
use tagbus_family::Family;
use tagbus_scene::{Scene, SceneConfig, Stream};

/// Counts that divide no frame evenly among them.
const THREADS: [usize; 5] = [1, 2, 3, 5, 8];

struct Picture {
    name: String,
    width: usize,
    height: usize,
    luma: Vec<u8>,
}

impl Picture {
    fn view(&self) -> LumaView<'_> {
        LumaView::grey(&self.luma, self.width, self.height).expect("the picture fits its bytes")
    }
}

/// Families of either border.
fn families() -> Vec<Family> {
    let names = ["tag36h11", "tagStandard41h12", "tagCustom48h12", "tag25h9"];
    names.map(|name| Family::published(name).expect("a published name")).to_vec()
}

/// Frames of moving scenes, large enough that every phase is shared.
fn rendered() -> Vec<Picture> {
    let mut pictures = Vec::new();
    for (seed, width, height) in [(1, 640, 480), (2, 1280, 960), (3, 1920, 1080), (4, 1000, 1203)] {
        let scene = Scene::new(SceneConfig { width, height, seed, ..SceneConfig::default() })
            .expect("a plain configuration");
        for frame in [3, 40, 111] {
            let mut luma = vec![0; width * height];
            scene.render(frame, &mut luma);
            let name = format!("scene {seed}, frame {frame}");
            pictures.push(Picture { name, width, height, luma });
        }
    }
    pictures
}

/// Noise, and forms that cross the frame: what lies across the seams of bands.
fn hostile() -> Vec<Picture> {
    let mut random = Stream::new(5);
    let mut pictures = Vec::new();
    for (width, height) in [(1280, 803), (640, 1500), (97, 4001)] {
        let mut add = |kind: &str, pixel: &mut dyn FnMut(usize, usize) -> u8| {
            let luma = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
            let name = format!("{kind} of {width}x{height}");
            pictures.push(Picture { name, width, height, luma });
        };
        add("noise", &mut |_, _| random.bits() as u8);
        add("coarse noise", &mut |x, y| {
            let tile = (x / 5 * 7919 + y / 5 * 104_729) as u64;
            (tile.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 60 << 4) as u8
        });
        add("a spiral", &mut |x, y| {
            let (dx, dy) = (x as f64 - 0.5 * width as f64, y as f64 - 0.5 * height as f64);
            255 * u8::from((dx.hypot(dy) / 12.0 + dy.atan2(dx) / std::f64::consts::TAU).fract() < 0.5)
        });
        add("combs", &mut |x, y| 255 * u8::from(x / 4 % 2 == 0 || y % 190 < 4));
        add("squares", &mut |x, y| 255 * u8::from((x / 40 + y / 40) % 2 == 0 || (x / 9 + y / 9) % 2 == 0));
        add("nested frames", &mut |x, y| {
            255 * u8::from(x.min(y).min(width - x).min(height - y) / 7 % 2 == 0)
        });
    }
    pictures
}

fn detector(settings: &Settings, threads: usize, level: Level) -> Detector {
    let mut detector =
        Detector::new(&families(), &Settings { threads, ..settings.clone() }).expect("possible settings");
    detector.set_level(level);
    detector
}

/// One detector goes through all pictures, so that what is left of a frame would show in the next.
fn every_count_and_level_agrees(pictures: &[Picture], settings: &Settings) -> Vec<Detection> {
    let mut plain = detector(settings, 1, Level::SCALAR);
    let expected: Vec<_> = pictures.iter().map(|picture| plain.detect(&picture.view()).to_vec()).collect();
    for level in Level::available() {
        for threads in THREADS {
            let mut shared = detector(settings, threads, level);
            for (picture, expected) in pictures.iter().zip(&expected) {
                let found = shared.detect(&picture.view());
                assert_eq!(found, expected, "{}, {threads} threads, {level}, {settings:?}", picture.name);
            }
        }
    }
    expected.concat()
}

#[test]
fn rendered_frames_give_the_same_bits_with_every_number_of_threads_at_every_level() {
    let pictures = rendered();
    for (factor, refinement) in
        [(1.0, Refinement::Edges), (1.0, Refinement::Tag), (1.5, Refinement::None), (2.0, Refinement::Edges)]
    {
        let settings = Settings { refinement, ..decimated(factor) };
        let found = every_count_and_level_agrees(&pictures, &settings);
        assert!(found.len() > 50, "only {} tags at {factor}", found.len());
    }
}

#[test]
fn hostile_frames_give_the_same_bits_with_every_number_of_threads_at_every_level() {
    let pictures = hostile();
    for factor in [1.0, 1.5, 3.0] {
        every_count_and_level_agrees(&pictures, &decimated(factor));
    }
}

#[test]
fn counts_that_are_not_possible_are_refused_with_what_is() {
    for threads in [0, 65, usize::MAX] {
        let settings = Settings { threads, ..Settings::default() };
        let error = Detector::new(&families(), &settings).err().unwrap();
        assert_eq!(error, SettingsError::Threads(threads));
        assert!(error.to_string().contains("from 1 to 64"), "{error}");
    }
}
