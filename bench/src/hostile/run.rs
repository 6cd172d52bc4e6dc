//! The run: an honest machine throughout, attackers that come and go.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use tagbus_client::control::{CameraControl, DetectorControl};
use tagbus_client::{Client, Domain};
use tagbus_family::Family;

use super::attack::{Attack, Manner, OWN};
use super::listener::Listener;
use crate::Failure;
use crate::clock::{process_ns, thread_ns};
use crate::crowd::{Machine, Part, PlayedPicture, Tally, Temper};
use crate::machine::{keep_off, pin_to};
use crate::sets;
use crate::soak::Stored;

/// Honest clients that are processes of their own.
const CLIENTS: usize = 2;
/// The thread of the honest detector in a process that it shares with that of the hostile camera.
const DETECTOR_THREAD: &str = "main of cam0";
/// Attackers come and what they do takes effect in this time.
const SETTLE: Duration = Duration::from_millis(500);
/// What takes longer than this hangs.
const PATIENCE: Duration = Duration::from_secs(20);
/// After the last attacker has gone its remains are taken away in this time.
const CLEAN_AFTER: Duration = Duration::from_secs(10);

/// What is measured how long.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    pub(crate) attacks: Vec<Attack>,
    /// Rounds; in each all attacks have their turn, each beside its tame twin.
    pub(crate) rounds: usize,
    /// Length of each measurement.
    pub(crate) seconds: f64,
    /// Frames a second.
    pub(crate) rate: u32,
    pub(crate) seed: u64,
    /// The core of the detectors, which the others are kept off.
    pub(crate) core: usize,
}

/// What the honest ones took and got in one measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Window {
    /// CPU time of the detector's thread, microseconds a message.
    pub(super) detector_us: f64,
    /// CPU time of the camera's process, microseconds a message of the detector.
    pub(super) camera_us: f64,
    /// CPU time of a client's process, microseconds a message.
    pub(super) client_us: f64,
    /// Messages that arrived.
    pub(super) received: u64,
    /// Messages that were sent but left the client's queue before it came to them.
    pub(super) missed: u64,
    /// Frames that the detector passed over.
    pub(super) skipped: u64,
    /// How often the attacker did what it does, in the whole time of its life.
    pub(super) deeds: u64,
}

/// What was measured of one attack: round by round, tame and hostile.
pub(crate) struct Attacked {
    pub(super) attack: Attack,
    pub(super) tame: Vec<Window>,
    pub(super) hostile: Vec<Window>,
}

/// What was seen.
pub(crate) struct Outcome {
    /// Without anybody else, a measurement a round.
    pub(super) quiet: Vec<Window>,
    pub(super) attacks: Vec<Attacked>,
    /// What honest clients counted from the first to the last attack, the one in this process first.
    pub(super) tallies: Vec<Tally>,
    /// Frames that the camera had no memory for.
    pub(super) no_loan: u64,
    /// Frames that the detector searched and messages that it sent.
    pub(super) searched_and_sent: [u64; 2],
    /// Before the first attack and after the last one.
    pub(super) stored: [Stored; 2],
    /// Files in shared memory after the last attack that were not there before the first.
    pub(super) left: Vec<String>,
}

