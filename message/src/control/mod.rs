//! Questions to a running role and its answers: what its parameters are, other ones, its state and statistics.
//!
//! ```text
//!   client ── request (fixed size) ──▶ detector or camera: between two frames, checked, whole or not at all
//!      ◀───── reply: outcome, text, number of the change in force, everything that is in force, statistics ──
//! ```
//!
//! What comes out of shared memory is copied once and turned into the types here that hold only what is possible; the
//! blocks of bytes that travel are those named `Request` and `Reply`.

mod asking;
mod camera;
mod choices;
mod detector;
mod fault;
mod parameters;
mod words;

pub use asking::{CONTROL_SCHEMA, Outcome, REPLY_TEXT_BYTES, RequestKind};
pub use camera::{
    CONTROL_TEXT_BYTES, CameraAnswer, CameraAsk, CameraReply, CameraRequest, CameraStatistics, ControlSet,
    ControlState, DeviceControl, MAX_CONTROLS_SET, MAX_CONTROLS_TOLD,
};
pub use choices::{RefinementChoice, SamplingChoice, SearchChoice};
pub use detector::{
    DetectorAnswer, DetectorAsk, DetectorReply, DetectorRequest, DetectorState, DetectorStatistics,
};
pub use fault::ControlFault;
pub use parameters::{DetectorChange, DetectorParameters, MAX_ID_RANGES, ParameterBlock, Region};
pub use words::RegionTextError;
