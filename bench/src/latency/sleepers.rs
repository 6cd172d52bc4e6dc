//! The least that waking many processes takes on this machine: one eventfd, and sleepers that do nothing but note when they woke.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{EventfdFlags, Timespec, epoll, eventfd};
use tagbus_message::clock::monotonic_ns;

use crate::Failure;

/// Wakes at the start that count for nothing.
const WARM_UP: usize = 20;
/// A sleeper that is not woken for so long ends.
const SILENCE: Timespec = Timespec { tv_sec: 1, tv_nsec: 0 };
/// What a sleeper writes when it may be woken.
const READY: &str = "READY";

/// What it took each sleeper to wake each time, nanoseconds; a time that two rings share counts for the first.
pub(super) fn measure(sleepers: usize, count: usize, period: Duration) -> Result<Vec<u64>, Failure> {
    let bell = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
    let start = || Sleeper::start(Stdio::from(bell.try_clone()?));
    let sleepers = (0..sleepers).map(|_| start()).collect::<Result<Vec<_>, Failure>>()?;
    let (mut rings, mut next) = (Vec::new(), Instant::now());
    for _ in 0..WARM_UP + count {
        next += period;
        thread::sleep(next.saturating_duration_since(Instant::now()));
        // Sleepers do not read: then the bell would be silent to those who come to look later.
        let _ = rustix::io::read(&bell, &mut [0; 8]);
        rings.push(monotonic_ns());
        rustix::io::write(&bell, &1_u64.to_ne_bytes())?;
    }
    let wakes = sleepers.into_iter().map(Sleeper::end).collect::<Result<Vec<_>, Failure>>()?;
    Ok(wakes.iter().flat_map(|wakes| delays(&rings, wakes)).collect())
}

/// From each ring to the first wake before the next one.
fn delays(rings: &[u64], wakes: &[u64]) -> Vec<u64> {
    let mut delays = Vec::with_capacity(rings.len());
    for (place, &ring) in rings.iter().enumerate().skip(WARM_UP) {
        let end = rings.get(place + 1).copied().unwrap_or(u64::MAX);
        let first = wakes.get(wakes.partition_point(|&wake| wake < ring));
        delays.extend(first.filter(|&&wake| wake < end).map(|wake| wake - ring));
    }
    delays
}

/// A process. It is killed when it is dropped before its end.
struct Sleeper {
    child: Child,
    out: BufReader<ChildStdout>,
}

impl Sleeper {
    /// It sleeps when this returns.
    fn start(bell: Stdio) -> Result<Self, Failure> {
        let mut command = Command::new(std::env::current_exe()?);
        let mut child = command.arg("latency-sleeper").stdin(bell).stdout(Stdio::piped()).spawn()?;
        let out = child.stdout.take().ok_or("a sleeper without standard output")?;
        let (mut sleeper, mut line) = (Self { child, out: BufReader::new(out) }, String::new());
        sleeper.out.read_line(&mut line)?;
        if line.trim() == READY { Ok(sleeper) } else { Err("a sleeper does not begin".into()) }
    }

    /// When it woke.
    fn end(mut self) -> Result<Vec<u64>, Failure> {
        let mut text = String::new();
        self.out.read_to_string(&mut text)?;
        let wakes: Result<Vec<u64>, _> = text.lines().map(str::parse).collect();
        Ok(wakes?)
    }
}

impl Drop for Sleeper {
    fn drop(&mut self) {
        // It may have ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Notes when the standard input, an eventfd, has woken it, until it is silent; then writes that.
pub(crate) fn sleep() -> Result<(), Failure> {
    let (set, bell) = (epoll::create(epoll::CreateFlags::CLOEXEC)?, io::stdin());
    epoll::add(&set, &bell, epoll::EventData::new_u64(0), epoll::EventFlags::IN | epoll::EventFlags::ET)?;
    let mut events = Vec::with_capacity(1);
    let mut wakes: Vec<u64> = Vec::with_capacity(1 << 16);
    println!("{READY}");
    loop {
        events.clear();
        epoll::wait(&set, rustix::buffer::spare_capacity(&mut events), Some(&SILENCE))?;
        if events.is_empty() {
            break;
        }
        wakes.push(monotonic_ns());
    }
    let mut out = io::BufWriter::new(io::stdout().lock());
    wakes.iter().try_for_each(|wake| writeln!(out, "{wake}"))?;
    Ok(out.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wake_belongs_to_the_ring_before_it() {
        let rings: Vec<u64> = (0..WARM_UP as u64 + 3).map(|place| 1000 * place).collect();
        let first = 1000 * WARM_UP as u64;
        let wakes = [5, first + 30, first + 40, first + 2070];
        assert_eq!(delays(&rings, &wakes), [30, 70]);
        assert!(delays(&rings, &[]).is_empty());
    }
}