/// An error is whatever ends before, ends badly, or leaves something after the end.
pub(crate) fn run(plan: &Plan) -> Result<Outcome, Failure> {
    let mut machine = Machine::new(&plan.program)?;
    let family = Family::published("tag36h11")?;
    let frame = sets::Renderer::new(sets::named("base")?, family, plan.seed).frame(0)?;
    let picture = PlayedPicture::write(machine.domain.name(), &frame.picture)?;
    start(plan, &mut machine, &picture)?;
    let mut honest = Honest { listener: Listener::start(&machine.reach("cam0", "main"))?, machine };
    // Topics of the hostile publishers stay for as long as honest ones have them open: each attack comes once before anything counts.
    for &attack in &plan.attacks {
        honest.measure(plan, Some((attack, Manner::Hostile, plan.seed)))?;
    }
    let before = honest.at_rest()?;
    let files_before = honest.machine.domain.leftovers()?;
    let mut outcome = Outcome {
        quiet: Vec::new(),
        attacks: plan.attacks.iter().map(|&attack| Attacked::new(attack)).collect(),
        tallies: Vec::new(),
        no_loan: 0,
        searched_and_sent: [0; 2],
        stored: [before, before],
        left: Vec::new(),
    };
    attack_all(plan, &mut honest, &mut outcome)?;
    outcome.stored[1] = honest.settled(&before)?;
    outcome.left = honest.machine.domain.leftovers()?;
    outcome.left.retain(|file| !files_before.contains(file));
    let statistics = DetectorControl::connect(&honest.machine.reach("cam0", "main"))?.get()?.statistics;
    outcome.searched_and_sent = [statistics.frames_searched, statistics.messages_sent];
    outcome.no_loan =
        CameraControl::connect(&honest.machine.reach("cam0", "main"))?.get()?.statistics.no_loan;
    outcome.tallies.push(honest.listener.end()?);
    let of_main = |(_, place, tally): (Part, [String; 2], Tally)| (place[1] == "main").then_some(tally);
    outcome.tallies.extend(honest.machine.end()?.into_iter().filter_map(of_main));
    Ok(outcome)
}

/// One process detects in the frames of the honest camera and in those of the hostile one; an honest client listens to the hostile
/// detector, too.
fn start(plan: &Plan, machine: &mut Machine, picture: &PlayedPicture) -> Result<(), Failure> {
    let also = flags_of_the_other(plan, machine)?;
    // Whoever is started from now on is on the core that this thread is on.
    pin_to(plan.core)?;
    machine.detector("cam0", "main", &[format!("--also={also}")])?;
    keep_off(plan.core)?;
    machine.camera("cam0", &[picture.source(), format!("--framerate={}", plan.rate)])?;
    for _ in 0..CLIENTS {
        machine.client("cam0", "main", Temper::Honest)?;
    }
    if plan.attacks.contains(&Attack::Detections) {
        machine.client("cam0", OWN, Temper::Misled)?;
    }
    Ok(())
}

