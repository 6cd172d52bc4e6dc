//! Cameras on the Raspberry Pi's ribbon connector, through the program that comes with it.
//!
//! ```text
//! rpicam-vid --codec yuv420 ── pipe ──▶ Y plane: read straight into a loan      U, V: read and dropped
//! ```
//!
//! The program is what stays the same while libcamera's interfaces change. It is started again when it ends or falls silent.

mod program;
mod reader;
mod run;

pub(crate) use run::publish;
