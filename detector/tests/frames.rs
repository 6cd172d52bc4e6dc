//! Frames of every kind: several families, nested tags, other layouts of the luma, other sizes, hostile content.

#[allow(dead_code, reason = "each test file uses its part")]
mod common;

use common::{decimated, worst_corner};
use tagbus_detector::{
    Decimation, Detection, Detector, Geometry, Level, LumaView, Refinement, Sampling, Settings,
};
use tagbus_family::Family;
use tagbus_scene::{Scene, SceneConfig, Stream};

const WIDTH: usize = 640;
const HEIGHT: usize = 480;

fn scene(seed: u64) -> Scene {
    Scene::new(SceneConfig { width: WIDTH, height: HEIGHT, seed, ..SceneConfig::default() })
        .expect("a plain configuration")
}

fn families_of(scene: &Scene) -> Vec<Family> {
    let mut names: Vec<String> = scene.truth(0).into_iter().map(|tag| tag.family.to_string()).collect();
    names.sort();
    names.dedup();
    names.iter().map(|name| Family::published(name).expect("the scene shows published families")).collect()
}

fn rendered(scene: &Scene, frame: u64) -> Vec<u8> {
    let mut luma = vec![0; WIDTH * HEIGHT];
    scene.render(frame, &mut luma);
    luma
}

#[test]
fn all_tags_of_a_moving_scene_are_found_at_once_nested_ones_too_and_nothing_else() {
    let scene = scene(1);
    let families = families_of(&scene);
    for factor in [1.0, 1.5, 2.0] {
        let mut detector = Detector::new(&families, &decimated(factor)).unwrap();
        for frame in (0..240).step_by(24) {
            let luma = rendered(&scene, frame);
            let found = detector.detect(&LumaView::grey(&luma, WIDTH, HEIGHT).unwrap());
            let truth = scene.truth(frame);
            for tag in truth.iter().filter(|tag| tag.visible) {
                let same = |d: &&Detection| families[d.family].name() == tag.family && d.id == tag.id;
                let best = found.iter().find(same).unwrap_or_else(|| {
                    panic!(
                        "factor {factor}, frame {frame}: {} {} is missing in {found:?}",
                        tag.family, tag.id
                    )
                });
                let off = worst_corner(best, &tag.homography);
                assert!(
                    off < 0.5,
                    "factor {factor}, frame {frame}: {} {} is {off:.2} px off",
                    tag.family,
                    tag.id
                );
            }
            assert_eq!(found.len(), truth.len(), "factor {factor}, frame {frame}: {found:?}");
        }
    }
}

#[test]
fn every_level_gives_the_same_bits() {
    let scene = scene(2);
    let families = families_of(&scene);
    let points = [1.0, 1.5, 2.0, 3.0].map(|factor| (factor, Sampling::Point));
    let others = [2.0, 3.0].map(|factor| [(factor, Sampling::Mean), (factor, Sampling::Darkest)]);
    for refinement in [Refinement::None, Refinement::Edges, Refinement::Tag] {
        for (factor, sampling) in points.into_iter().chain(others.into_iter().flatten()) {
            let settings = Settings { refinement, sampling, ..decimated(factor) };
            let luma = rendered(&scene, 17);
            let view = LumaView::grey(&luma, WIDTH, HEIGHT).unwrap();
            let detect = |level| {
                let mut detector = Detector::new(&families, &settings).unwrap();
                detector.set_level(level);
                detector.detect(&view).to_vec()
            };
            let scalar = detect(Level::SCALAR);
            assert!(!scalar.is_empty());
            for level in Level::available() {
                assert_eq!(detect(level), scalar, "{level} at {factor} with {refinement:?}, {sampling:?}");
            }
        }
    }
}

