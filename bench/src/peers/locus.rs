//! locus-core, on one thread.

use locus_core::{Detector, DetectorConfig, ImageView, TagFamily};
use tagbus_camera::picture::Picture;

use super::{Hit, Peer};

/// The profiles that the crate ships.
pub(super) const PROFILES: [&str; 3] = ["standard", "grid", "high_accuracy"];

pub(super) struct Locus {
    detector: Detector,
    profile: &'static str,
    factor: usize,
}

impl Locus {
    /// `None` for families that the crate does not have.
    pub(super) fn new(family: &str, profile: &'static str, factor: usize) -> Option<Self> {
        let family = match family {
            "tag36h11" => TagFamily::AprilTag36h11,
            "tag16h5" => TagFamily::AprilTag16h5,
            _ => return None,
        };
        let builder = Detector::builder().with_config(DetectorConfig::from_profile(profile));
        let detector = builder.with_family(family).with_decimation(factor).with_threads(1).build();
        Some(Self { detector, profile, factor })
    }
}

impl Peer for Locus {
    fn name(&self) -> String {
        "locus-core 0.10".to_owned()
    }

    fn factor(&self) -> f64 {
        self.factor as f64
    }

    fn variant(&self) -> String {
        self.profile.to_owned()
    }

    fn detect(&mut self, picture: &Picture, hits: &mut Vec<Hit>) {
        let Ok(view) = ImageView::new(&picture.luma, picture.width, picture.height, picture.width) else {
            return;
        };
        if let Ok(found) = self.detector.detect(&view, None, None, false) {
            hits.extend(
                found.reassemble_owned().into_iter().map(|tag| Hit { id: tag.id, corners: tag.corners }),
            );
        }
    }
}
