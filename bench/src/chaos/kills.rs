//! The kills, one after another, and how long it takes until detections arrive again.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use indicatif::ProgressBar;
use rustix::process::Signal;
use tagbus_message::qos::CREATION_TIMEOUT;
use tagbus_scene::Stream;

use super::arrivals::Wanted;
use super::machine::{Machine, Role};
use super::moment::{Moment, boot_ns};
use super::process::{Found, signal};
use super::storage::Storage;
use crate::Failure;

/// The longest time between a recovery and the next kill.
const LONGEST_REST_MS: f64 = 250.0;
/// A role is killed within this time after it was started.
const START_UP_MS: f64 = 100.0;

/// What is to be killed how often.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    /// Kills of running roles and, if `startup`, as many of roles that are starting.
    pub(crate) kills: usize,
    pub(crate) startup: bool,
    pub(crate) clients: usize,
    pub(crate) seed: u64,
}

/// When a role is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Running,
    StartUp,
}

/// What came after one kill, in milliseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recovery {
    pub(super) role: Role,
    pub(super) kind: Kind,
    /// From its start to its kill, of a role that was starting.
    pub(super) lived_ms: Option<f64>,
    /// From the start of the next process to the first detection at a client.
    pub(super) first_ms: f64,
    /// To the first detection at the last of the clients.
    pub(super) all_ms: f64,
    /// From the kill to the first detection at a client: with the supervisor's pause.
    pub(super) silence_ms: f64,
}

/// What a run gave.
pub(crate) struct Outcome {
    pub(super) recoveries: Vec<Recovery>,
    /// Before the first kill and after the last one, while all roles work.
    pub(super) storage: [Storage; 2],
    /// All lines of the standard error.
    pub(super) complaints: Vec<String>,
}

