//! Blocks: what is cut out of the paper as one piece.

use super::length::{Length, short};
use super::outline::trace;
use super::page::{Ink, Outlines, Pattern};
use crate::family::Family;
use crate::grid::Paint;
use crate::layout::Layout;
use crate::square::Cell;
use std::fmt;

/// Free paper between a round tag and its cut line, at least.
const ROUND_CLEARANCE_MM: f64 = 0.5;

/// Which of a tag's two sizes is given (see `docs/coordinates.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// The side of the border edge.
    Tag(Length),
    /// The side of the whole print.
    Printed(Length),
}

impl Size {
    /// Millimetres of one cell.
    fn cell_mm(self, layout: &Layout) -> f64 {
        match self {
            Size::Tag(side) => side.mm() / layout.width_at_border() as f64,
            Size::Printed(side) => side.mm() / layout.total_width() as f64,
        }
    }
}

/// A tag of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Its family's name.
    pub family: String,
    /// Its number.
    pub id: u32,
    /// The side of its border edge in millimetres.
    pub tag_mm: f64,
    /// The corners of its border edge in millimetres from the block's middle, x right and y down: bottom left, bottom
    /// right, top right, top left.
    pub corners: [[f64; 2]; 4],
}

/// Where a block is cut out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// Along its edges.
    Straight,
    /// Along a circle round its middle.
    Round {
        /// In millimetres.
        radius: f64,
    },
}

/// How many tags a board has, and how far apart they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grouping {
    /// Tags above each other.
    pub rows: usize,
    /// Tags beside each other.
    pub columns: usize,
    /// Between two prints.
    pub spacing: Length,
}

/// A tag, a board or tags within tags, with the white margin around them.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Width and height in millimetres.
    pub size: [f64; 2],
    /// What part of the size is prints and therefore grows with the tag size.
    pub(super) prints: [f64; 2],
    /// Where it is cut out.
    pub cut: Cut,
    /// What is printed, from the block's top left corner.
    pub patterns: [Pattern; 2],
    /// Its tags; the first is the outermost one of nested tags.
    pub tags: Vec<Placed>,
    /// Millimetres of a cell of the first tag.
    pub cell_mm: f64,
    /// The number of pixels of such a cell must be a multiple of this for all cells to have whole pixels.
    pub pixel_step: u32,
    /// Two lines of text.
    pub caption: [String; 2],
}

impl Block {
    /// One tag with `margin` around its print.
    ///
    /// # Errors
    /// [`BlockError`] when the family has no such id or the size is zero.
    pub fn tag(family: &Family, id: u32, size: Size, margin: Length) -> Result<Block, BlockError> {
        Block::nest(&[(family, id)], size, margin)
    }

    /// Tags within tags: each fills the hole in the middle of the one before. `size` is that of the first.
    ///
    /// # Errors
    /// [`BlockError`] when there is no tag, no such id, no hole, the same tag twice, or the size is zero.
    pub fn nest(tags: &[(&Family, u32)], size: Size, margin: Length) -> Result<Block, BlockError> {
        let &(outermost, _) = tags.first().ok_or(BlockError::Empty)?;
        let cell_mm = size.cell_mm(outermost.layout());
        let print = cell_mm * outermost.layout().total_width() as f64;
        let side = print + 2.0 * margin.mm();
        let mut block = Block::blank([side; 2], [print; 2], cell_mm)?;
        if let Some(reach_mm) = round_reach(outermost.layout()).map(|cells| cells * cell_mm) {
            block.cut = Cut::Round { radius: reach_mm + margin.mm().max(ROUND_CLEARANCE_MM) };
            block.prints = [print.max(2.0 * reach_mm); 2];
        }
        // An inner cell is `ratio` outer ones, and its grid begins `offset` outer cells from the print's edge.
        let mut level = Level { cell_mm, first: margin.mm(), ratio: [1, 1] };
        for (place, &(family, id)) in tags.iter().enumerate() {
            if tags[..place].iter().any(|&(other, known)| other.name() == family.name() && known == id) {
                return Err(BlockError::Twice { family: family.name().to_owned(), id });
            }
            block.add(family, id, level.cell_mm, [level.first; 2])?;
            block.pixel_step = lcm(block.pixel_step, level.ratio[1]);
            if let Some(&(inner, _)) = tags.get(place + 1) {
                level = level.inside(family, inner)?;
            }
        }
        block.caption = nest_caption(tags, &block.tags, print);
        Ok(block)
    }

