//! Where the tags of boards and nested tags are, for programs.

use std::path::Path;

use serde::Serialize;
use tagbus_family::print::Block;

use crate::outcome::Failure;

#[derive(Serialize)]
struct Geometry<'a> {
    /// What the corners are counted in and from.
    unit: &'static str,
    frame: &'static str,
    corner_order: &'static str,
    /// In the order of the pages.
    boards: Vec<Board<'a>>,
}

#[derive(Serialize)]
struct Board<'a> {
    /// Of the cut edge.
    width: f64,
    height: f64,
    tags: Vec<Tag<'a>>,
}

#[derive(Serialize)]
struct Tag<'a> {
    family: &'a str,
    id: u32,
    /// Side of the border edge.
    tag_size: f64,
    corners: [[f64; 3]; 4],
}

/// The file's text, in the form that its name ends in.
pub(super) fn text(path: &Path, blocks: &[Block]) -> Result<String, Failure> {
    let geometry = Geometry {
        unit: "m",
        frame: "origin in the middle of the board, x right, y down, z into the paper",
        corner_order: "bottom left, bottom right, top right, top left of the border edge",
        boards: blocks.iter().map(board).collect(),
    };
    match path.extension().unwrap_or_default().to_string_lossy().as_ref() {
        "toml" => Ok(toml::to_string(&geometry)?),
        "json" => Ok(serde_json::to_string_pretty(&geometry)? + "\n"),
        _ => Err(Failure::new(format!(
            "--geometry {} must end in .toml or .json, which says how it is written",
            path.display()
        ))),
    }
}

fn board(block: &Block) -> Board<'_> {
    let [width, height] = block.size.map(metres);
    let tag = |tag: &'_ tagbus_family::print::Placed| tag.corners.map(|[x, y]| [metres(x), metres(y), 0.0]);
    let tags = block.tags.iter().map(|placed| Tag {
        family: &placed.family,
        id: placed.id,
        tag_size: metres(placed.tag_mm),
        corners: tag(placed),
    });
    Board { width, height, tags: tags.collect() }
}

/// Rounded to nanometres, so that no digits are noise; no -0.
fn metres(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e9 + 0.0
}
