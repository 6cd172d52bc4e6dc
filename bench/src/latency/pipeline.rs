//! What the bus adds to a detector: camera, detector and clients as they are, the time of the detector itself left out.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, Detections, Domain, Stop};

use crate::Failure;
use crate::crowd::{Machine, Part};
use crate::syscalls::cpu_ns;

const CAMERA: &str = "cam0";
const DETECTOR: &str = "main";
/// Camera and detector were started just before.
const PATIENCE: Duration = Duration::from_secs(30);
/// Everybody connects, buffers grow to what frames need.
const WARM_UP: Duration = Duration::from_secs(2);

/// Whom a client listens to.
#[derive(clap::Args)]
pub(crate) struct ListenOrder {
    #[arg(long)]
    domain: String,
    #[arg(long)]
    root: PathBuf,
}

/// Nanoseconds between the stamps of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hops {
    /// From the camera's sending to the detector having the frame.
    pub(super) receive: u64,
    /// Until the detector began.
    pub(super) start: u64,
    /// From the detector's end to the message's sending.
    pub(super) send: u64,
    /// Until the client had it.
    pub(super) client: u64,
}

/// One pipeline.
pub(super) struct Piped {
    /// Of each client.
    pub(super) hops: Vec<Vec<Hops>>,
    /// CPU time of camera, detector and all clients together, microseconds a frame.
    pub(super) cpu_us: [f64; 3],
}

/// What runs how long.
pub(super) struct Setting<'a> {
    pub(super) program: &'a Path,
    pub(super) size: [u32; 2],
    pub(super) rate: u32,
    pub(super) duration: Duration,
}

/// Runs a camera that shows a grey picture, a detector and so many clients.
pub(super) fn measure(setting: &Setting, clients: usize) -> Result<Piped, Failure> {
    let mut machine = Machine::new(setting.program)?;
    let picture = std::env::temp_dir().join(format!("{}.pgm", machine.domain.name()));
    fs::write(&picture, grey(setting.size))?;
    let source = format!("--source=replay:{}", picture.display());
    let started = machine.camera(CAMERA, &[source, format!("--framerate={}", setting.rate)]);
    let piped = started
        .and_then(|()| machine.detector(CAMERA, DETECTOR, &["--always".to_owned()]))
        .and_then(|()| with_clients(setting, clients, machine));
    fs::remove_file(&picture)?;
    piped
}

fn with_clients(setting: &Setting, clients: usize, mut machine: Machine) -> Result<Piped, Failure> {
    let mut listeners = Vec::new();
    for _ in 0..clients {
        listeners.push(Listener::start(&machine)?);
    }
    let mut asking = tagbus_client::control::DetectorControl::connect(&machine.reach(CAMERA, DETECTOR))?;
    thread::sleep(WARM_UP);
    listeners.iter_mut().try_for_each(Listener::begin)?;
    let cpu = |machine: &Machine, listeners: &[Listener]| -> Result<[f64; 3], Failure> {
        let of = |part: Part| machine.members.iter().filter(move |member| member.part == part);
        let sum = |numbers: &mut dyn Iterator<Item = u32>| -> io::Result<f64> {
            numbers.map(|number| Ok(cpu_ns(number)? as f64 / 1e3)).sum()
        };
        Ok([
            sum(&mut of(Part::Camera).map(crate::crowd::Member::number))?,
            sum(&mut of(Part::Detector).map(crate::crowd::Member::number))?,
            sum(&mut listeners.iter().map(|listener| listener.child.id()))?,
        ])
    };
    let (first, before) = (asking.get()?.statistics.frames_searched, cpu(&machine, &listeners)?);
    thread::sleep(setting.duration);
    let (last, after) = (asking.get()?.statistics.frames_searched, cpu(&machine, &listeners)?);
    machine.check()?;
    drop(asking);
    let hops = listeners.into_iter().map(Listener::end).collect::<Result<_, _>>()?;
    machine.end()?;
    let frames = (last - first).max(1);
    let mut cpu_us = [0.0; 3];
    for (place, share) in cpu_us.iter_mut().enumerate() {
        *share = (after[place] - before[place]) / frames as f64;
    }
    Ok(Piped { hops, cpu_us })
}

