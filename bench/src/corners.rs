//! How exact corners are: random tags drawn by the scene room, whose corners are known.

use std::fmt::Write as _;

use tagbus_detector::{Decimation, Detector, LumaView, Refinement, Settings};
use tagbus_family::Family;
use tagbus_scene::{
    Homography, Photo, Placement, Stream, Tag, Turn, View, corners_of, homography_of, photograph,
};

use crate::accuracy::CornerErrors;
use crate::clock::cpu_us;

/// Cell sizes that are tried, pixels.
const CELL_PX: [f64; 5] = [2.0, 3.0, 5.0, 9.0, 20.0];
/// A camera with a lens of normal width at 1280 pixels.
const FOCAL_PX: f64 = 800.0;

/// What is drawn.
pub(crate) struct Conditions {
    pub(crate) families: Vec<Family>,
    pub(crate) factor: f64,
    pub(crate) pictures: u64,
    pub(crate) blur_sigma: f32,
    pub(crate) noise_sigma: f32,
    pub(crate) seed: u64,
}

/// Results of one family at one cell size.
#[derive(Default)]
struct Results {
    found: u64,
    errors: CornerErrors,
    cpu_us: Vec<f64>,
}

/// A Markdown table over families, cell sizes and refinements.
pub(crate) fn table(conditions: &Conditions) -> Result<String, Box<dyn std::error::Error>> {
    let mut text = String::from(
        "| family | px a cell | refinement | found | RMS px | outwards px | right px | down px | worst px | CPU median us |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for family in &conditions.families {
        for cell_px in CELL_PX {
            for (refinement, name) in Refinement::NAMES {
                let results = measure(conditions, family, cell_px, refinement)?;
                writeln!(
                    text,
                    "| {} | {cell_px} | {name} | {}",
                    family.name(),
                    results.row(conditions.pictures)
                )?;
            }
        }
    }
    Ok(text)
}

fn measure(
    conditions: &Conditions,
    family: &Family,
    cell_px: f64,
    refinement: Refinement,
) -> Result<Results, Box<dyn std::error::Error>> {
    let decimation = Decimation::from_factor(conditions.factor)?;
    let settings = Settings { decimation, refinement, ..Settings::default() };
    let mut detector = Detector::new(std::slice::from_ref(family), &settings)?;
    // The same pictures for every refinement.
    let mut random = Stream::new(conditions.seed ^ cell_px.to_bits());
    let mut results = Results::default();
    for _ in 0..conditions.pictures {
        let side = (family.layout().total_width() as f64 * cell_px * 1.6) as usize + 60;
        let homography = random_place(family, cell_px, side, &mut random);
        let id = random.below(family.codes().len() as u64) as u32;
        let photo = Photo {
            width: side,
            height: side,
            blur_sigma: conditions.blur_sigma,
            noise_sigma: conditions.noise_sigma,
            seed: random.bits(),
            ..Photo::default()
        };
        let luma = photograph(&photo, &[Placement::new(Tag::new(family, id)?, homography)]);
        let view = LumaView::grey(&luma, side, side)?;
        let (us, tag) = cpu_us(|| detector.detect(&view).iter().find(|tag| tag.id == id).copied());
        results.cpu_us.push(us);
        if let Some(tag) = tag {
            results.found += 1;
            results.errors.add(&tag.corners, &corners_of(&homography));
        }
    }
    Ok(results)
}

fn random_place(family: &Family, cell_px: f64, side: usize, random: &mut Stream) -> Homography {
    let middle = side as f64 * 0.5;
    let centre = [middle + random.between(-2.0, 2.0), middle + random.between(-2.0, 2.0)];
    let turn = Turn {
        rotation_rad: random.between(0.0, std::f64::consts::TAU),
        tilt_rad: random.between(0.0, 30f64.to_radians()),
        tilt_direction_rad: random.between(0.0, std::f64::consts::TAU),
    };
    homography_of(family.layout(), &View { centre, cell_px, turn, focal_px: FOCAL_PX })
}

impl Results {
    fn row(mut self, pictures: u64) -> String {
        self.cpu_us.sort_by(f64::total_cmp);
        let median = self.cpu_us.get(self.cpu_us.len() / 2).copied().unwrap_or(0.0);
        let Self { found, errors, .. } = self;
        format!(
            "{found}/{pictures} | {:.3} | {:+.3} | {:+.3} | {:+.3} | {:.2} | {median:.0} |",
            errors.rms(),
            errors.outwards(),
            errors.right(),
            errors.down(),
            errors.worst()
        )
    }
}
