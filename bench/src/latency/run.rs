//! Rounds, in each of which every way is measured once.

use std::path::PathBuf;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::figures::Times;
use super::floor::{self, Bell};
use super::noise::Noise;
use super::pipeline::{self, Hops, Setting};
use super::receiver::{Notes, Taken};
use super::sender::{self, Load};
use super::sleepers;
use super::way::Way;
use crate::Failure;

/// Wakes without a rest in each round, of each kind of floor.
const PING_PONGS: usize = 2000;

/// What is measured how long.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    pub(crate) size: [u32; 2],
    /// Numbers of receivers and of clients.
    pub(crate) clients: Vec<usize>,
    /// Of each line, over all rounds.
    pub(crate) seconds: u32,
    pub(crate) rounds: usize,
    /// Frames a second.
    pub(crate) rate: u32,
    /// Only these ways; all when empty.
    pub(crate) ways: Vec<Way>,
}

/// One way to one number of receivers, a [`Part`] each round.
pub(super) struct Line {
    pub(super) way: Way,
    pub(super) receivers: usize,
    pub(super) rounds: Vec<Part>,
}

/// What one line was in one round.
#[derive(Default)]
pub(super) struct Part {
    pub(super) taken: Vec<Taken>,
    /// Frames that were sent, times receivers.
    pub(super) expected: u64,
    /// CPU time for a frame, microseconds: of the sender, and of each receiver.
    pub(super) sender_us: f64,
    pub(super) receiver_us: f64,
}

/// Camera, detector and so many clients.
pub(super) struct PipeLine {
    pub(super) clients: usize,
    pub(super) hops: Vec<Hops>,
    /// CPU time for a frame of camera, detector and all clients together, one for each round.
    pub(super) cpu_us: Vec<[f64; 3]>,
}

/// How long nothing but a wake-up takes.
pub(super) struct Floor {
    pub(super) bell: Bell,
    /// As fast as both can.
    pub(super) at_once: Vec<u64>,
    /// At the rate of the frames.
    pub(super) rested: Vec<u64>,
}

/// How long nothing but a wake-up of so many by one call takes, at the rate of the frames.
pub(super) struct ManyFloor {
    pub(super) sleepers: usize,
    awake: Vec<u64>,
}

/// Everything that was measured.
pub(crate) struct Outcome {
    pub(super) lines: Vec<Line>,
    pub(super) pipelines: Vec<PipeLine>,
    pub(super) floors: Vec<Floor>,
    pub(super) many_floors: Vec<ManyFloor>,
    pub(super) noise: Noise,
}

impl Line {
    /// A time of all frames of all rounds.
    pub(super) fn times(&self, of: impl Fn(&Taken) -> u64) -> Times {
        Times::of(self.rounds.iter().flat_map(|round| &round.taken).map(of))
    }

    /// Frames that were sent to a receiver and did not come to it.
    pub(super) fn lost(&self) -> u64 {
        let expected: u64 = self.rounds.iter().map(|round| round.expected).sum();
        expected.saturating_sub(self.rounds.iter().map(|round| round.taken.len() as u64).sum())
    }
}

impl PipeLine {
    pub(super) fn times(&self, of: impl Fn(&Hops) -> u64) -> Times {
        Times::of(self.hops.iter().map(of))
    }
}

impl Floor {
    /// The same with and without a rest.
    pub(super) fn times(&self) -> [Times; 2] {
        [&self.at_once, &self.rested].map(|times| Times::of(times.iter().copied()))
    }
}