#[test]
fn luma_inside_other_bytes_gives_the_same_tags_as_plain_grey() {
    let scene = scene(3);
    let families = families_of(&scene);
    let luma = rendered(&scene, 5);
    for factor in [1.0, 1.5, 2.0, 3.0] {
        let mut detector = Detector::new(&families, &decimated(factor)).unwrap();
        let plain = detector.detect(&LumaView::grey(&luma, WIDTH, HEIGHT).unwrap()).to_vec();
        for (pixel_step, offset, padding) in [(2, 0, 0), (2, 1, 32), (1, 7, 64), (3, 2, 5)] {
            let row_stride = WIDTH * pixel_step + padding;
            let mut bytes = vec![0xa5; offset + HEIGHT * row_stride];
            for (y, row) in luma.chunks_exact(WIDTH).enumerate() {
                for (x, value) in row.iter().enumerate() {
                    bytes[offset + y * row_stride + x * pixel_step] = *value;
                }
            }
            let geometry = Geometry { offset, width: WIDTH, height: HEIGHT, row_stride, pixel_step };
            let found = detector.detect(&LumaView::new(&bytes, geometry).unwrap());
            assert_eq!(found, plain, "step {pixel_step}, offset {offset}, factor {factor}");
        }
    }
}

#[test]
fn a_detector_forgets_the_frame_before() {
    let scene = scene(4);
    let families = families_of(&scene);
    let mut used = Detector::new(&families, &decimated(1.0)).unwrap();
    let noise: Vec<u8> = (0..1000 * 700u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    used.detect(&LumaView::grey(&noise, 1000, 700).unwrap());
    let luma = rendered(&scene, 9);
    let view = LumaView::grey(&luma, WIDTH, HEIGHT).unwrap();
    let fresh = Detector::new(&families, &decimated(1.0)).unwrap().detect(&view).to_vec();
    assert_eq!(used.detect(&view), fresh);
}

#[test]
fn only_allowed_ids_are_reported() {
    let scene = scene(1);
    let families = families_of(&scene);
    let wanted = scene.truth(0)[0].id;
    let settings = Settings { ids: vec![wanted], ..decimated(1.0) };
    let luma = rendered(&scene, 0);
    let mut detector = Detector::new(&families, &settings).unwrap();
    let found = detector.detect(&LumaView::grey(&luma, WIDTH, HEIGHT).unwrap());
    assert!(!found.is_empty() && found.iter().all(|tag| tag.id == wanted), "{found:?}");
}

/// Frames that are nothing but trouble.
fn hostile(kind: usize, width: usize, height: usize, random: &mut Stream) -> Vec<u8> {
    let pitch = 1 << (kind % 5);
    let pixel = |x: usize, y: usize, random: &mut Stream| match kind {
        0..5 => 255 * u8::from((x / pitch + y / pitch).is_multiple_of(2)),
        5 => 255 * u8::from((x / 2).is_multiple_of(2)),
        6 => 255 * u8::from((y / 2).is_multiple_of(2)),
        7 => random.bits() as u8,
        8 => (x + y) as u8,
        _ => 255 * u8::from((x ^ y) & 8 == 0),
    };
    (0..width * height).map(|i| pixel(i % width, i / width, random)).collect()
}

#[test]
fn hostile_frames_of_every_size_and_factor_are_survived() {
    let mut random = Stream::new(99);
    let families: Vec<Family> =
        Family::PUBLISHED.iter().map(|name| Family::published(name).unwrap()).collect();
    for factor in [1.0, 1.5, 2.0, 3.0, 7.0, 64.0, 128.0] {
        let settings = Settings { refinement: Refinement::Tag, ..decimated(factor) };
        let mut detector = Detector::new(&families, &settings).unwrap();
        for (width, height) in [(4, 4), (5, 300), (300, 5), (63, 64), (65, 129), (200, 150)] {
            for kind in 0..10 {
                let luma = hostile(kind, width, height, &mut random);
                detector.detect(&LumaView::grey(&luma, width, height).unwrap());
            }
        }
    }
}

#[test]
fn factors_that_are_not_possible_are_refused_with_what_is() {
    for factor in [0.0, 0.5, 2.5, 129.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = Decimation::from_factor(factor).unwrap_err().to_string();
        assert!(message.contains("1.5 or a whole number"), "{message}");
    }
}
