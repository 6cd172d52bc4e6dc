//! The run: start, look again and again, end.

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use tagbus_client::control::{CameraControl, CameraStatistics, DetectorControl, DetectorStatistics};

use super::usage::{Stored, Usage};
use crate::Failure;
use crate::crowd::{Machine, Part, Tally, Temper};

/// Looks of a run, unless they would come more often than every two or less often than every five seconds.
const LOOKS: f64 = 360.0;

/// What runs how long.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    pub(crate) minutes: f64,
    pub(crate) clients: usize,
    /// Frames a second.
    pub(crate) rate: u32,
}

impl Plan {
    /// A quarter of the clients is slow and an eighth stuck: 4 and 2 of 16.
    fn temper(&self, client: usize) -> Temper {
        let (slow, stuck) = (self.clients / 4, self.clients / 8);
        match client {
            client if client < slow => Temper::Slow,
            client if client < slow + stuck => Temper::Stuck,
            _ => Temper::Honest,
        }
    }

    fn duration(&self) -> Duration {
        Duration::from_secs_f64(self.minutes * 60.0)
    }

    fn pause(&self) -> Duration {
        Duration::from_secs_f64((self.minutes * 60.0 / LOOKS).clamp(2.0, 5.0))
    }

    /// The first minute, of short runs the first quarter: pages that are used for the first time are not growth.
    pub(super) fn warm_up(&self) -> Duration {
        (self.duration() / 4).min(Duration::from_secs(60))
    }
}

/// One look at everything.
pub(crate) struct Look {
    /// Since all had started.
    pub(super) seconds: f64,
    /// In the order of [`Outcome::parts`].
    pub(super) usages: Vec<Usage>,
    pub(super) stored: Stored,
    pub(super) camera: CameraStatistics,
    pub(super) detector: DetectorStatistics,
}

/// What was seen.
pub(crate) struct Outcome {
    pub(super) parts: Vec<Part>,
    pub(super) looks: Vec<Look>,
    /// What each client counted.
    pub(super) tallies: Vec<(Part, Tally)>,
}

/// Starts everything, looks again and again, ends everything. An error is whatever ends before, ends badly or leaves something.
pub(crate) fn run(plan: &Plan) -> Result<Outcome, Failure> {
    let mut machine = start(plan)?;
    let mut observer = Observer::new(&machine)?;
    let parts = machine.members.iter().map(|member| member.part).collect();
    let begun = Instant::now();
    let bar = ProgressBar::new(plan.duration().as_secs());
    let mut looks = Vec::new();
    while begun.elapsed() < plan.duration() {
        thread::sleep(plan.pause());
        machine.check()?;
        looks.push(observer.look(&machine, begun)?);
        bar.set_position(begun.elapsed().as_secs());
    }
    bar.finish_and_clear();
    drop(observer);
    let tallies = machine.end()?.into_iter().map(|(part, _, tally)| (part, tally)).collect();
    Ok(Outcome { parts, looks, tallies })
}

fn start(plan: &Plan) -> Result<Machine, Failure> {
    let mut machine = Machine::new(&plan.program)?;
    let frames = ["--width=320".to_owned(), "--height=240".to_owned(), format!("--framerate={}", plan.rate)];
    machine.camera("cam0", &frames)?;
    machine.detector("cam0", "main", &[])?;
    for client in 0..plan.clients {
        machine.client("cam0", "main", plan.temper(client))?;
    }
    Ok(machine)
}

/// Connected once: whoever connects anew each time would be what changes.
struct Observer {
    camera: CameraControl,
    detector: DetectorControl,
}

impl Observer {
    fn new(machine: &Machine) -> Result<Self, Failure> {
        let options = machine.reach("cam0", "main");
        Ok(Self { camera: CameraControl::connect(&options)?, detector: DetectorControl::connect(&options)? })
    }

    fn look(&mut self, machine: &Machine, begun: Instant) -> Result<Look, Failure> {
        let usages: Result<_, _> = machine.members.iter().map(|member| Usage::of(member.number())).collect();
        Ok(Look {
            seconds: begun.elapsed().as_secs_f64(),
            usages: usages?,
            stored: Stored::of(&machine.domain)?,
            camera: self.camera.get()?.statistics,
            detector: self.detector.get()?.statistics,
        })
    }
}
