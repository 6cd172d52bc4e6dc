//! Takes frames from a source and publishes them on the bus, each written once, straight into shared memory.
//!
//! ```text
//! scene   ── rendered ───────────────────────┐
//! picture ── decoded once, copied ───────────┤            ┌─ header: format, size, sequence, stamps, copies
//! folder  ── JPEG decoded (others copied) ───┼──▶ loan ───┤
//! MJPEG, AVI ── luma decoded ────────────────┤  (shared   └─▶ frames topic ──▶ whoever subscribes
//! raw file ── read by the kernel ────────────┤   memory)      info topic: mode and state
//! device ──── written by its driver ─────────┤
//! rpicam ──── read from a program's pipe ────┤
//! libcamera ─ luma copied from its memory ───┘
//! ```
//!
//! "Copies" in a frame's header are passes that this process made over the frame after it existed in memory: 0 for
//! everything above but a single picture and those pictures of a folder that are not JPEG, which are 1. Of a device they are 0
//! where its driver writes into shared memory itself, and 1 elsewhere; [`Transfer`] says which, and why.
//!
//! ```no_run
//! use tagbus_camera::{CameraConfig, SourceOptions, run};
//! use tagbus_message::{domain::Domain, stop::Stop};
//!
//! let config = CameraConfig {
//!     domain: Domain::new("tagbus")?,
//!     camera: "cam0".into(),
//!     source: "replay:recording".parse()?,
//!     options: SourceOptions::default(),
//! };
//! let summary = run(config, Stop::new()?)?;
//! println!("{} frames", summary.frames);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(unsafe_code)]

mod config;
pub use config::{
    CameraConfig, DEFAULT_FRAMERATE, DEFAULT_SEED, FramerateError, MAX_FRAMERATE, Pace, Repeat, Source,
    SourceOptions, SourceTextError,
};

mod control;
pub use control::{ControlInfo, ControlSetting, ControlSettings, ControlTextError};

mod format;
pub use format::{FORMATS, FrameShape, RAW_FORMATS, UnknownFormat, parse_format};

mod grey;
mod jpeg;
pub mod picture;
mod unpack;

pub mod source;

mod folder;
mod mjpeg;
pub mod order;
mod raw;
mod still;
mod synthetic;

mod device;
pub use device::Transfer;
pub mod devices;
mod libcamera;
mod readiness;
mod rpicam;
#[cfg(any(feature = "v4l", feature = "libcamera"))]
mod stamps;

mod pace;

mod space;
pub use space::{Space, SpaceError};

mod desk;
#[allow(unsafe_code, reason = "the one place that says that lent shared memory is initialised")]
mod loan;
mod outlet;
mod publish;

mod run;
pub use run::{CameraError, CameraEvent, Ending, Summary, run, run_reporting};

#[cfg(test)]
mod test_folder;
