//! Frames in, detections out: the process between camera and clients, as a library.
//!
//! ```text
//!   frames topic ──▶ newest frame ──▶ check ──▶ detector ──▶ detections topic
//!                    (in shared       header    reads the    send, then wake
//!                     memory)         or skip   same bytes   the clients
//!                                               ▲
//!   control topic ──▶ between two frames: a new detector with its header, whole
//! ```
//!
//! ```no_run
//! use tagbus_family::Family;
//! use tagbus_message::{domain::Domain, stop::Stop};
//! use tagbus_service::{ServiceConfig, run};
//!
//! let mut config = ServiceConfig::new(Domain::new("tagbus")?, vec![Family::published("tag36h11")?]);
//! config.report = Box::new(|report| eprintln!("{report}"));
//! let summary = run(config, Stop::new()?)?;
//! println!("{} frames searched", summary.frames_searched);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod change;
mod config;
mod convert;
mod desk;
mod in_force;
mod pace;
mod recorder;
mod region;
mod report;
mod run;
mod search;

pub use config::{FrameSeen, Moment, Observer, Reporter, ServiceConfig, Watch};
pub use report::{Report, ServiceError, Summary};
pub use run::run;
