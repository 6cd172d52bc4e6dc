//! A number of threads on a frame: those of one detector, and as many detectors.

use std::sync::Barrier;
use std::thread;
use std::time::{Duration, Instant};

use tagbus_detector::{Detector, LumaView};

use super::cores::Cores;
use super::measure::Failure;

/// Wall times of one frame, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Walls {
    /// Of one detector whose workers keep off the caller's core.
    pub(super) pinned: f64,
    /// Of one detector whose threads the kernel puts where it likes.
    pub(super) free: f64,
    /// Of as many detectors of one thread, each on a core of its own, until the last is done. They share nothing but the picture,
    /// caches and memory: this is what the machine gives to so many threads at that time.
    pub(super) apart: f64,
}

pub(super) struct Contest {
    pinned: Detector,
    free: Detector,
    apart: Vec<Detector>,
}

impl Contest {
    /// `detector` makes one of so many threads. This thread may go where it likes afterwards.
    pub(super) fn new(
        threads: usize,
        cores: &Cores,
        detector: impl Fn(usize) -> Result<Detector, Failure>,
    ) -> Result<Self, Failure> {
        // Workers stay where the thread that starts them is kept.
        cores.keep_off_first()?;
        let pinned = detector(threads);
        cores.set_free()?;
        let apart: Result<_, Failure> = (0..threads).map(|_| detector(1)).collect();
        Ok(Self { pinned: pinned?, free: detector(threads)?, apart: apart? })
    }

    pub(super) fn detectors(&mut self) -> impl Iterator<Item = &mut Detector> {
        [&mut self.pinned, &mut self.free].into_iter().chain(&mut self.apart)
    }

    /// Searches a frame in each of the ways, after a rest.
    pub(super) fn walls(
        &mut self,
        view: &LumaView,
        cores: &Cores,
        pause: Duration,
    ) -> Result<Walls, Failure> {
        cores.set_free()?;
        thread::sleep(pause);
        let free = wall_ms(&mut self.free, view);
        cores.keep_to(0)?;
        thread::sleep(pause);
        let pinned = wall_ms(&mut self.pinned, view);
        thread::sleep(pause);
        Ok(Walls { pinned, free, apart: all_at_once_ms(&mut self.apart, view, cores)? })
    }
}

fn wall_ms(detector: &mut Detector, view: &LumaView) -> f64 {
    let start = Instant::now();
    detector.detect(view);
    start.elapsed().as_secs_f64() * 1e3
}

/// From when the first detector begins to when the last is done.
fn all_at_once_ms(detectors: &mut [Detector], view: &LumaView, cores: &Cores) -> Result<f64, Failure> {
    let all_are_awake = Barrier::new(detectors.len());
    let search = |number: usize, detector: &mut Detector| {
        let kept = cores.keep_to(number);
        all_are_awake.wait();
        let begins = Instant::now();
        detector.detect(view);
        kept.map(|()| (begins, Instant::now()))
    };
    let spans: Vec<_> = thread::scope(|scope| {
        let searches = detectors.iter_mut().enumerate();
        let searches: Vec<_> =
            searches.map(|(number, detector)| scope.spawn(move || search(number, detector))).collect();
        searches.into_iter().map(thread::ScopedJoinHandle::join).collect()
    });
    let mut whole: Option<(Instant, Instant)> = None;
    for span in spans {
        let (begins, ends) = span.map_err(|_| "a detector's thread ended before its time")??;
        let (first, last) = whole.unwrap_or((begins, ends));
        whole = Some((first.min(begins), last.max(ends)));
    }
    Ok(whole.map_or(0.0, |(first, last)| (last - first).as_secs_f64() * 1e3))
}
