//! How exact corners are, and what that costs: random tags drawn by the scene room, whose corners are known.

mod drawn;
mod offsets;

use std::fmt::Write as _;

pub(crate) use drawn::Conditions;
use tagbus_detector::{Decimation, Detector, LumaView, Refinement, Settings};
use tagbus_family::{Border, Family};

use crate::accuracy::CornerErrors;
use crate::clock::cpu_us;
use crate::median::median;
use drawn::{Picture, Pictures};

/// Each picture is searched so often with each refinement, in turns; the quickest counts.
const ROUNDS: usize = 3;
/// Width of the tag that the cost of the alignment is promised for, pixels along the border.
const PROMISED_TAG_PX: f64 = 20.0;

/// What is measured.
pub(crate) struct Plan {
    pub(crate) families: Vec<Family>,
    pub(crate) factor: f64,
    /// Cell sizes, pixels.
    pub(crate) cells_px: Vec<f64>,
    pub(crate) conditions: Conditions,
}

/// One kind of refinement at one cell size.
struct Line {
    name: &'static str,
    detector: Detector,
    found: u64,
    errors: CornerErrors,
    cpu_us: Vec<f64>,
    /// What it took longer than the line before, on each picture.
    more_us: Vec<f64>,
}

/// Markdown tables: over families, cell sizes and refinements; and over families and factors.
pub(crate) fn tables(plan: &Plan) -> Result<String, Box<dyn std::error::Error>> {
    let mut text = String::from(
        "| family | border | px a cell | px a tag | refinement | found | RMS px | outwards px | right px | down px | worst px \
         | CPU median us | alignment us |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for family in &plan.families {
        let width = family.layout().width_at_border() as f64;
        let mut cells_px = plan.cells_px.clone();
        cells_px.push(PROMISED_TAG_PX / width);
        cells_px.sort_by(f64::total_cmp);
        cells_px.dedup();
        for cell_px in cells_px {
            for line in measure(plan, family, cell_px)? {
                let row = line.row(plan.conditions.pictures);
                let (name, border) = (family.name(), border_of(family));
                writeln!(text, "| {name} | {border} | {cell_px} | {:.0} | {row}", cell_px * width)?;
            }
        }
    }
    Ok(text + &offsets::table(&plan.conditions, &plan.families)?)
}

fn border_of(family: &Family) -> &'static str {
    match family.layout().border() {
        Border::Normal => "normal",
        Border::Reversed => "reversed",
    }
}

fn measure(plan: &Plan, family: &Family, cell_px: f64) -> Result<Vec<Line>, Box<dyn std::error::Error>> {
    let mut lines = Vec::new();
    for (refinement, name) in Refinement::NAMES {
        let decimation = Decimation::from_factor(plan.factor)?;
        let settings = Settings { decimation, refinement, ..Settings::default() };
        lines.push(Line::new(name, Detector::new(std::slice::from_ref(family), &settings)?));
    }
    let mut pictures = Pictures::new(&plan.conditions, family, cell_px);
    for _ in 0..plan.conditions.pictures {
        search(&pictures.next()?, &mut lines)?;
    }
    Ok(lines)
}

/// Searches a picture with every refinement.
fn search(picture: &Picture, lines: &mut [Line]) -> Result<(), Box<dyn std::error::Error>> {
    let view = LumaView::grey(&picture.luma, picture.side, picture.side)?;
    let mut quickest = vec![f64::MAX; lines.len()];
    for _ in 0..ROUNDS {
        for (line, quickest) in lines.iter_mut().zip(&mut quickest) {
            let (us, ()) = cpu_us(|| {
                line.detector.detect(&view);
            });
            *quickest = quickest.min(us);
        }
    }
    let mut before = 0.0;
    for (line, us) in lines.iter_mut().zip(quickest) {
        line.cpu_us.push(us);
        line.more_us.push(us - before);
        before = us;
        if let Some(tag) = line.detector.detect(&view).iter().find(|tag| tag.id == picture.id) {
            line.found += 1;
            line.errors.add(&tag.corners, &picture.truth);
        }
    }
    Ok(())
}

impl Line {
    fn new(name: &'static str, detector: Detector) -> Self {
        let (cpu_us, more_us) = (Vec::new(), Vec::new());
        Self { name, detector, found: 0, errors: CornerErrors::default(), cpu_us, more_us }
    }

    fn row(self, pictures: u64) -> String {
        let alignment = match self.name {
            "tag" => format!("{:.0}", median(self.more_us.iter().copied())),
            _ => String::new(),
        };
        let Self { name, found, errors, .. } = self;
        format!(
            "{name} | {found}/{pictures} | {:.3} | {:+.3} | {:+.3} | {:+.3} | {:.2} | {:.0} | {alignment} |",
            errors.rms(),
            errors.outwards(),
            errors.right(),
            errors.down(),
            errors.worst(),
            median(self.cpu_us.iter().copied()),
        )
    }
}
