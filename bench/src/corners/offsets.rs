//! Whether decimation shifts corners: mean errors to the right and down of corners that were not refined.

use std::fmt::Write as _;

use tagbus_detector::{Decimation, Detector, LumaView, Refinement, Settings};
use tagbus_family::Family;

use super::drawn::{Conditions, Pictures};
use crate::accuracy::Offsets;

const FACTORS: [f64; 9] = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// Cells of the tags, in pixels of the search grid and at least in pixels of the picture.
const CELL_PX: (f64, f64) = (2.5, 5.0);

/// A Markdown table over families and factors.
pub(super) fn table(
    conditions: &Conditions,
    families: &[Family],
) -> Result<String, Box<dyn std::error::Error>> {
    let mut text = String::from(
        "\nCorners without refinement, mean over all corners and its standard error, pixels of the full picture:\n\n\
         | family | border | decimation | px a cell | found | right px | +- | down px | +- |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for family in families {
        for factor in FACTORS {
            let cell_px = (CELL_PX.0 * factor).max(CELL_PX.1);
            let (found, offsets) = measure(conditions, family, factor, cell_px)?;
            let [(right, right_error), (down, down_error)] = [offsets.right(), offsets.down()];
            writeln!(
                text,
                "| {} | {} | {factor} | {cell_px} | {found}/{} | {right:+.4} | {right_error:.4} | {down:+.4} | {down_error:.4} |",
                family.name(),
                super::border_of(family),
                conditions.pictures,
            )?;
        }
    }
    Ok(text)
}

fn measure(
    conditions: &Conditions,
    family: &Family,
    factor: f64,
    cell_px: f64,
) -> Result<(u64, Offsets), Box<dyn std::error::Error>> {
    let decimation = Decimation::from_factor(factor)?;
    let settings = Settings { decimation, refinement: Refinement::None, ..Settings::default() };
    let mut detector = Detector::new(std::slice::from_ref(family), &settings)?;
    let mut pictures = Pictures::new(conditions, family, cell_px);
    let (mut found, mut offsets) = (0, Offsets::default());
    for _ in 0..conditions.pictures {
        let picture = pictures.next()?;
        let view = LumaView::grey(&picture.luma, picture.side, picture.side)?;
        if let Some(tag) = detector.detect(&view).iter().find(|tag| tag.id == picture.id) {
            found += 1;
            offsets.add(&tag.corners, &picture.truth);
        }
    }
    Ok((found, offsets))
}
