//! Pictures of tags with known truth, for the built-in show, for tests and for benchmarks.
//!
//! Everything is a pure function of its arguments (a seed and a frame number among them): no files, no clock, the same
//! bytes on every machine. What a picture shows is known exactly, so a detector can be held to it.
//!
//! ```text
//!   Tag ──▶ Placement ──▶ area of the cells ──▶ blur ──▶ light ──▶ noise ──▶ bytes
//!   what    where          in each pixel        lens     lamp      sensor
//!   is      (homography),
//!   printed  ink, paper
//!
//!   ┌────────────────────────────┬──────────────┐    Scene: each tag (or nest of tags) has a region
//!   │      ┌──────────┐          │   ◇    ┌─┐   │    of the picture, in which it moves through space
//!   │      │  ┌────┐  │          │        └─┘   │    along a closed curve, so that none ever hides
//!   │      │  │ ▒▒ │  │          │  ┌─┐     ◇   │    another; behind them a room that stands still
//!   │      │  └────┘  │          │  └─┘         │
//!   │      └──────────┘          │      ◇       │    Photo: one picture of tags placed by the caller
//!   └────────────────────────────┴──────────────┘
//! ```
//!
//! Pixel (0, 0) has its top-left corner at the coordinates (0, 0) and its centre at (0.5, 0.5). A homography maps the
//! square [-1, 1]^2 of the border edge (x right, y down on the upright tag) to pixels. Corners start at the bottom
//! left of the upright tag and go on counter-clockwise as seen in the picture ([`corners_of`]).
//!
//! # Examples
//!
//! A frame of the show, and what is in it:
//!
//! ```
//! use tagbus_scene::{Scene, SceneConfig};
//!
//! let scene = Scene::new(SceneConfig { width: 320, height: 240, ..SceneConfig::default() })?;
//! let mut luma = vec![0; 320 * 240];
//! scene.render(42, &mut luma);
//! for tag in scene.truth(42) {
//!     println!("{} {} at {:.1?}, {:.1} px a cell", tag.family, tag.id, tag.corners[0], tag.cell_px);
//! }
//! # assert_eq!(scene.truth(42).len(), 7);
//! # Ok::<(), tagbus_scene::SceneError>(())
//! ```
//!
//! One tag, tilted, in a picture of its own:
//!
//! ```
//! use tagbus_family::Family;
//! use tagbus_scene::{Photo, Placement, Tag, Turn, View, homography_of, photograph};
//!
//! let family = Family::published("tagStandard41h12")?;
//! let turn = Turn { rotation_rad: 1.2, tilt_rad: 0.9, tilt_direction_rad: 0.3 };
//! let homography = homography_of(family.layout(), &View { turn, ..View::default() });
//! let placement = Placement::new(Tag::new(&family, 5)?, homography);
//! let luma = photograph(&Photo { blur_sigma: 0.8, noise_sigma: 5.0, ..Photo::default() }, &[placement]);
//! assert_eq!(luma.len(), 640 * 480);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod number;

// Numbers that are the same everywhere.
mod elementary;
mod random;
pub use random::Stream;

// Where things are.
mod homography;
pub use homography::{Homography, Point, corners_of, project};
mod camera;
pub use camera::{Camera, Pose, Rotation, Turn, View, homography_of};

// What is painted, and how.
mod tag;
pub use tag::{Tag, TagError, TrueTag};
mod canvas;
mod coverage;
mod ink;
mod placement;
pub use placement::{Paper, Placement};
mod texture;
pub use texture::Background;

// What the camera makes of it.
mod blur;
mod motion;
pub use motion::Motion;
mod glare;
pub use glare::Glare;
mod tone;
pub use tone::Tone;
mod exposure;
pub use exposure::Light;

// A single picture.
mod photo;
pub use photo::{Photo, photograph};

// The moving show.
mod config;
pub use config::{SceneConfig, SceneError};
mod cast;
mod orbit;
mod room;
mod scene;
pub use scene::{Scene, Scratch};
