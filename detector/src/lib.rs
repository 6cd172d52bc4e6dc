//! A grey view in, tags with corners out: the method of "Flexible Layouts for Fiducial Tags" (Krogius, Haggenmiller,
//! Olson, IROS 2019), without files, processes or clocks.
//!
//! ```text
//! LumaView ─▶ binarize ─▶ cluster ─▶ fit ─▶ identify ─▶ [Detection]
//!   (bytes     dark and    outlines   quads   which tag,
//!    where     bright      of one             corners to
//!    they lie) pixels      colour             a fraction of a pixel
//! ```
//!
//! ```
//! use tagbus_detector::{Detector, LumaView, Settings};
//! use tagbus_family::Family;
//!
//! let family = Family::published("tag36h11")?;
//! let mut detector = Detector::new(&[family], &Settings::default())?;
//! let frame = vec![128; 640 * 480];
//! let tags = detector.detect(&LumaView::grey(&frame, 640, 480)?);
//! assert!(tags.is_empty(), "a flat frame holds no tag");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Coordinates are drawn in `docs/coordinates.md`.

#![deny(unsafe_code)]

mod binarize;
mod cluster;
mod detection;
mod detector;
mod fit;
mod identify;
mod numbered;
mod settings;
mod simd;
mod threads;
mod view;

pub use detection::{Detection, Flags};
pub use detector::{Detector, Phase};
pub use settings::{Decimation, Refinement, Sampling, Search, Settings, SettingsError};
pub use simd::{Level, UnknownLevel};
pub use view::{Geometry, LumaView, MAX_SIDE, MIN_SIDE, ViewError};