/// All flags of the detector of the hostile camera, as a configuration file.
fn flags_of_the_other(plan: &Plan, machine: &Machine) -> Result<String, Failure> {
    let mut command = Command::new(&plan.program);
    command.args(["service", "--camera", OWN, "--always", "--print-config"]);
    command.args(["--domain", machine.domain.name()]).arg("--root").arg(machine.domain.root());
    let output = command.env("XDG_CONFIG_HOME", "/nonexistent").output()?;
    if !output.status.success() {
        return Err(format!("no configuration: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

fn attack_all(plan: &Plan, honest: &mut Honest, outcome: &mut Outcome) -> Result<(), Failure> {
    let bar = ProgressBar::new((plan.rounds * (1 + 2 * plan.attacks.len())) as u64);
    for round in 0..plan.rounds {
        outcome.quiet.push(honest.measure(plan, None)?);
        bar.inc(1);
        for attacked in &mut outcome.attacks {
            let mut manners = [Manner::Tame, Manner::Hostile];
            // Who comes first has no advantage.
            manners.rotate_left(round % 2);
            for manner in manners {
                let seed = plan.seed + round as u64;
                let window = honest.measure(plan, Some((attacked.attack, manner, seed)))?;
                match manner {
                    Manner::Tame => attacked.tame.push(window),
                    Manner::Hostile => attacked.hostile.push(window),
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    Ok(())
}

impl Attacked {
    fn new(attack: Attack) -> Self {
        Self { attack, tame: Vec::new(), hostile: Vec::new() }
    }
}

/// The honest machine and the client that looks.
struct Honest {
    machine: Machine,
    listener: Listener,
}

/// Counters at one moment.
struct Snapshot {
    detector_ns: u64,
    camera_ns: u64,
    clients_ns: u64,
    tally: Tally,
}

impl Honest {
    fn measure(&mut self, plan: &Plan, attack: Option<(Attack, Manner, u64)>) -> Result<Window, Failure> {
        let start = |(attack, manner, seed)| Attacker::start(&self.machine.domain, attack, manner, seed);
        let attacker = attack.map(start).transpose()?;
        thread::sleep(SETTLE);
        let before = self.look()?;
        thread::sleep(Duration::from_secs_f64(plan.seconds));
        let after = self.look()?;
        self.machine.check()?;
        let deeds = attacker.map_or(Ok(0), Attacker::end)?;
        Ok(Window { deeds, ..Window::between(&before, &after) })
    }

    fn look(&self) -> Result<Snapshot, Failure> {
        let mut snapshot =
            Snapshot { detector_ns: 0, camera_ns: 0, clients_ns: 0, tally: self.listener.tally() };
        for member in &self.machine.members {
            match member.part {
                Part::Camera => snapshot.camera_ns += process_ns(member.number())?,
                Part::Detector => snapshot.detector_ns += thread_ns(member.number(), DETECTOR_THREAD)?,
                Part::Client(_) if member.place[1] == "main" => {
                    snapshot.clients_ns += process_ns(member.number())?;
                }
                Part::Client(_) => {}
            }
        }
        Ok(snapshot)
    }

    /// Whoever comes onto the bus takes away what others left.
    fn visit(&self) -> Result<(), Failure> {
        drop(Client::connect(&self.machine.reach("cam0", "main"))?);
        Ok(())
    }

    /// What is stored once two looks agree, or after a while: on a busy machine roles are still at work on what the last attack left.
    fn at_rest(&self) -> Result<Stored, Failure> {
        let begun = Instant::now();
        let mut before = Stored::default();
        loop {
            self.visit()?;
            thread::sleep(Duration::from_millis(250));
            let now = Stored::of(&self.machine.domain)?;
            if [now.files, now.in_root] == [before.files, before.in_root] || begun.elapsed() > CLEAN_AFTER {
                return Ok(now);
            }
            before = now;
        }
    }

    /// What is stored once it is as before, or what it is after a while.
    fn settled(&self, before: &Stored) -> Result<Stored, Failure> {
        let begun = Instant::now();
        loop {
            self.visit()?;
            thread::sleep(Duration::from_millis(250));
            let now = Stored::of(&self.machine.domain)?;
            let is_as_before = now.files <= before.files && now.in_root <= before.in_root;
            if is_as_before || begun.elapsed() > CLEAN_AFTER {
                return Ok(now);
            }
        }
    }
}

impl Window {
    fn between(before: &Snapshot, after: &Snapshot) -> Self {
        let last = |snapshot: &Snapshot, count: fn(&tagbus_client::DetectionsHeader) -> u64| {
            snapshot.tally.last.as_ref().map_or(0, count)
        };
        let more = |count| last(after, count) - last(before, count);
        let messages = more(|header| header.message_number);
        let each = |from: u64, to: u64| (to - from) as f64 / 1e3 / messages.max(1) as f64;
        Self {
            detector_us: each(before.detector_ns, after.detector_ns),
            camera_us: each(before.camera_ns, after.camera_ns),
            client_us: each(before.clients_ns, after.clients_ns) / CLIENTS as f64,
            received: after.tally.received - before.tally.received,
            missed: after.tally.missed - before.tally.missed,
            skipped: more(|header| header.skipped_total),
            deeds: 0,
        }
    }
}

/// An attacker's process; killed when it is dropped.
struct Attacker(Child);

impl Attacker {
    fn start(domain: &Domain, attack: Attack, manner: Manner, seed: u64) -> Result<Self, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["attack", "--domain", domain.name(), "--seed", &seed.to_string()]);
        command.arg("--root").arg(domain.root()).args(["--attack", attack.name(), "--manner"]);
        command.arg(format!("{manner:?}").to_lowercase());
        Ok(Self(command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?))
    }

    /// How often it did what it does. An error when it failed, or does not end.
    fn end(mut self) -> Result<u64, Failure> {
        drop(self.0.stdin.take());
        let begun = Instant::now();
        let status = loop {
            match self.0.try_wait()? {
                Some(status) => break status,
                None if begun.elapsed() > PATIENCE => return Err("an attacker does not end".into()),
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        let mut words = String::new();
        if let Some(out) = &mut self.0.stdout {
            out.read_to_string(&mut words)?;
        }
        match words.trim().parse() {
            Ok(count) if status.success() => Ok(count),
            _ => Err(format!("an attacker ended with {status} and '{words}'").into()),
        }
    }
}

impl Drop for Attacker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
