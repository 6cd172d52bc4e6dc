//! Blocks on paper, with cut marks, captions and a ruler to check the printer with.
//!
//! ```text
//!      |          |         cut marks, outside the tag; a circle for round tags
//!    --+----------+--
//!      |          |
//!      |   tag    |
//!    --+----------+--
//!      |          |
//!      ↑ tag36h11 id 7
//!      tag size 80 mm, printed size 100 mm
//!    |..|..|..|..|..|..|..|..|..|..|  100 mm
//! ```

use super::block::{Block, Cut};
use super::length::short;
use super::page::{Ink, Mark, Outlines, Page, Pattern};
use super::paper::Paper;
use std::fmt;

/// Along the paper's edges nothing but the outer cut marks is printed: printers leave up to 4.2 mm white.
const PAGE_MARGIN: f64 = 5.0;
/// From the corner of a block to where its cut marks begin.
const MARK_GAP: f64 = 1.0;
const MARK_LENGTH: f64 = 3.0;
/// Between a block and what is next to it.
const MARK_ROOM: f64 = MARK_GAP + MARK_LENGTH;
/// The ruler with its text.
const RULER_ROOM: f64 = 10.0;
/// Lines of cut marks and of the ruler.
const LINE_WIDTH: f64 = 0.15;
/// The captions' font; it shrinks with the tag down to what can just be read.
const LARGEST_FONT: f64 = 3.0;
const SMALLEST_FONT: f64 = 0.8;
/// From one line of text to the next, in sizes of the font.
const LINE_PITCH: f64 = 1.25;
/// Width of a letter in sizes of the font; that of Helvetica's digits, wider than its mean.
const LETTER_WIDTH: f64 = 0.56;
/// Room for the arrow before the first line, in sizes of the font.
const ARROW_ROOM: f64 = 1.2;

/// A page as large as the block, with nothing else on it.
pub fn bare(block: &Block) -> Page {
    Page { size: block.size, marks: block.patterns.iter().cloned().map(Mark::Pattern).collect() }
}

/// Pages with as many blocks as fit, `per_page` at most. The blocks are of one size.
///
/// # Errors
/// [`SheetError`] with the numbers when a block, or `per_page` of them, do not fit.
pub fn pages(blocks: &[Block], paper: &Paper, per_page: Option<usize>) -> Result<Vec<Page>, SheetError> {
    let Some(first) = blocks.first() else { return Ok(Vec::new()) };
    let slot = Slot::of(blocks, first);
    let [columns, rows] = slot.fitting(paper);
    let most = columns * rows;
    if most == 0 {
        return Err(too_large(first, &slot, paper));
    }
    match per_page {
        Some(asked) if asked > most || asked == 0 => {
            Err(SheetError::PerPage { asked, most, paper: paper.to_string() })
        }
        _ => {
            let count = per_page.unwrap_or(most);
            Ok(blocks.chunks(count).map(|blocks| page(blocks, &slot, columns, paper)).collect())
        }
    }
}

/// The place of a block with its caption.
struct Slot {
    /// Of what the cut line encloses.
    reach: [f64; 2],
    /// With the caption, but without the room around.
    size: [f64; 2],
    font: f64,
}

impl Slot {
    fn of(blocks: &[Block], first: &Block) -> Slot {
        let letters = blocks.iter().flat_map(|block| &block.caption).map(|line| line.chars().count());
        let em = letters.max().unwrap_or(0) as f64 * LETTER_WIDTH + ARROW_ROOM;
        let reach = first.reach();
        let font = (reach[0] / em).clamp(SMALLEST_FONT, LARGEST_FONT);
        Slot { reach, size: [reach[0].max(font * em), reach[1] + caption_room(font)], font }
    }

    fn pitch(&self) -> [f64; 2] {
        [self.size[0] + 2.0 * MARK_ROOM, self.size[1] + 2.0 * MARK_ROOM]
    }

