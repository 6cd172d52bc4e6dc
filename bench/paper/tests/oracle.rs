//! The paper's pipeline as an oracle: what it finds, the product finds too, in the same place.

use tagbus_detector::{Decimation, Detector, LumaView, Settings};
use tagbus_family::Family;
use tagbus_paper::{Detection, Options, Picture, Pipeline};
use tagbus_scene::{
    Background, Photo, Placement, Scene, SceneConfig, Stream, Tag, TrueTag, Turn, View, homography_of,
    photograph,
};

/// Shorter sides are left out: there both are worth a fraction of a pixel, in ways of their own.
const MIN_SIDE_PX: f64 = 20.0;
/// How far corners of both may be apart.
const MAX_OFF_PX: f64 = 0.5;

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx).hypot(ay - by)
}

fn shortest_side(corners: &[[f64; 2]; 4]) -> f64 {
    (0..4).map(|k| distance(corners[k], corners[(k + 1) % 4])).fold(f64::MAX, f64::min)
}

fn farthest_apart(a: &[[f64; 2]; 4], b: &[[f64; 2]; 4]) -> f64 {
    (0..4).map(|k| distance(a[k], b[k])).fold(0.0, f64::max)
}

/// Both detectors for the same families at the same decimation.
struct Both {
    families: Vec<Family>,
    paper: Pipeline,
    product: Detector,
}

impl Both {
    fn new(families: Vec<Family>, factor: u32) -> Both {
        let options = Options { decimation: factor as usize, ..Options::default() };
        let settings = Settings { decimation: Decimation::Every(factor), ..Settings::default() };
        let paper = Pipeline::new(&families, options).expect("possible options");
        let product = Detector::new(&families, &settings).expect("possible settings");
        Both { families, paper, product }
    }

    /// Holds the product against the pipeline on one picture; returns what the pipeline found that is large enough.
    fn check(&mut self, width: usize, height: usize, luma: Vec<u8>, name: &str) -> Vec<Detection> {
        let view = LumaView::grey(&luma, width, height).expect("one grey level a pixel");
        let found = self.product.detect(&view).to_vec();
        let picture = Picture::new(width, height, luma).expect("one grey level a pixel");
        let mut expected = self.paper.detect(&picture).detections;
        // Codes that the product does not trust with so many wrong bits are none of this test.
        let trusted: Vec<u32> = self.product.hamming().collect();
        expected
            .retain(|tag| shortest_side(&tag.corners) > MIN_SIDE_PX && tag.hamming <= trusted[tag.family]);
        for tag in &expected {
            let same = found.iter().filter(|other| (other.family, other.id) == (tag.family, tag.id));
            let off = same.map(|other| farthest_apart(&tag.corners, &other.corners)).fold(f64::MAX, f64::min);
            let family = self.families[tag.family].name();
            assert!(
                off < MAX_OFF_PX,
                "{name}: {family} {} of the pipeline is {off:.3} px away: {tag:?}",
                tag.id
            );
        }
        expected
    }

    /// How many of the tags that are there are among those found.
    fn right(&self, found: &[Detection], truth: &[TrueTag]) -> usize {
        let is_there = |tag: &&Detection| {
            truth.iter().any(|true_tag| {
                true_tag.id == tag.id
                    && true_tag.family == self.families[tag.family].name()
                    && farthest_apart(&true_tag.corners, &tag.corners) < 1.0
            })
        };
        found.iter().filter(is_there).count()
    }
}

#[test]
fn the_product_finds_what_the_paper_finds_in_a_moving_scene_with_nested_tags_of_many_families() {
    let (width, height) = (640, 480);
    for seed in 1..4 {
        let scene = Scene::new(SceneConfig { width, height, seed, ..SceneConfig::default() }).unwrap();
        let mut names: Vec<String> = scene.truth(0).into_iter().map(|tag| tag.family).collect();
        names.sort();
        names.dedup();
        let families: Vec<Family> = names.iter().map(|name| Family::published(name).unwrap()).collect();
        for factor in [1, 2] {
            let mut both = Both::new(families.clone(), factor);
            let (mut found, mut right) = (0, 0);
            for frame in (0..400).step_by(40) {
                let mut luma = vec![0; width * height];
                scene.render(frame, &mut luma);
                let tags =
                    both.check(width, height, luma, &format!("seed {seed}, frame {frame}, by {factor}"));
                found += tags.len();
                right += both.right(&tags, &scene.truth(frame));
            }
            assert_eq!(found, right, "seed {seed}, by {factor}: the pipeline sees what is not there");
            assert!(found >= 40, "seed {seed}, by {factor}: only {found} tags in ten frames");
        }
    }
}

#[test]
fn the_product_finds_what_the_paper_finds_in_noise_blur_tilt_and_a_full_room() {
    for (name, least) in [("tag36h11", 150), ("tagStandard41h12", 150)] {
        let family = Family::published(name).unwrap();
        let mut both = Both::new(vec![family.clone()], 1);
        let (mut found, mut right) = (0, 0);
        for seed in 0..200 {
            let (placement, photo) = random_picture(&family, seed);
            let truth = placement.truth(photo.width, photo.height);
            let luma = photograph(&photo, &[placement]);
            let tags = both.check(photo.width, photo.height, luma, &format!("{name}, seed {seed}"));
            found += tags.len();
            right += both.right(&tags, &truth);
        }
        assert_eq!(found, right, "{name}: the pipeline sees what is not there");
        assert!(found >= least, "{name}: only {found} tags in 200 pictures");
    }
}

/// A tag of 3 to 12 pixels a cell, tilted up to 50 degrees, in a room of its own.
fn random_picture(family: &Family, seed: u64) -> (Placement, Photo) {
    let mut random = Stream::new(seed);
    let turn = Turn {
        rotation_rad: random.between(0.0, 7.0),
        tilt_rad: random.between(0.0, 0.87),
        tilt_direction_rad: random.between(0.0, 7.0),
    };
    let view = View {
        centre: [random.between(110.0, 210.0), random.between(100.0, 140.0)],
        cell_px: random.between(3.0, 12.0),
        turn,
        ..View::default()
    };
    let id = random.below(family.codes().len() as u64) as u32;
    let tag = Tag::new(family, id).expect("the id is below the number of codes");
    let photo = Photo {
        width: 320,
        height: 240,
        background: Background::FullRoom,
        blur_sigma: random.between(0.3, 0.9) as f32,
        noise_sigma: random.between(0.0, 5.0) as f32,
        seed,
        ..Photo::default()
    };
    (Placement::new(tag, homography_of(family.layout(), &view)), photo)
}
