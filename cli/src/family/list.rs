//! `tagbus family list`: the published families side by side, first ours, then those of others.

use std::io::{self, Write};

use serde::Serialize;
use tagbus_family::{Border, Family};

use crate::outcome::{Failure, Outcome};
use crate::output::Reader;
use crate::tag_json::rounded;

const HEADING: &str =
    "name                    codes  distance  bits  tag size / printed size  border    corrected by default";
const HEADING_OF_OTHERS: &str = "Of others (ArUco as OpenCV names it, the tags of Kalibr's Aprilgrid):";

/// What the table says about a family.
#[derive(Debug, Serialize)]
pub(super) struct Summary<'a> {
    name: &'a str,
    codes: usize,
    distance: u32,
    bits: u32,
    tag_cells: usize,
    printed_cells: usize,
    /// The tag size divided by the printed size.
    ratio: f64,
    border: &'static str,
    corrected_by_default: u32,
}

impl<'a> Summary<'a> {
    pub(super) fn of(family: &'a Family) -> Self {
        let layout = family.layout();
        let (tag_cells, printed_cells) = (layout.width_at_border(), layout.total_width());
        Self {
            name: family.name(),
            codes: family.codes().len(),
            distance: family.distance(),
            bits: layout.bit_count(),
            tag_cells,
            printed_cells,
            ratio: rounded(tag_cells as f64 / printed_cells as f64, 4),
            border: border_name(layout.border()),
            corrected_by_default: family.default_hamming(),
        }
    }

    fn row(&self) -> String {
        let Self { name, codes, distance, bits, border, .. } = self;
        let cells = format!("{}/{}", self.tag_cells, self.printed_cells);
        let ratio = format!("{cells:>5} cells = {:.3}", self.ratio);
        format!(
            "{name:<22}{codes:>7}  {distance:>8}  {bits:>4}  {ratio:<23}  {border:<8}  {}",
            self.corrected_by_default
        )
    }
}

/// `normal` is black inside the border edge, `reversed` white inside.
pub(super) fn border_name(border: Border) -> &'static str {
    match border {
        Border::Normal => "normal",
        Border::Reversed => "reversed",
    }
}

/// Writes two tables, or a line of JSON a family.
pub(super) fn execute(json: bool) -> Result<Outcome, Failure> {
    let mut out = io::stdout().lock();
    let reader = Reader::of_stdout();
    if json {
        write_lines(&Family::PUBLISHED, json, &mut out)?;
        write_lines(&Family::OTHERS, json, &mut out)?;
        return Ok(Outcome::Done);
    }
    writeln!(out, "{}", reader.bold(HEADING))?;
    write_lines(&Family::PUBLISHED, json, &mut out)?;
    writeln!(out, "\n{}", reader.bold(HEADING_OF_OTHERS))?;
    write_lines(&Family::OTHERS, json, &mut out)?;
    Ok(Outcome::Done)
}

fn write_lines(names: &[&str], json: bool, out: &mut impl Write) -> Result<(), Failure> {
    for name in names {
        let family = Family::published(name)?;
        let summary = Summary::of(&family);
        let line = if json { serde_json::to_string(&summary)? } else { summary.row() };
        writeln!(out, "{line}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_below_their_headings() {
        let family = Family::published("tagStandard41h12").unwrap();
        let row = Summary::of(&family).row();
        assert_eq!(
            row,
            "tagStandard41h12         2115        12    41    5/9 cells = 0.556      reversed  2"
        );
        assert_eq!(row.find("reversed"), HEADING.find("border"));
    }

    #[test]
    fn names_of_every_family_leave_room_for_the_codes_and_fit_into_messages() {
        for name in Family::PUBLISHED.iter().chain(&Family::OTHERS) {
            assert!(name.len() < 22, "{name}");
            assert!(name.len() <= tagbus_message::detection::FAMILY_NAME_BYTES, "{name}");
        }
    }
}
