//! What a robot program links to receive detections: where tags are, a few microseconds after the detector knows it.
//!
//! ```text
//!   detector ── detections (shared memory) ──▶ Client::receive ──▶ your loop
//! ```
//!
//! ```no_run
//! use std::time::Duration;
//! use tagbus_client::{Client, ConnectOptions};
//!
//! let mut client = Client::connect(&ConnectOptions::new("tagbus")?)?;
//! while let Some(detections) = client.receive(Duration::from_secs(5))? {
//!     for tag in detections.tags() {
//!         println!("{} {} at {:?}", tag.family(), tag.id, tag.center);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Camera and detector may come late, end and start again: a client waits and goes on by itself. A client can be moved
//! to another thread. Pixels and corner order: `docs/coordinates.md`.
#![forbid(unsafe_code)]

pub mod control;
mod detections;
mod error;
mod feed;
mod frames;
mod options;
mod recorder;

pub use detections::{Client, Detections};
pub use error::{ConnectError, ReceiveError};
pub use frames::{Frame, FrameClient};
pub use options::ConnectOptions;
pub use tagbus_message::clock::monotonic_ns;
pub use tagbus_message::detection::{DetectionsHeader, TagDetection, TagPose, header_flags, tag_flags};
pub use tagbus_message::domain::{Domain, DomainError};
pub use tagbus_message::frame::{CaptureKind, ClockKind, FrameHeader, FrameLayout};
pub use tagbus_message::stop::Stop;
