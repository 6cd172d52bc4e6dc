//! The detector of "Flexible Layouts for Fiducial Tags" (Krogius, Haggenmiller, Olson, IROS 2019; *the paper*) as it is
//! written: pixel by pixel, slow and plain. It is an oracle for tests of the product, and the place where the paper's own
//! choices are measured against what they replaced (its *ablations*).
//!
//! ```text
//! Picture ─▶ decimate ─▶ threshold ─▶ components ─▶ contours ─▶ outlines ─▶ quads ─▶ decode ─▶ [Detection]
//!            fig. 4.2    fig. 4.3     fig. 4.4, 5   fig. 4.5    eq. 2       fig. 4.6  fig. 4.7, 4.8
//! ```
//!
//! What the paper takes over from AprilTag 2 (Wang and Olson, IROS 2016) without describing it again (threshold, corner
//! search, edge refinement, grey model) is written from what those papers say of the method; constants that no paper
//! names stand at the top of their files.
//!
//! ```
//! use tagbus_family::Family;
//! use tagbus_paper::{Options, Picture, Pipeline};
//!
//! let family = Family::published("tag36h11")?;
//! let pipeline = Pipeline::new(&[family], Options::default())?;
//! let flat = Picture::new(320, 240, vec![128; 320 * 240])?;
//! assert!(pipeline.detect(&flat).detections.is_empty(), "a flat picture holds no tag");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Coordinates are those of `docs/coordinates.md`: (0, 0) is the top-left corner of the top-left pixel.
#![forbid(unsafe_code)]

mod options;
mod picture;
mod pipeline;

// From the picture to quads, in the order of figure 4.
mod components;
mod contours;
mod corners;
mod decimate;
mod line;
mod outline;
mod quad;
mod threshold;
mod union_find;

// From quads to tags.
mod decode;
mod grey_model;
mod homography;
mod overlap;
mod refine;
mod sample;
mod sharpen;

pub use components::Unions;
pub use decimate::Filter;
pub use line::LineError;
pub use options::{Options, OptionsError};
pub use outline::SortKey;
pub use picture::{Picture, PictureError};
pub use pipeline::{Counts, Detection, Outcome, Phase, Pipeline};
pub use refine::Refinement;
pub use sample::Sampling;
