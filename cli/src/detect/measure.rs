//! Times of the detector on a picture that is in memory already.

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};
use tagbus_detector::{Detection, Detector, LumaView, Phase};

/// The phases in their order, with their names in JSON.
const PHASES: [(Phase, &str); 4] = [
    (Phase::Binarize, "binarize"),
    (Phase::Cluster, "cluster"),
    (Phase::Fit, "fit"),
    (Phase::Identify, "identify"),
];

/// What was found in a picture, and how long it took.
pub(super) struct Measured {
    pub(super) detections: Vec<Detection>,
    /// Wall time of each search.
    pub(super) detect: Vec<Duration>,
    /// CPU time of each search over all threads of the process, in which nothing else runs.
    pub(super) cpu: Vec<Duration>,
    /// Wall time of each phase, the mean over all searches.
    pub(super) phases: [Duration; 4],
}

impl Measured {
    /// Searches once to warm caches and buffers, and then `repeat` times by the clock. `repeat` is at least 1.
    pub(super) fn take(detector: &mut Detector, view: &LumaView, repeat: u32) -> Self {
        let detections = detector.detect(view).to_vec();
        let mut measured = Self { detections, detect: vec![], cpu: vec![], phases: [Duration::ZERO; 4] };
        for _ in 0..repeat {
            measured.search(detector, view);
        }
        measured.phases = measured.phases.map(|sum| sum / repeat);
        measured
    }

    fn search(&mut self, detector: &mut Detector, view: &LumaView) {
        let phases = &mut self.phases;
        let cpu_before = cpu_time();
        let start = Instant::now();
        let mut last = start;
        detector.detect_observed(view, |phase| {
            let now = Instant::now();
            phases[place(phase)] += now - last;
            last = now;
        });
        self.detect.push(start.elapsed());
        self.cpu.push(cpu_time().saturating_sub(cpu_before));
    }

    /// Each phase with its name.
    pub(super) fn named_phases(&self) -> impl Iterator<Item = (&'static str, Duration)> {
        PHASES.iter().map(|(_, name)| *name).zip(self.phases)
    }

    /// The wall time that half of the searches did not exceed.
    pub(super) fn median(&self) -> Duration {
        let mut sorted = self.detect.clone();
        sorted.sort_unstable();
        sorted.get(sorted.len() / 2).copied().unwrap_or_default()
    }
}

fn place(phase: Phase) -> usize {
    PHASES.iter().position(|(known, _)| *known == phase).unwrap_or_default()
}

fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_detector::Settings;
    use tagbus_family::Family;

    #[test]
    fn every_search_but_the_first_has_its_times_and_phases_fill_them() {
        let family = Family::published("tag16h5").unwrap();
        let mut detector = Detector::new(&[family], &Settings::default()).unwrap();
        let luma = vec![90; 320 * 240];
        let measured = Measured::take(&mut detector, &LumaView::grey(&luma, 320, 240).unwrap(), 5);
        assert_eq!((measured.detect.len(), measured.cpu.len()), (5, 5));
        let whole: Duration = measured.detect.iter().sum();
        assert!(measured.phases.iter().sum::<Duration>() * 5 <= whole + Duration::from_nanos(20));
        assert!(measured.median() > Duration::ZERO && measured.detections.is_empty());
    }
}
