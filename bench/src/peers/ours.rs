//! Our own detector.

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Detector, Level, LumaView, Settings};
use tagbus_family::Family;

use super::Peer;

pub(super) struct Ours {
    detector: Detector,
}

impl Ours {
    pub(super) fn new(family: &str, factor: f64) -> Result<Self, Box<dyn std::error::Error>> {
        let settings = Settings { decimation: Decimation::from_factor(factor)?, ..Settings::default() };
        Ok(Self { detector: Detector::new(&[Family::published(family)?], &settings)? })
    }
}

impl Peer for Ours {
    fn name(&self) -> String {
        format!("tagbus {} ({})", env!("CARGO_PKG_VERSION"), Level::best())
    }

    fn detect(&mut self, picture: &Picture) -> usize {
        let view = LumaView::grey(&picture.luma, picture.width, picture.height);
        view.map_or(0, |view| self.detector.detect(&view).len())
    }
}
