//! `tagbus family print`: tags on paper.

mod flags;
mod geometry;
mod output;

use std::io::{self, Write};

use clap::Args;
use tagbus_family::Family;
use tagbus_family::print::{Block, Grouping, sheet};

use crate::chosen_family::ChosenFamily;
use crate::command::Invocation;
use crate::flags::IdList;
use crate::outcome::{Failure, Outcome};
use flags::{Format, PrintFlags};
use output::Output;

/// Print tags in exact millimetres: SVG, PDF or PNG
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus family print tag36h11 0-9 --tag-size 80mm --output tags.pdf
  tagbus family print tagStandard41h12 0-11 --tag-size 20mm --board 3x4 --spacing 10mm --output board.svg --geometry board.toml
  tagbus family print --nest tagCustom48h12:0,tagCustom48h12:1,tagStandard41h12:5 --printed-size 180mm --output nest.pdf
  tagbus family print mine.toml 7 --printed-size 60mm --output tag7.png

The tag size is the side of the border edge, which pose estimation wants; the
printed size is the side of the whole print (tagbus family show NAME).
A page has cut marks, a ruler to check the printer with, and below each tag an
arrow up with family, id and sizes. Print without scaling (100 %).
Several pages become one PDF, or files tags-1.svg, tags-2.svg, ...

PNG has no text. All cells have whole pixels, 300 to 600 dots an inch (fewer
where a side would have more than 10000 pixels); on a page, tags are moved to
whole pixels, by half a pixel at most. What the size is off by, because PNG
counts whole pixels a metre, is said. Cells that are not part of the tag are
not painted; in PNG they are paper, white.

Nested tags each fill the hole in the middle of the one before; the size is
that of the first. Geometry: corners of each border edge in metres from the
middle of the board, x right, y down, z into the paper; bottom left, bottom
right, top right, top left.")]
pub(crate) struct PrintCommand {
    /// The family, such as tag36h11, 36h11, or a file of your own, FILE.toml
    #[arg(value_name = "NAME|FILE.toml", required_unless_present_any = ["print_config", "nest"])]
    name: Option<ChosenFamily>,
    /// The ids, such as 0-9,12
    #[arg(value_name = "IDS", required_unless_present_any = ["print_config", "nest"])]
    ids: Option<IdList>,
    /// svg, pdf or png; by default what the output's name ends in
    // Not in the flags below: in the configuration file, `format` is that of the camera's frames.
    #[arg(long, value_name = "svg|pdf|png")]
    format: Option<String>,
    #[command(flatten)]
    flags: PrintFlags,
}

/// Lays out and writes everything, or nothing.
pub(super) fn execute(command: PrintCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let PrintCommand { name, ids, format, flags } = command;
    let Some(flags) = invocation.in_force(flags)? else { return Ok(Outcome::Done) };
    let format = Format::of(format.as_deref(), flags.output.as_deref())?;
    let blocks = blocks(name.as_ref().map(ChosenFamily::family), ids.as_ref(), &flags)?;
    let pages = match flags.paper(format) {
        Some(paper) => sheet::pages(&blocks, &paper, flags.per_page)?,
        None if flags.per_page.is_some() => {
            return Err(Failure::new("--per-page needs a page: name one with --page"));
        }
        None => blocks.iter().map(sheet::bare).collect(),
    };
    let mut output = Output::new(&flags, format)?;
    output.add_pages(&pages, &blocks[0])?;
    if let Some(path) = &flags.geometry {
        output.add_geometry(path, geometry::text(path, &blocks)?)?;
    }
    let mut out = io::stdout().lock();
    output.write()?.iter().try_for_each(|line| writeln!(out, "{line}"))?;
    Ok(Outcome::Done)
}

/// At least one block.
fn blocks(family: Option<&Family>, ids: Option<&IdList>, flags: &PrintFlags) -> Result<Vec<Block>, Failure> {
    let (size, margin) = (flags.size()?, flags.margin);
    match (&flags.nest, family, ids) {
        (Some(nest), None, None) => Ok(vec![Block::nest(&nest.tags(), size, margin)?]),
        (Some(_), _, _) => {
            Err(Failure::new("--nest names families and ids itself: leave out NAME and IDS before it"))
        }
        (None, Some(family), Some(ids)) => {
            let ids = ids.ids();
            check_twice(&ids)?;
            match flags.grouping()? {
                Some(grouping) => boards(family, &ids, flags, grouping),
                None => ids.iter().map(|&id| Ok(Block::tag(family, id, size, margin)?)).collect(),
            }
        }
        (None, _, _) => Err(Failure::new("name a family and ids such as: tag36h11 0-9; or give --nest")),
    }
}

/// The ids' boards; each has all its places filled.
fn boards(
    family: &Family,
    ids: &[u32],
    flags: &PrintFlags,
    grouping: Grouping,
) -> Result<Vec<Block>, Failure> {
    let size = flags.size()?;
    let places = grouping.rows * grouping.columns;
    if !ids.len().is_multiple_of(places) {
        return Ok(vec![Block::board(family, ids, size, grouping, flags.margin)?]);
    }
    let boards = ids.chunks(places);
    boards.map(|ids| Ok(Block::board(family, ids, size, grouping, flags.margin)?)).collect()
}

fn check_twice(ids: &[u32]) -> Result<(), Failure> {
    let mut sorted = ids.to_vec();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(Failure::new(format!("id {} is named twice: name each id once", pair[0]))),
        None => Ok(()),
    }
}