    /// Columns and rows that fit; the marks of the outer ones may be in the page's margin.
    fn fitting(&self, paper: &Paper) -> [usize; 2] {
        let (free, pitch) = (free(paper), self.pitch());
        // A hair more, so that what fits exactly does so in floating-point numbers, too.
        std::array::from_fn(|axis| ((free[axis] + 2.0 * MARK_ROOM + 1e-6) / pitch[axis]).max(0.0) as usize)
    }
}

/// Below a block: its cut marks and two lines of text.
fn caption_room(font: f64) -> f64 {
    MARK_ROOM + 2.0 * LINE_PITCH * font
}

/// The paper without its margins and the ruler.
fn free(paper: &Paper) -> [f64; 2] {
    let [width, height] = paper.size;
    [width - 2.0 * PAGE_MARGIN, height - 2.0 * PAGE_MARGIN - RULER_ROOM]
}

fn too_large(block: &Block, slot: &Slot, paper: &Paper) -> SheetError {
    let (free, reach) = (free(paper), slot.reach);
    let growing = block.prints;
    let fixed: [f64; 2] = std::array::from_fn(|axis| reach[axis] - growing[axis]);
    let room = [free[0] - fixed[0], free[1] - fixed[1] - caption_room(LARGEST_FONT)];
    let factor = (room[0] / growing[0]).min(room[1] / growing[1]);
    let tag_mm = block.tags.first().map_or(0.0, |tag| tag.tag_mm);
    SheetError::TooLarge {
        tag_mm,
        block: reach,
        paper: paper.to_string(),
        free: [free[0], free[1] - caption_room(slot.font)],
        // Rounded down to tenths, so that what is named fits.
        largest_mm: (tag_mm * factor.max(0.0) * 10.0).floor() / 10.0,
    }
}

fn page(blocks: &[Block], slot: &Slot, columns: usize, paper: &Paper) -> Page {
    let (free, pitch) = (free(paper), slot.pitch());
    let counts = [columns.min(blocks.len()), blocks.len().div_ceil(columns)];
    let first: [f64; 2] = std::array::from_fn(|axis| {
        let used = pitch[axis] * counts[axis] as f64 - 2.0 * MARK_ROOM;
        PAGE_MARGIN + (free[axis] - used) / 2.0
    });
    let mut marks = Vec::new();
    for (place, block) in blocks.iter().enumerate() {
        let at = [place % columns, place / columns];
        let [x, y]: [f64; 2] = std::array::from_fn(|axis| first[axis] + pitch[axis] * at[axis] as f64);
        add_block(&mut marks, block, slot, [x + (slot.size[0] - slot.reach[0]) / 2.0, y]);
    }
    add_ruler(&mut marks, paper);
    Page { size: paper.size, marks }
}

/// A block whose reach begins `at` this point.
fn add_block(marks: &mut Vec<Mark>, block: &Block, slot: &Slot, at: [f64; 2]) {
    let inset: [f64; 2] = std::array::from_fn(|axis| (slot.reach[axis] - block.size[axis]) / 2.0);
    let origin = [at[0] + inset[0], at[1] + inset[1]];
    marks.extend(block.patterns.iter().map(|pattern| Mark::Pattern(pattern.moved(origin))));
    match block.cut {
        Cut::Straight => add_cut_marks(marks, origin, block.size),
        Cut::Round { radius } => marks.push(Mark::Circle {
            centre: [at[0] + slot.reach[0] / 2.0, at[1] + slot.reach[1] / 2.0],
            radius,
            width: LINE_WIDTH,
            ink: Ink::Grey,
        }),
    }
    let x = at[0] - (slot.size[0] - slot.reach[0]) / 2.0;
    let base = at[1] + slot.reach[1] + MARK_ROOM + slot.font;
    marks.push(Mark::Pattern(arrow([x, base], slot.font)));
    for (line, text) in block.caption.iter().enumerate() {
        let indent = if line == 0 { ARROW_ROOM * slot.font } else { 0.0 };
        let at = [x + indent, base + LINE_PITCH * slot.font * line as f64];
        marks.push(Mark::Text { at, size: slot.font, text: text.clone() });
    }
}

