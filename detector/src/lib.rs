//! A grey view in, tags with corners out.
#![deny(unsafe_code)]

mod detection;
mod settings;
mod view;

pub use detection::{Detection, Flags};
pub use settings::{Decimation, Settings, SettingsError};
pub use view::{Geometry, LumaView, ViewError};

use tagbus_family::Family;

/// Finds tags. Owns every buffer it needs and reuses them: after the first frames nothing is allocated.
pub struct Detector {
    detections: Vec<Detection>,
}

impl Detector {
    /// A detector for these families. Errors name the setting that is out of range.
    pub fn new(_families: &[Family], _settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self { detections: Vec::new() })
    }

    /// Finds the tags in one frame. Cannot fail: a bad frame is refused when its [`LumaView`] is made.
    pub fn detect(&mut self, _view: &LumaView) -> &[Detection] {
        &self.detections
    }
}