/// Starts a machine, kills as planned and ends it. An error is whatever did not recover, was left over, ended or panicked.
pub(crate) fn run(plan: &Plan) -> Result<Outcome, Failure> {
    let machine = Machine::start(&plan.program, plan.clients)?;
    let before = settled(&machine)?;
    let mut chaos = Chaos { machine, random: Stream::new(plan.seed) };
    let kinds = chaos.kinds(plan);
    let bar = ProgressBar::new(kinds.len() as u64);
    let mut recoveries = Vec::new();
    for (number, kind) in kinds.into_iter().enumerate() {
        let killed = chaos.kill(kind);
        recoveries.push(killed.map_err(|error| format!("kill {number} ({kind:?}): {error}"))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    // What the last one left is young: iceoryx2 gives half-made things that long.
    thread::sleep(2 * CREATION_TIMEOUT);
    chaos.machine.visit()?;
    let like_before = |storage: &Storage| storage.is_like(&before);
    let after =
        chaos.machine.wait_for_storage(&format!("before the kills {before}, after them"), like_before)?;
    let complaints = chaos.machine.end()?;
    Ok(Outcome { recoveries, storage: [before, after], complaints })
}

/// Clients begin to publish what they count half a second after they connected.
const LATECOMERS: Duration = Duration::from_millis(1500);

/// What is stored once nobody makes anything any more.
fn settled(machine: &Machine) -> Result<Storage, Failure> {
    machine.visit()?;
    let last = std::cell::RefCell::new(Storage::default());
    machine.wait_for_storage("files do not settle", |now| {
        thread::sleep(LATECOMERS);
        let same = last.borrow().is_like(now);
        last.replace(now.clone());
        same
    })
}

struct Chaos {
    machine: Machine,
    random: Stream,
}

/// One recovery as it is measured.
struct Restart {
    killed_ns: u64,
    started_ns: u64,
    lived_ms: Option<f64>,
    wanted: Wanted,
}

impl Chaos {
    /// Both kinds in random order.
    fn kinds(&mut self, plan: &Plan) -> Vec<Kind> {
        let mut kinds = vec![Kind::Running; plan.kills];
        if plan.startup {
            kinds.extend(vec![Kind::StartUp; plan.kills]);
        }
        for last in (1..kinds.len()).rev() {
            kinds.swap(last, self.below(last + 1));
        }
        kinds
    }

    fn below(&mut self, limit: usize) -> usize {
        self.random.between(0.0, limit as f64) as usize
    }

    fn rest(&mut self, longest_ms: f64) -> Duration {
        Duration::from_secs_f64(self.random.between(0.0, longest_ms) / 1e3)
    }

    fn kill(&mut self, kind: Kind) -> Result<Recovery, Failure> {
        let rest = self.rest(LONGEST_REST_MS);
        thread::sleep(rest);
        let role = Role::ALL[self.below(Role::ALL.len())];
        let others = self.supervised();
        let restart = match role {
            Role::Camera | Role::Service => self.kill_supervised(role, kind)?,
            Role::Client => self.kill_client(kind)?,
            Role::Supervisor => self.kill_supervisor(kind)?,
        };
        let times = self.machine.wait(restart.wanted)?;
        self.check(role, others)?;
        let (first, last) = (times.iter().min().copied(), times.iter().max().copied());
        let of = match role {
            // What arrives at the others says nothing about this one, and it is the last that has to get something.
            Role::Client => last,
            _ => first,
        };
        let ms = |from: u64, to: Option<u64>| to.unwrap_or(u64::MAX).saturating_sub(from) as f64 / 1e6;
        Ok(Recovery {
            role,
            kind,
            lived_ms: restart.lived_ms,
            first_ms: ms(restart.started_ns, of),
            all_ms: ms(restart.started_ns, last),
            silence_ms: ms(restart.killed_ns, of),
        })
    }

    fn supervised(&self) -> [Option<Found>; 2] {
        [Role::Camera, Role::Service].map(|role| self.machine.find(role))
    }

    /// Those who were not killed are who they were, and detections go on.
    fn check(&mut self, role: Role, before: [Option<Found>; 2]) -> Result<(), Failure> {
        self.machine.check_survivors()?;
        let now = self.supervised();
        for (place, other) in [Role::Camera, Role::Service].into_iter().enumerate() {
            if role != other && role != Role::Supervisor && before[place] != now[place] {
                let (before, now) = (before[place], now[place]);
                return Err(format!(
                    "{} was {before:?} and is {now:?}, but {} was killed",
                    other.name(),
                    role.name()
                )
                .into());
            }
        }
        self.machine.wait_for_more()
    }

    /// Camera or detector: its supervisor starts it again.
    fn kill_supervised(&mut self, role: Role, kind: Kind) -> Result<Restart, Failure> {
        let mut before = self.machine.wait_for_another(role, None)?;
        let mut killed = kill_found(before);
        let mut lived_ms = None;
        if kind == Kind::StartUp {
            before = self.machine.wait_for_another(role, Some(before))?;
            self.wait_in_start(before.started_ns);
            killed = kill_found(before);
            lived_ms = Some(killed.boot_ns.saturating_sub(before.started_ns) as f64 / 1e6);
        }
        let wanted = match role {
            Role::Camera => Wanted::camera_after(killed),
            _ => Wanted::detector_after(killed),
        };
        // Found only after the detection, in most cases: looking through /proc would take time from those who start.
        self.machine.wait(wanted)?;
        let next = self.machine.wait_for_another(role, Some(before))?;
        Ok(Restart { killed_ns: killed.boot_ns, started_ns: next.started_ns, lived_ms, wanted })
    }

    fn kill_client(&mut self, kind: Kind) -> Result<Restart, Failure> {
        let number = self.below(self.machine.clients());
        self.machine.kill_client(number)?;
        let mut killed_ns = boot_ns();
        let mut lived_ms = None;
        if kind == Kind::StartUp {
            let started_ns = self.machine.restart_client(number)?;
            self.wait_in_start(started_ns);
            self.machine.kill_client(number)?;
            killed_ns = boot_ns();
            lived_ms = Some(killed_ns.saturating_sub(started_ns) as f64 / 1e6);
        }
        let started_ns = self.machine.restart_client(number)?;
        // Its process is a new one: whatever arrives there is the first.
        Ok(Restart { killed_ns, started_ns, lived_ms, wanted: Wanted::default() })
    }

    /// The next supervisor is started at once, while the kernel tells the children of the killed one to end.
    fn kill_supervisor(&mut self, kind: Kind) -> Result<Restart, Failure> {
        self.machine.kill_supervisor()?;
        let mut killed = Moment::now();
        let mut lived_ms = None;
        if kind == Kind::StartUp {
            let started_ns = self.machine.restart_supervisor()?;
            self.wait_in_start(started_ns);
            self.machine.kill_supervisor()?;
            killed = Moment::now();
            lived_ms = Some(killed.boot_ns.saturating_sub(started_ns) as f64 / 1e6);
        }
        let started_ns = self.machine.restart_supervisor()?;
        let wanted = Wanted::both_after(killed);
        Ok(Restart { killed_ns: killed.boot_ns, started_ns, lived_ms, wanted })
    }

    fn wait_in_start(&mut self, started_ns: u64) {
        let moment_ns = started_ns + self.rest(START_UP_MS).as_nanos() as u64;
        thread::sleep(Duration::from_nanos(moment_ns.saturating_sub(boot_ns())));
    }
}

/// The moment is that after the kill: its supervisor starts the next one later.
fn kill_found(found: Found) -> Moment {
    signal(found.number, Signal::KILL);
    Moment::now()
}