/// An arrow up, as high as capital letters are, which stands on the point `at`.
fn arrow([x, y]: [f64; 2], font: f64) -> Pattern {
    let step_mm = 0.72 * font / 8.0;
    let loops = vec![vec![[4, 0], [8, 4], [5, 4], [5, 8], [3, 8], [3, 4], [0, 4]]];
    let part = Outlines { origin: [x, y - 8.0 * step_mm], step_mm, loops };
    Pattern { parts: vec![part], ink: Ink::Black }
}

fn add_cut_marks(marks: &mut Vec<Mark>, [left, top]: [f64; 2], [width, height]: [f64; 2]) {
    for (x, away_x) in [(left, -1.0), (left + width, 1.0)] {
        for (y, away_y) in [(top, -1.0), (top + height, 1.0)] {
            let [near, far] = [MARK_GAP, MARK_GAP + MARK_LENGTH];
            marks.push(line([x + away_x * near, y], [x + away_x * far, y], Ink::Grey));
            marks.push(line([x, y + away_y * near], [x, y + away_y * far], Ink::Grey));
        }
    }
}

fn line(from: [f64; 2], to: [f64; 2], ink: Ink) -> Mark {
    Mark::Line { from, to, width: LINE_WIDTH, ink }
}

/// A ruler of 100 mm, or on narrow paper of what fits.
fn add_ruler(marks: &mut Vec<Mark>, paper: &Paper) {
    let [width, height] = paper.size;
    let fits = |length: &f64| *length <= width - 2.0 * PAGE_MARGIN;
    let Some(length) = [100.0, 50.0, 20.0, 10.0].into_iter().find(fits) else { return };
    let (x, y) = ((width - length) / 2.0, height - PAGE_MARGIN - 1.0);
    marks.push(line([x, y], [x + length, y], Ink::Black));
    for tick in 0..=(length / 10.0) as usize {
        let at = x + 10.0 * tick as f64;
        marks.push(line([at, y], [at, y - 2.0], Ink::Black));
    }
    let wide = format!("{length} mm: if it measures otherwise, print without scaling (100 %)");
    let text = if length > 60.0 { wide } else { format!("{length} mm") };
    let size = 2.5;
    marks.push(Mark::Text { at: [x, y - 3.0], size, text });
}

/// Why blocks cannot be laid out.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SheetError {
    /// One alone does not fit.
    TooLarge {
        /// The tag size asked for.
        tag_mm: f64,
        /// Width and height of what is cut out.
        block: [f64; 2],
        /// The paper.
        paper: String,
        /// What of it is free for tags.
        free: [f64; 2],
        /// The largest tag size that fits, 0 for none.
        largest_mm: f64,
    },
    /// So many do not fit.
    PerPage {
        /// How many were asked for.
        asked: usize,
        /// How many fit.
        most: usize,
        /// The paper.
        paper: String,
    },
}

impl fmt::Display for SheetError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SheetError::TooLarge { tag_mm, block, paper, free, largest_mm } => {
                let ([width, height], [free_width, free_height]) = (block.map(short), free.map(short));
                write!(
                    out,
                    "a tag of {} mm, printed {width} x {height} mm, does not fit on {paper}, of which {free_width} x {free_height} mm \
                     are free beside margins, caption and ruler: the largest tag size is {largest_mm} mm; take that or larger paper",
                    short(*tag_mm)
                )
            }
            SheetError::PerPage { asked, most, paper } => {
                write!(
                    out,
                    "{asked} a page are asked for, but {paper} holds {most} of this size: take from 1 to that many, or larger paper"
                )
            }
        }
    }
}