    /// A board: `ids` row after row from the top, each print `grouping.spacing` from the next, `margin` around all.
    ///
    /// # Errors
    /// [`BlockError`] when the number of ids is not that of the board's places, an id is unknown or twice, or the size is
    /// zero.
    pub fn board(
        family: &Family,
        ids: &[u32],
        size: Size,
        grouping: Grouping,
        margin: Length,
    ) -> Result<Block, BlockError> {
        let Grouping { rows, columns, spacing } = grouping;
        if rows.checked_mul(columns) != Some(ids.len()) || ids.is_empty() {
            return Err(BlockError::Places { rows, columns, ids: ids.len() });
        }
        let cell_mm = size.cell_mm(family.layout());
        let print = cell_mm * family.layout().total_width() as f64;
        let prints = [columns, rows].map(|count| print * count as f64);
        let gaps = [columns, rows].map(|count| spacing.mm() * (count - 1) as f64 + 2.0 * margin.mm());
        let mut block = Block::blank([prints[0] + gaps[0], prints[1] + gaps[1]], prints, cell_mm)?;
        for (place, &id) in ids.iter().enumerate() {
            if ids[..place].contains(&id) {
                return Err(BlockError::Twice { family: family.name().to_owned(), id });
            }
            let pitch = print + spacing.mm();
            let at = [place % columns, place / columns].map(|count| margin.mm() + pitch * count as f64);
            block.add(family, id, cell_mm, at)?;
        }
        block.caption = [
            format!("{} {}, {rows} x {columns}, spacing {spacing}", family.name(), ids_text(ids)),
            sizes_text(block.tags[0].tag_mm, print),
        ];
        Ok(block)
    }

    fn blank(size: [f64; 2], prints: [f64; 2], cell_mm: f64) -> Result<Block, BlockError> {
        if cell_mm <= 0.0 {
            return Err(BlockError::NoSize);
        }
        let caption = [String::new(), String::new()];
        // Black lies over white.
        let patterns = [Ink::White, Ink::Black].map(|ink| Pattern { parts: Vec::new(), ink });
        let tags = Vec::new();
        Ok(Block { size, prints, cut: Cut::Straight, patterns, tags, cell_mm, pixel_step: 1, caption })
    }

    /// Adds a tag whose print begins `at` millimetres from the block's top left corner.
    fn add(&mut self, family: &Family, id: u32, cell_mm: f64, at: [f64; 2]) -> Result<(), BlockError> {
        let count = family.codes().len();
        let unknown = || BlockError::UnknownId { family: family.name().to_owned(), id, count };
        let grid = family.grid(id).ok_or_else(unknown)?;
        for Pattern { parts, ink } in &mut self.patterns {
            let shown =
                |paint| if *ink == Ink::Black { paint == Paint::Black } else { paint != Paint::Clear };
            let loops = trace(grid.width(), |x, y| shown(grid.get(x, y)));
            parts.push(Outlines { origin: at, step_mm: cell_mm, loops });
        }
        let layout = family.layout();
        let tag_mm = cell_mm * layout.width_at_border() as f64;
        let first: [f64; 2] =
            std::array::from_fn(|axis| at[axis] + cell_mm * layout.margin() as f64 - self.size[axis] / 2.0);
        let corner = |[x, y]: [f64; 2]| [first[0] + x * tag_mm, first[1] + y * tag_mm];
        let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(corner);
        self.tags.push(Placed { family: family.name().to_owned(), id, tag_mm, corners });
        Ok(())
    }

    /// Width and height of what the cut line encloses.
    pub(super) fn reach(&self) -> [f64; 2] {
        match self.cut {
            Cut::Straight => self.size,
            Cut::Round { radius } => self.size.map(|side| side.max(2.0 * radius)),
        }
    }
}

/// One of several tags within each other.
struct Level {
    cell_mm: f64,
    /// From the block's edge to the print, in millimetres.
    first: f64,
    /// A cell in cells of the outermost tag, as a reduced fraction.
    ratio: [u32; 2],
}

