//! Our own detector.

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Detector, Level, LumaView, Refinement, Search, Settings};
use tagbus_family::Family;

use super::{Failure, Hit, Peer};

pub(super) struct Ours {
    detector: Detector,
    settings: Settings,
}

impl Ours {
    /// Families are separated by `+`.
    pub(super) fn new(
        families: &str,
        factor: f64,
        search: Search,
        refinement: Refinement,
    ) -> Result<Self, Failure> {
        let families: Result<Vec<Family>, _> = families.split('+').map(Family::published).collect();
        let decimation = Decimation::from_factor(factor)?;
        let settings = Settings { decimation, search, refinement, ..Settings::default() };
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
        let Settings { search, refinement, .. } = self.settings;
        match search {
            Search::Quick => refinement.name().to_owned(),
            _ => format!("{} search, {}", search.name(), refinement.name()),
        }
    }

    fn detect(&mut self, picture: &Picture, hits: &mut Vec<Hit>) {
        if let Ok(view) = LumaView::grey(&picture.luma, picture.width, picture.height) {
            let found = self.detector.detect(&view);
            hits.extend(found.iter().map(|tag| Hit { id: tag.id, corners: tag.corners }));
        }
    }
}