impl std::error::Error for SheetError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::Family;
    use crate::print::{Length, Size};

    fn blocks(name: &str, count: u32, size: &str) -> Vec<Block> {
        let family = Family::published(name).unwrap();
        let size = Size::Tag(size.parse().unwrap());
        (0..count).map(|id| Block::tag(&family, id, size, Length::ZERO).unwrap()).collect()
    }

    fn laid_out(
        name: &str,
        count: u32,
        size: &str,
        per_page: Option<usize>,
    ) -> Result<Vec<Page>, SheetError> {
        pages(&blocks(name, count, size), &"a4".parse().unwrap(), per_page)
    }

    #[test]
    fn a_tag_of_160_mm_with_a_white_ring_fits_on_a4_and_one_with_data_outside_is_refused_with_the_largest() {
        assert_eq!(laid_out("tag36h11", 2, "160mm", None).unwrap().len(), 2);
        let message = laid_out("tagStandard41h12", 1, "160mm", None).unwrap_err().to_string();
        assert!(
            message.contains("288 x 288") && message.contains("the largest tag size is 111.1 mm"),
            "{message}"
        );
    }

    #[test]
    fn the_largest_size_that_is_named_fits_and_little_more_does_not() {
        for name in ["tag16h5", "tagStandard41h12", "tagCircle21h7", "tagCustom48h12"] {
            let Err(SheetError::TooLarge { largest_mm, .. }) = laid_out(name, 1, "900mm", None) else {
                panic!("{name} fits")
            };
            assert!(laid_out(name, 1, &format!("{largest_mm}mm"), None).is_ok(), "{name}: {largest_mm}");
            let more = format!("{}mm", largest_mm + 1.0);
            assert!(laid_out(name, 1, &more, None).is_err(), "{name}: {more}");
        }
    }

    #[test]
    fn blocks_are_spread_over_pages() {
        assert_eq!(laid_out("tag36h11", 7, "30mm", Some(3)).unwrap().len(), 3);
        let message = laid_out("tag36h11", 7, "150mm", Some(3)).unwrap_err().to_string();
        assert!(
            message.contains("3 a page are asked for, but A4 (210 x 297 mm) holds 1 of this size"),
            "{message}"
        );
        assert!(laid_out("tag36h11", 7, "30mm", Some(0)).is_err());
    }

    #[test]
    fn nothing_but_text_leaves_the_paper_and_no_two_tags_touch() {
        for (name, size) in [("tag36h11", "12mm"), ("tagCircle49h12", "9mm"), ("tagStandard52h13", "50mm")] {
            for page in laid_out(name, 40, size, None).unwrap() {
                let mut boxes: Vec<[f64; 4]> = Vec::new();
                for mark in &page.marks {
                    let Mark::Pattern(pattern) = mark else { continue };
                    let points: Vec<[f64; 2]> = pattern.polygons().flatten().collect();
                    let low = |axis: usize| points.iter().map(|point| point[axis]).fold(f64::MAX, f64::min);
                    let high = |axis: usize| points.iter().map(|point| point[axis]).fold(0.0, f64::max);
                    let [x0, y0, x1, y1] = [low(0), low(1), high(0), high(1)];
                    assert!(x0 >= PAGE_MARGIN - 1e-6 && x1 <= page.size[0] - PAGE_MARGIN + 1e-6, "{name}");
                    assert!(y0 >= PAGE_MARGIN - 1e-6 && y1 <= page.size[1] - PAGE_MARGIN + 1e-6, "{name}");
                    if pattern.ink == Ink::White {
                        let apart = |&[a0, b0, a1, b1]: &[f64; 4]| x0 > a1 || x1 < a0 || y0 > b1 || y1 < b0;
                        assert!(boxes.iter().all(apart), "{name}");
                        boxes.push([x0, y0, x1, y1]);
                    }
                }
            }
        }
    }
}