impl Level {
    /// The next level: `inner` in the hole of `outer`.
    fn inside(&self, outer: &Family, inner: &Family) -> Result<Level, BlockError> {
        let hole = outer.layout().hole_width();
        if hole == 0 {
            return Err(BlockError::NoHole {
                outer: outer.name().to_owned(),
                inner: inner.name().to_owned(),
            });
        }
        let (outer_width, inner_width) = (outer.layout().total_width(), inner.layout().total_width());
        let [top, bottom] = [self.ratio[0] * hole as u32, self.ratio[1] * inner_width as u32];
        let common = gcd(top, bottom);
        Ok(Level {
            cell_mm: self.cell_mm * hole as f64 / inner_width as f64,
            first: self.first + self.cell_mm * (outer_width - hole) as f64 / 2.0,
            ratio: [top / common, bottom / common],
        })
    }
}

/// Tags without cells in the corners are round: how far their cells are from the middle, in cells.
fn round_reach(layout: &Layout) -> Option<f64> {
    let first = -(layout.margin() as i32);
    if layout.cell(first, first) != Cell::Ignored {
        return None;
    }
    let cells = first..first + layout.total_width() as i32;
    let middle = layout.width_at_border() as f64 / 2.0;
    let far = |at: i32| (f64::from(at) + 0.5 - middle).abs() + 0.5;
    let all = cells.clone().flat_map(|y| cells.clone().map(move |x| (x, y)));
    let painted = all.filter(|&(x, y)| layout.cell(x, y) != Cell::Ignored);
    Some(painted.map(|(x, y)| far(x).hypot(far(y))).fold(0.0, f64::max))
}

fn nest_caption(tags: &[(&Family, u32)], placed: &[Placed], print: f64) -> [String; 2] {
    let names: Vec<String> = tags.iter().map(|(family, id)| format!("{} id {id}", family.name())).collect();
    let inner: Vec<String> = placed[1..].iter().map(|tag| format!(", {}", short(tag.tag_mm))).collect();
    let within = if inner.is_empty() { String::new() } else { format!("; within: {}", &inner.concat()[2..]) };
    [names.join(" / "), sizes_text(placed[0].tag_mm, print) + &within]
}

fn sizes_text(tag_mm: f64, print_mm: f64) -> String {
    format!("tag size {} mm, printed size {} mm", short(tag_mm), short(print_mm))
}

/// Ids as they are asked for: `ids 0-5,9`.
fn ids_text(ids: &[u32]) -> String {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for &id in ids {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == id => *last = id,
            _ => runs.push([id, id]),
        }
    }
    let text = |[first, last]: &[u32; 2]| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    };
    format!("ids {}", runs.iter().map(text).collect::<Vec<_>>().join(","))
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn lcm(a: u32, b: u32) -> u32 {
    a / gcd(a, b) * b
}

/// Why tags make no block.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BlockError {
    /// No tag was named.
    Empty,
    /// The size is zero.
    NoSize,
    /// A family has no such id.
    UnknownId {
        /// The family.
        family: String,
        /// The id.
        id: u32,
        /// How many it has.
        count: usize,
    },
    /// The same tag twice: detections could not be told apart.
    Twice {
        /// The family.
        family: String,
        /// The id.
        id: u32,
    },
    /// A layout has no hole that another tag would fit into.
    NoHole {
        /// The family without a hole.
        outer: String,
        /// The family of the tag that should be in it.
        inner: String,
    },
    /// The ids do not fill the board.
    Places {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// How many ids there are.
        ids: usize,
    },
}

impl fmt::Display for BlockError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BlockError::Empty => out.write_str("no tag is named, but one at least is needed"),
            BlockError::NoSize => {
                out.write_str("the size is 0 mm, but a tag has a size above that such as 160mm")
            }
            BlockError::UnknownId { family, id, count } => {
                write!(out, "{family} has no id {id}: it has {count} tags, ids 0 to {}", count - 1)
            }
            BlockError::Twice { family, id } => write!(
                out,
                "id {id} of {family} is named twice: two equal tags on one piece cannot be told apart; name another"
            ),
            BlockError::NoHole { outer, inner } => write!(
                out,
                "{outer} has no hole in its middle, so nothing can be within it: put {inner} into tagCustom48h12 or another layout \
                 with x cells in its middle"
            ),
            BlockError::Places { rows, columns, ids } => write!(
                out,
                "{ids} ids do not fill boards of {rows} x {columns} tags: name a multiple of that many ids, at least once"
            ),
        }
    }
}

