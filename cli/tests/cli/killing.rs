//! kill -9 of every role, at work and at its start: the others carry on, and the next one of its kind delivers again.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, Stop};
use tagbus_scene::Stream;

use crate::support::{Bus, Running, Watchdog};

/// How often each role is killed at work, and how often at its start.
const KILLS: usize = 20;
/// A role that starts is killed within this time.
const START_MS: f64 = 100.0;
const SEED: u64 = 20_240_607;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Camera,
    Service,
    Watch,
}

const ROLES: [Role; 3] = [Role::Camera, Role::Service, Role::Watch];

impl Role {
    fn start(self, bus: &Bus) -> Running {
        match self {
            Self::Camera => bus.start("camera", &["--width=320", "--height=240", "--framerate=60"]),
            Self::Service => bus.start("service", &[]),
            Self::Watch => bus.start("watch", &["--json"]),
        }
    }
}

/// The last message, seen by a client that is never killed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Seen {
    messages: u64,
    camera_epoch: u64,
    detector_epoch: u64,
}

/// A client in a thread of this process.
struct Observer {
    seen: Arc<Mutex<Seen>>,
    stop: Stop,
    thread: Option<JoinHandle<()>>,
}

impl Observer {
    fn start(bus: &Bus) -> Self {
        let (seen, stop) = (Arc::new(Mutex::new(Seen::default())), Stop::new().unwrap());
        let options = ConnectOptions::in_domain(bus.domain.clone()).stop(stop.clone());
        let shared = Arc::clone(&seen);
        let thread = thread::spawn(move || {
            let mut client = Client::connect(&options).unwrap();
            while let Some(detections) = client.receive(Duration::MAX).unwrap() {
                let header = detections.header();
                let mut seen = shared.lock().unwrap();
                seen.messages += 1;
                (seen.camera_epoch, seen.detector_epoch) = (header.epoch, header.detector_epoch);
            }
        });
        Self { seen, stop, thread: Some(thread) }
    }

    fn seen(&self) -> Seen {
        *self.seen.lock().unwrap()
    }

    /// Waits for a message of which this holds; the watchdog ends a wait that is in vain.
    fn wait_for(&self, arrived: impl Fn(Seen) -> bool) {
        while !arrived(self.seen()) {
            assert!(!self.thread.as_ref().unwrap().is_finished(), "the client that was not killed has ended");
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn end(mut self) {
        self.stop.trigger();
        self.thread.take().unwrap().join().unwrap();
    }
}

struct Bench {
    bus: Bus,
    processes: [Running; 3],
    observer: Observer,
    random: Stream,
    times: Vec<(Role, &'static str, f64)>,
}

impl Bench {
    fn start() -> Self {
        let bus = Bus::new();
        let processes = ROLES.map(|role| role.start(&bus));
        let observer = Observer::start(&bus);
        observer.wait_for(|seen| seen.messages > 3);
        processes[Role::Watch as usize].line();
        Self { bus, processes, observer, random: Stream::new(SEED), times: Vec::new() }
    }

    fn kill_at_work(&mut self, role: Role) {
        let before = self.kill(role);
        self.restart(role);
        self.wait_for_delivery(role, before, "at work");
    }

    fn kill_at_start(&mut self, role: Role) {
        let before = self.kill(role);
        self.restart(role);
        let wait_ms = self.random.between(0.0, START_MS);
        thread::sleep(Duration::from_secs_f64(wait_ms / 1e3));
        let at_start = self.kill(role);
        self.restart(role);
        // The one that was killed at its start may have sent something already.
        let before = if role == Role::Watch { before } else { at_start };
        self.wait_for_delivery(role, before, "at start");
    }

    /// Gives what had been seen when the process was gone.
    fn kill(&mut self, role: Role) -> Seen {
        self.processes[role as usize].kill();
        // Messages that were under way are not from the next one.
        thread::sleep(Duration::from_millis(5));
        self.observer.seen()
    }

    fn restart(&mut self, role: Role) {
        self.processes[role as usize] = role.start(&self.bus);
    }

    fn wait_for_delivery(&mut self, role: Role, before: Seen, when: &'static str) {
        let started = Instant::now();
        match role {
            Role::Camera => self.observer.wait_for(|seen| seen.camera_epoch != before.camera_epoch),
            Role::Service => self.observer.wait_for(|seen| seen.detector_epoch != before.detector_epoch),
            Role::Watch => drop(self.processes[role as usize].line()),
        }
        self.times.push((role, when, started.elapsed().as_secs_f64() * 1e3));
        self.check_others(role, before);
    }

    /// The others are the same processes as before, and messages go on.
    fn check_others(&mut self, role: Role, before: Seen) {
        for other in ROLES.into_iter().filter(|&other| other != role) {
            let process = &mut self.processes[other as usize];
            assert!(process.is_alive(), "{other:?} ended with {role:?}: {}", process.all_complaints());
        }
        let now = self.observer.seen();
        self.observer.wait_for(|seen| seen.messages > now.messages);
        let now = self.observer.seen();
        assert!(
            role == Role::Camera || now.camera_epoch == before.camera_epoch,
            "{role:?}: {before:?} {now:?}"
        );
        assert!(
            role == Role::Service || now.detector_epoch == before.detector_epoch,
            "{role:?}: {before:?} {now:?}"
        );
        if role != Role::Watch {
            let watch = &self.processes[Role::Watch as usize];
            watch.lines.try_iter().count();
            watch.line();
        }
    }

    fn end(self) {
        self.observer.end();
        for mut process in self.processes {
            process.send(rustix::process::Signal::TERM);
            assert_eq!(process.wait().code(), Some(0));
        }
        self.bus.wait_until_gone();
        record(&self.times);
    }
}

/// Writes all times and prints a summary.
fn record(times: &[(Role, &str, f64)]) {
    let rows: String = times.iter().map(|(role, when, ms)| format!("{role:?},{when},{ms:.1}\n")).collect();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kill-times.csv");
    fs::write(&file, format!("role,killed,ms_from_restart_to_delivery\n{rows}")).unwrap();
    for role in ROLES {
        for when in ["at work", "at start"] {
            let of_both = |time: &&(Role, &str, f64)| time.0 == role && time.1 == when;
            let mut ms: Vec<f64> = times.iter().filter(of_both).map(|time| time.2).collect();
            ms.sort_unstable_by(f64::total_cmp);
            let (median, most) = (ms[ms.len() / 2], ms[ms.len() - 1]);
            println!(
                "{role:?} killed {when} {} times: delivers after {median:.0} ms, at most {most:.0} ms",
                ms.len()
            );
        }
    }
    println!("all times: {}", file.display());
}

#[test]
fn roles_that_are_killed_at_work_or_at_their_start_deliver_again_when_they_are_restarted() {
    let _watchdog = Watchdog::of_seconds(400, "killing");
    let mut bench = Bench::start();
    for _ in 0..KILLS {
        ROLES.into_iter().for_each(|role| bench.kill_at_work(role));
    }
    for _ in 0..KILLS {
        ROLES.into_iter().for_each(|role| bench.kill_at_start(role));
    }
    bench.end();
}