/// All rounds.
pub(crate) fn run(plan: &Plan) -> Result<Outcome, Failure> {
    let mut outcome = Outcome {
        lines: lines(plan),
        pipelines: plan.clients.iter().map(|&clients| PipeLine::new(clients)).collect(),
        floors: Bell::ALL.map(|bell| Floor { bell, at_once: Vec::new(), rested: Vec::new() }).into(),
        many_floors: plan.clients.iter().map(|&sleepers| ManyFloor { sleepers, awake: Vec::new() }).collect(),
        noise: Noise::begin(),
    };
    let floors = outcome.floors.len() + outcome.many_floors.len();
    let steps = outcome.lines.len() + outcome.pipelines.len() + floors;
    let bar = ProgressBar::new((steps * plan.rounds) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:40} {pos}/{len} {msg} {eta}")?);
    for round in 0..plan.rounds {
        // Nobody is always first.
        let middle = round * outcome.lines.len() / plan.rounds;
        outcome.lines.rotate_left(middle);
        for line in &mut outcome.lines {
            bar.set_message(format!("{}, {} receivers", line.way.name(), line.receivers));
            line.rounds.push(part(plan, line.way, line.receivers)?);
            bar.inc(1);
        }
        outcome.lines.rotate_right(middle);
        for pipeline in &mut outcome.pipelines {
            bar.set_message(format!("detector, {} clients", pipeline.clients));
            pipeline.measure(plan)?;
            bar.inc(1);
        }
        for floor in &mut outcome.floors {
            bar.set_message(floor.bell.name());
            floor.measure(plan)?;
            bar.inc(1);
        }
        for floor in &mut outcome.many_floors {
            bar.set_message(format!("{} sleepers", floor.sleepers));
            floor.measure(plan)?;
            bar.inc(1);
        }
        outcome.noise.look();
    }
    bar.finish_and_clear();
    outcome.noise.end();
    Ok(outcome)
}

fn lines(plan: &Plan) -> Vec<Line> {
    let ways = Way::all().into_iter().filter(|way| plan.ways.is_empty() || plan.ways.contains(way));
    let each = |way: Way| {
        let counts = plan.clients.iter().filter(move |&&receivers| way.is_worth_measuring(receivers));
        counts.map(move |&receivers| Line { way, receivers, rounds: Vec::new() })
    };
    ways.flat_map(each).collect()
}

/// Time for a line in one round.
fn share(plan: &Plan) -> Duration {
    Duration::from_secs(plan.seconds.into()) / plan.rounds.max(1) as u32
}

fn period(plan: &Plan) -> Duration {
    Duration::from_secs(1) / plan.rate.max(1)
}

/// Frames of a line in one round.
fn frames(plan: &Plan) -> u64 {
    (share(plan).as_secs_f64() * f64::from(plan.rate)).ceil() as u64
}

fn part(plan: &Plan, way: Way, receivers: usize) -> Result<Part, Failure> {
    let frames = frames(plan);
    let sent = sender::send(way, receivers, &Load { size: plan.size, frames, period: period(plan) })?;
    let receiver_us: f64 = sent.notes.iter().map(|notes| notes.cpu_us).sum();
    Ok(Part {
        expected: frames * receivers as u64,
        sender_us: sent.cpu_us / frames as f64,
        receiver_us: receiver_us / (frames * receivers as u64) as f64,
        taken: sent.notes.into_iter().flat_map(|Notes { taken, .. }| taken).collect(),
    })
}

impl PipeLine {
    fn new(clients: usize) -> Self {
        Self { clients, hops: Vec::new(), cpu_us: Vec::new() }
    }

    fn measure(&mut self, plan: &Plan) -> Result<(), Failure> {
        let setting =
            Setting { program: &plan.program, size: plan.size, rate: plan.rate, duration: share(plan) };
        let piped = pipeline::measure(&setting, self.clients)?;
        self.hops.extend(piped.hops.into_iter().flatten());
        self.cpu_us.push(piped.cpu_us);
        Ok(())
    }
}

impl Floor {
    fn measure(&mut self, plan: &Plan) -> Result<(), Failure> {
        self.at_once.extend(floor::measure(self.bell, PING_PONGS, Duration::ZERO)?);
        self.rested.extend(floor::measure(self.bell, frames(plan) as usize, period(plan))?);
        Ok(())
    }
}

impl ManyFloor {
    pub(super) fn times(&self) -> Times {
        Times::of(self.awake.iter().copied())
    }

    fn measure(&mut self, plan: &Plan) -> Result<(), Failure> {
        self.awake.extend(sleepers::measure(self.sleepers, frames(plan) as usize, period(plan))?);
        Ok(())
    }
}
