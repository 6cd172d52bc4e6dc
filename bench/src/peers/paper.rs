//! The paper's pipeline as it is written (the crate tagbus-paper), slow and plain.

use tagbus_camera::picture::Picture;
use tagbus_family::Family;
use tagbus_paper::{Counts, Options, Outcome, Phase, Pipeline};

use super::{Failure, Hit, Peer};
use crate::clock::now_us;

pub(crate) struct Paper {
    pipeline: Pipeline,
    options: Options,
    variant: String,
    picture: Option<tagbus_paper::Picture>,
    work: Work,
}

/// What a search took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    /// CPU time of each of [`Phase::ALL`], microseconds.
    pub(crate) phases_us: [f64; Phase::ALL.len()],
    pub(crate) counts: Counts,
}

impl Work {
    /// The quicker of both in each phase; counts are the same in every round.
    pub(crate) fn quicker(self, other: Work) -> Work {
        let mut quicker = self;
        for (own, other) in quicker.phases_us.iter_mut().zip(other.phases_us) {
            *own = own.min(other);
        }
        quicker
    }
}

impl Paper {
    pub(crate) fn new(family: &str, options: Options, variant: &str) -> Result<Self, Failure> {
        let pipeline = Pipeline::new(&[Family::published(family)?], options)?;
        Ok(Self { pipeline, options, variant: variant.to_owned(), picture: None, work: Work::default() })
    }

    /// What the last search took.
    pub(crate) fn work(&self) -> Work {
        self.work
    }

    /// The search, with the clock read after every phase.
    fn observed(&mut self, picture: &tagbus_paper::Picture) -> Outcome {
        let mut phases_us = [0.0; Phase::ALL.len()];
        let mut before = now_us();
        let outcome = self.pipeline.detect_observed(picture, |phase| {
            let now = now_us();
            phases_us[phase as usize] = now - before;
            before = now;
        });
        self.work = Work { phases_us, counts: outcome.counts };
        outcome
    }
}

impl Peer for Paper {
    fn name(&self) -> String {
        "the paper, plainly".to_owned()
    }

    fn factor(&self) -> f64 {
        self.options.decimation as f64
    }

    fn variant(&self) -> String {
        self.variant.clone()
    }

    fn prepare(&mut self, picture: &Picture) -> Result<(), Failure> {
        let Picture { width, height, luma } = picture;
        self.picture = Some(tagbus_paper::Picture::new(*width, *height, luma.clone())?);
        Ok(())
    }

    /// Searches the picture that was prepared.
    fn detect(&mut self, _picture: &Picture, hits: &mut Vec<Hit>) {
        if let Some(picture) = self.picture.take() {
            let found = self.observed(&picture).detections;
            hits.extend(found.iter().map(|tag| Hit { id: tag.id, corners: tag.corners }));
            self.picture = Some(picture);
        }
    }
}
