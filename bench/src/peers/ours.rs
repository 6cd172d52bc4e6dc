//! Our own detector.

use tagbus_camera::picture::Picture;
use tagbus_detector::{Detector, Level, LumaView, Sampling, Search, Settings};
use tagbus_family::Family;

use super::{Failure, Hit, Peer};

pub(super) struct Ours {
    detector: Detector,
    settings: Settings,
}

impl Ours {
    /// Families are separated by `+`.
    pub(super) fn new(families: &str, settings: Settings) -> Result<Self, Failure> {
        let families: Result<Vec<Family>, _> = families.split('+').map(Family::published).collect();
        Ok(Self { detector: Detector::new(&families?, &settings)?, settings })
    }
}

impl Peer for Ours {
    fn name(&self) -> String {
        format!("tagbus {} ({})", env!("CARGO_PKG_VERSION"), Level::best())
    }

    fn factor(&self) -> f64 {
        self.settings.decimation.factor()
    }

    fn variant(&self) -> String {
        let Settings { search, sampling, refinement, .. } = self.settings;
        let mut words = Vec::new();
        if search != Search::Quick {
            words.push(format!("{} search", search.name()));
        }
        if sampling != Sampling::Point {
            words.push(sampling.name().to_owned());
        }
        words.push(refinement.name().to_owned());
        words.join(", ")
    }

    fn detect(&mut self, picture: &Picture, hits: &mut Vec<Hit>) {
        if let Ok(view) = LumaView::grey(&picture.luma, picture.width, picture.height) {
            let found = self.detector.detect(&view);
            hits.extend(found.iter().map(|tag| Hit { id: tag.id, corners: tag.corners }));
        }
    }
}
