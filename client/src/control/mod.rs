//! Asking a running detector or camera: what is in force, other values, state and statistics.
//!
//! ```no_run
//! use tagbus_client::ConnectOptions;
//! use tagbus_client::control::{DetectorChange, DetectorControl};
//!
//! let mut detector = DetectorControl::connect(&ConnectOptions::new("tagbus")?)?;
//! let change = DetectorChange { decimation: Some(1.0), ids: Some(vec![(1, 20)]), ..DetectorChange::default() };
//! let answer = detector.set(&change)?;
//! println!("messages of change {} on are searched at full resolution", answer.control_number);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera;
mod detector;
mod error;
mod exchange;

pub use camera::CameraControl;
pub use detector::DetectorControl;
pub use error::ControlError;
pub use exchange::DEFAULT_TIMEOUT;
pub use tagbus_message::control::{
    CameraAnswer, CameraStatistics, ControlFault, DetectorAnswer, DetectorChange, DetectorParameters,
    DetectorState, DetectorStatistics, DeviceControl, Outcome, RefinementChoice, Region, RegionTextError,
    SamplingChoice, SearchChoice,
};
