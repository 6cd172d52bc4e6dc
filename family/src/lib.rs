//! What a tag looks like: layouts, codes, drawing, and the way back from a read code to its id.
//!
//! A *layout* says what each cell of the printed square is: always white, always black, a data bit, or not part of
//! the tag at all. A *family* is a layout with a list of codes that are far apart in bits, whichever way the tag is
//! turned; the place of a code in the list is the tag's id. This crate knows nothing about pictures or processes.
//!
//! # One tag
//!
//! tag36h11, id 0 (`##` is a black cell, ` .` a white one). The *tag size* of pose estimation is the border edge, where
//! black meets white, and not the edge of the print:
//!
//! ```text
//!    |<- printed size ->|     total_width()     10 cells
//!      |<- tag size ->|       width_at_border()  8 cells
//!    | |              | |     margin()           1 cell on each side
//!     . . . . . . . . . .   <- white ring: inside the print, outside the border edge
//!     .################ .   <- black ring: its outer edge is the border edge
//!     .## . .## .## .## .   <- 6 x 6 data cells, white for 1
//!     .#### . . .## .## .
//!     .#### . .######## .
//!     .## .## .######## .
//!     .#### .## . .#### .
//!     .######## .###### .
//!     .################ .
//!     . . . . . . . . . .
//! ```
//!
//! Where data lies outside the border (tagStandard41h12: 5 cells of 9) the two sizes differ most, and a print measured
//! at the wrong edge gives distances that are wrong by 9/5.
//!
//! # Example
//!
//! ```
//! use tagbus_family::{Family, Index};
//!
//! let family = Family::published("tag36h11")?;
//! let index = Index::new(&family, family.default_hamming());
//!
//! // Somebody holds tag 42 turned by 90 degrees, and one bit was read wrongly.
//! let read = family.layout().rotate90(family.codes()[42]) ^ 1;
//! let found = index.lookup(read).expect("one wrong bit is corrected");
//! assert_eq!((found.id, found.hamming, found.rotation), (42, 1, 3));
//! # Ok::<(), tagbus_family::UnknownFamily>(())
//! ```
#![deny(unsafe_code)]

#[cfg(test)]
mod random;

mod shape;

mod layout_error;
pub use layout_error::LayoutError;

mod square;
pub use square::{Border, Cell};

mod layout;
pub use layout::Layout;

mod grid;
pub use grid::{Grid, Paint};

pub mod aruco;
pub mod candidates;
pub mod complexity;
pub mod kalibr;
pub mod published;

mod recipe;
pub use recipe::{BitOrder, Recipe, RecipeError, largest_distance};

pub mod search;

mod name;
pub use name::{UnknownFamily, nearest_name};

mod family;
pub use family::{Family, FamilyError, MinimumDistance};

pub mod import;

mod index;
pub use index::{Found, Index};

#[cfg(feature = "file")]
pub mod file;

#[cfg(feature = "print")]
pub mod print;
