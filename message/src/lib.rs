//! What crosses a process boundary, byte for byte, and how a role comes onto the bus and leaves it.
//!
//! ```text
//!   camera ── frames ([u8] + FrameHeader) ──▶ detector ── detections ([TagDetection] + DetectionsHeader) ──▶ clients
//!      └───── info (CameraInfo) ──────────▶ anybody
//!   camera, detector ◀─ control (requests, replies) ─▶ whoever wants something changed
//! ```
//!
//! A role makes a [`bus::Bus`] in a [`domain::Domain`] and opens or makes its topics with it:
//!
//! ```no_run
//! use tagbus_message::{Local, bus::{Bus, Patience}, domain::Domain, qos, stop::Stop};
//!
//! let stop = Stop::new()?;
//! let bus = Bus::<Local>::start(&Domain::new("tagbus")?, "viewer", &stop)?;
//! let frames = bus.open_frames("cam0", qos::DETECTOR_FRAME_BUFFER, Patience::Endless)?;
//! if let Some(frame) = frames.newest()? {
//!     let header = *frame.user_header();
//!     let layout = header.validate(frame.payload().len())?;
//!     println!("frame {} of {} x {}", header.sequence, layout.width, layout.height);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(unsafe_code)]

pub mod bell;
pub mod bus;
mod capture;
pub mod clock;
pub mod control;
pub mod control_ports;
mod description;
pub mod detection;
pub mod domain;
pub mod fourcc;
pub mod frame;
mod gate;
mod header_error;
mod held;
pub mod histogram;
pub mod info;
mod local;
pub mod onlooker;
mod other_version;
mod pages;
pub mod ports;
pub mod qos;
#[cfg(test)]
mod random;
mod reuse;
pub mod room;
pub mod stats;
pub mod stats_ports;
pub mod stop;
mod sweep;
pub mod tally;
pub mod text;
pub mod topics;
pub mod turns;
mod verdict;
pub mod wait;

pub use local::Local;