impl std::error::Error for BlockError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(text: &str) -> Length {
        text.parse().unwrap()
    }

    fn family(name: &str) -> Family {
        Family::published(name).unwrap()
    }

    #[test]
    fn a_tag_has_its_border_edge_where_the_size_says() {
        for (name, print) in [("tag36h11", 200.0), ("tagStandard41h12", 288.0), ("tagCircle21h7", 288.0)] {
            let block = Block::tag(&family(name), 3, Size::Tag(length("160mm")), length("4mm")).unwrap();
            assert!((block.size[0] - print - 8.0).abs() < 1e-9, "{name}: {:?}", block.size);
            let expected = [[-80.0, 80.0], [80.0, 80.0], [80.0, -80.0], [-80.0, -80.0]];
            let pairs = block.tags[0].corners.iter().flatten().zip(expected.iter().flatten());
            assert!(pairs.into_iter().all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{name}");
        }
    }

    #[test]
    fn each_48h12_within_another_is_a_fifth_of_it_and_the_pixels_of_all_cells_are_whole() {
        let (custom, standard) = (family("tagCustom48h12"), family("tagStandard41h12"));
        let tags = [(&custom, 0), (&custom, 1), (&standard, 5)];
        let block = Block::nest(&tags, Size::Printed(length("250mm")), Length::ZERO).unwrap();
        let sizes: Vec<f64> = block.tags.iter().map(|tag| tag.tag_mm).collect();
        for (found, wanted) in sizes.iter().zip([150.0, 30.0, 10.0 * 5.0 / 9.0]) {
            assert!((found - wanted).abs() < 1e-9, "{sizes:?}");
        }
        for part in block.patterns.iter().flat_map(|pattern| &pattern.parts) {
            let pixels = f64::from(block.pixel_step) * part.step_mm / block.cell_mm;
            assert!((pixels - pixels.round()).abs() < 1e-9, "{pixels}");
        }
        assert!(block.caption[1].contains("within: 30, 5.56"), "{:?}", block.caption);
    }

    #[test]
    fn nested_tags_without_a_hole_or_twice_are_refused() {
        let (custom, classic) = (family("tagCustom48h12"), family("tag36h11"));
        let nest = |tags: &[(&Family, u32)]| {
            Block::nest(tags, Size::Tag(length("60mm")), Length::ZERO).unwrap_err().to_string()
        };
        assert!(nest(&[(&classic, 0), (&custom, 1)]).contains("tag36h11 has no hole"));
        assert!(nest(&[(&custom, 4), (&custom, 4)]).contains("id 4 of tagCustom48h12 is named twice"));
        assert!(nest(&[(&custom, 4), (&classic, 587)]).contains("ids 0 to 586"));
    }

    #[test]
    fn a_boards_tags_are_a_print_and_the_spacing_apart() {
        let grouping = Grouping { rows: 2, columns: 3, spacing: length("5mm") };
        let board = |ids: &[u32]| {
            Block::board(&family("tag36h11"), ids, Size::Tag(length("40mm")), grouping, length("2mm"))
        };
        let block = board(&[0, 1, 2, 3, 4, 9]).unwrap();
        assert_eq!(block.size, [3.0 * 50.0 + 2.0 * 5.0 + 4.0, 2.0 * 50.0 + 5.0 + 4.0]);
        assert_eq!(block.tags[0].corners[0], [-75.0, -7.5 + 5.0 - 5.0]);
        assert_eq!(block.tags[4].corners[3][0] - block.tags[3].corners[3][0], 55.0);
        assert_eq!(block.caption[0], "tag36h11 ids 0-4,9, 2 x 3, spacing 5 mm");
        assert!(board(&[0, 1]).unwrap_err().to_string().contains("2 ids do not fill boards of 2 x 3"));
    }
}