/// A flat picture as a PGM file: the detector has nothing to do but to look.
fn grey([width, height]: [u32; 2]) -> Vec<u8> {
    let mut file = format!("P5\n{width} {height}\n255\n").into_bytes();
    file.resize(file.len() + (width * height) as usize, 120);
    file
}

/// A client as a process. It is killed when it is dropped before its end.
struct Listener {
    child: Child,
}

impl Listener {
    fn start(machine: &Machine) -> Result<Self, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["latency-client", "--domain", machine.domain.name(), "--root"]);
        let command = command.arg(machine.domain.root()).stdin(Stdio::piped()).stdout(Stdio::piped());
        Ok(Self { child: command.spawn()? })
    }

    /// What comes from now on counts.
    fn begin(&mut self) -> Result<(), Failure> {
        let input = self.child.stdin.as_mut().ok_or("a client without standard input")?;
        Ok(input.write_all(&[1])?)
    }

    fn end(mut self) -> Result<Vec<Hops>, Failure> {
        drop(self.child.stdin.take());
        let mut text = String::new();
        self.child.stdout.take().ok_or("a client without standard output")?.read_to_string(&mut text)?;
        let status = self.child.wait()?;
        if !status.success() {
            return Err(format!("a client ended with {status}").into());
        }
        let hops: Option<Vec<Hops>> = text.lines().map(Hops::parse).collect();
        hops.ok_or_else(|| "a client wrote something else than figures".into())
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // It may have ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Hops {
    fn of(message: &Detections) -> Self {
        let header = message.header();
        Self {
            receive: header.receive_ns.saturating_sub(header.publish_ns),
            start: header.detect_start_ns.saturating_sub(header.receive_ns),
            send: header.send_ns.saturating_sub(header.detect_end_ns),
            client: message.client_ns().saturating_sub(header.send_ns),
        }
    }

    fn parse(line: &str) -> Option<Self> {
        let numbers: Vec<u64> = line.split(' ').map_while(|word| word.parse().ok()).collect();
        let [receive, start, send, client] = numbers[..] else { return None };
        Some(Self { receive, start, send, client })
    }

    /// What is between the frame's arrival and the client's, but for the detector.
    pub(super) fn overhead(self) -> u64 {
        self.start + self.send + self.client
    }
}

/// Listens until the standard input ends, then writes what each message took since the first byte of it.
pub(crate) fn listen(order: &ListenOrder) -> Result<(), Failure> {
    let stop = Stop::new()?;
    let at_end = stop.clone();
    let begun = Arc::new(AtomicBool::new(false));
    let begin = Arc::clone(&begun);
    thread::spawn(move || {
        let mut input = io::stdin().lock();
        begin.store(input.read_exact(&mut [0]).is_ok(), Ordering::Relaxed);
        let _ = input.read_to_end(&mut Vec::new());
        at_end.trigger();
    });
    let domain = Domain::with_root(&order.domain, &order.root)?;
    let options = ConnectOptions::in_domain(domain).camera(CAMERA).detector(DETECTOR);
    let mut client = Client::connect(&options.deadline(PATIENCE).stop(stop.clone()))?;
    let mut hops = Vec::with_capacity(1 << 16);
    let mut last = Instant::now();
    while !stop.is_triggered() {
        let Some(message) = client.receive(Duration::from_secs(1))? else {
            if last.elapsed() > PATIENCE {
                return Err("no message came".into());
            }
            continue;
        };
        last = Instant::now();
        if begun.load(Ordering::Relaxed) {
            hops.push(Hops::of(&message));
        }
    }
    let mut out = io::BufWriter::new(io::stdout().lock());
    for Hops { receive, start, send, client } in hops {
        writeln!(out, "{receive} {start} {send} {client}")?;
    }
    Ok(out.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hops_are_read_back() {
        let hops = Hops::parse("10 2 3 40").unwrap();
        assert_eq!(hops, Hops { receive: 10, start: 2, send: 3, client: 40 });
        assert_eq!(hops.overhead(), 45);
        assert!(Hops::parse("1 2 3").is_none() && Hops::parse("1 2 3 4 5").is_none());
    }
}
