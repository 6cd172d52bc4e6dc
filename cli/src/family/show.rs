//! `tagbus family show`: one family's layout and sizes.

use std::io::{self, Write};

use serde::Serialize;
use tagbus_family::{Border, Cell, Family, Layout};

use super::draw;
use super::list::Summary;
use crate::outcome::{Failure, Outcome};
use crate::output::Reader;

/// The print whose tag size is told, in millimetres.
const SAMPLE_PRINT_MM: f64 = 100.0;

#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    summary: Summary<'a>,
    shape: &'static str,
    /// Cells along the hole that another tag fits into, 0 for none.
    hole_cells: usize,
    /// Rows of the layout: w white, b black, d data, x not part of the tag.
    layout: Vec<String>,
}

/// Writes the family, or a line of JSON.
pub(super) fn execute(family: &Family, json: bool) -> Result<Outcome, Failure> {
    let mut out = io::stdout().lock();
    if !json {
        out.write_all(page(family, Reader::of_stdout()).as_bytes())?;
        return Ok(Outcome::Done);
    }
    let layout = family.layout();
    let shown = Shown {
        summary: Summary::of(family),
        shape: shape(layout),
        hole_cells: layout.hole_width(),
        layout: draw::letters(layout),
    };
    writeln!(out, "{}", serde_json::to_string(&shown)?)?;
    Ok(Outcome::Done)
}

fn page(family: &Family, reader: Reader) -> String {
    let layout = family.layout();
    let mut lines = vec![
        format!(
            "{}: {} tags of {} bits, at least {} bits apart; {} wrong bits are corrected by default",
            reader.bold(family.name()),
            family.codes().len(),
            layout.bit_count(),
            family.distance(),
            family.default_hamming()
        ),
        String::new(),
    ];
    lines.extend(draw::layout(layout).into_iter().map(|row| format!("  {row}")));
    lines.push(reader.faint("  ## black   .. white   [] data   blank: not part of the tag"));
    lines.extend([String::new(), sizes(layout), border(layout), format!("shape: {}", shape(layout))]);
    lines.extend(hole(layout));
    lines.join("\n") + "\n"
}

fn sizes(layout: &Layout) -> String {
    let (tag, printed) = (layout.width_at_border(), layout.total_width());
    let tag_mm = SAMPLE_PRINT_MM * tag as f64 / printed as f64;
    format!(
        "tag size: {tag} of the {printed} cells of the print; a print of {SAMPLE_PRINT_MM} mm has a tag size of {tag_mm:.1} mm"
    )
}

fn border(layout: &Layout) -> String {
    let sides = match layout.border() {
        Border::Normal => "normal: white outside the border edge, black inside",
        Border::Reversed => "reversed: black outside the border edge, white inside",
    };
    format!("border: {sides}")
}

fn shape(layout: &Layout) -> &'static str {
    if is_round(layout) { "round" } else { "square" }
}

/// A print whose corners are not painted is round.
pub(super) fn is_round(layout: &Layout) -> bool {
    let first = -(layout.margin() as i32);
    layout.cell(first, first) == Cell::Ignored
}

fn hole(layout: &Layout) -> Option<String> {
    let width = layout.hole_width();
    (width > 0).then(|| {
        let share = width as f64 / layout.total_width() as f64;
        let print_mm = SAMPLE_PRINT_MM * share;
        format!(
            "hole: {width}x{width} cells in the middle; in a print of {SAMPLE_PRINT_MM} mm another tag of {print_mm:.1} mm fits into it"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(name: &str) -> String {
        page(&Family::published(name).unwrap(), Reader::Program)
    }

    #[test]
    fn sizes_name_both_edges() {
        assert!(shown("tagStandard41h12").contains("a print of 100 mm has a tag size of 55.6 mm"));
        assert!(shown("tag36h11").contains("8 of the 10 cells"));
    }

    #[test]
    fn holes_and_round_prints_are_told() {
        let custom = shown("tagCustom48h12");
        assert!(custom.contains("hole: 2x2 cells") && custom.contains("shape: square"), "{custom}");
        let round = shown("tagCircle21h7");
        assert!(!round.contains("hole:") && round.contains("shape: round"), "{round}");
    }
}
