//! Tags on paper, in exact millimetres: single tags, boards, tags within tags; as SVG, PDF and PNG.
//!
//! ```text
//!    Family, ids ──▶ Block ──▶ sheet::pages ──▶ Page ──▶ to_svg   text
//!                    what is     places blocks,           to_pdf   bytes, all pages
//!                    cut out     cut marks, ruler         to_png   bytes, whole pixels a cell
//! ```
//!
//! Lengths are millimetres, x goes right and y down, as in `docs/coordinates.md`. Black cells that touch are one path
//! filled by the even-odd rule: were each cell a square of its own, renderers would leave hairlines between them.
//!
//! ```
//! use tagbus_family::Family;
//! use tagbus_family::print::{Block, Paper, Size, sheet, to_svg};
//!
//! let family = Family::published("tag36h11")?;
//! let block = Block::tag(&family, 7, Size::Tag("80mm".parse()?), "0mm".parse()?)?;
//! let pages = sheet::pages(&[block], &"a4".parse::<Paper>()?, None)?;
//! assert!(to_svg(&pages[0]).contains("width=\"210mm\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod length;
pub use length::{Length, LengthError};

mod outline;

mod page;
pub use page::{Ink, Mark, Outlines, Page, Pattern};

mod block;
pub use block::{Block, BlockError, Cut, Grouping, Placed, Size};

mod paper;
pub use paper::{Paper, PaperError};

pub mod sheet;

mod svg;
pub use svg::to_svg;

mod pdf;
pub use pdf::to_pdf;

mod png;
pub use png::{Resolution, to_png};
