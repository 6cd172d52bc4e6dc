//! Processes: ours, and those that the supervisor starts, which only `/proc` knows.

use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use super::machine::Role;
use super::moment::boot_ns;

/// Unit of the kernel's start time of a process: `USER_HZ`, which is 100 on every Linux that tagbus runs on.
const TICK_NS: u64 = 10_000_000;
/// The last lines of the standard error that are shown when something goes wrong.
const LAST_LINES: usize = 40;

/// What all processes wrote to the standard error, line by line.
#[derive(Clone, Default)]
pub(super) struct Complaints(Arc<Mutex<Vec<String>>>);

impl Complaints {
    fn listen(&self, stream: impl Read + Send + 'static) {
        let lines = Arc::clone(&self.0);
        thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                lines.lock().unwrap_or_else(PoisonError::into_inner).push(line);
            }
        });
    }

    pub(super) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The end of it, for an error message.
    pub(super) fn last(&self) -> String {
        let lines = self.all();
        lines[lines.len().saturating_sub(LAST_LINES)..].join("\n")
    }
}

/// A process of ours. Both its outputs are read all the time, so that it never waits for us.
pub(super) struct Process {
    child: Child,
    /// `CLOCK_BOOTTIME` just before it was started, nanoseconds.
    pub(super) started_ns: u64,
}

impl Process {
    /// Starts it; `line` is called with each line of its standard output and its number.
    pub(super) fn start(
        mut command: Command,
        complaints: &Complaints,
        mut line: impl FnMut(u32, &str) + Send + 'static,
    ) -> io::Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let started_ns = boot_ns();
        let mut child = command.spawn()?;
        let (out, number) = (child.stdout.take(), child.id());
        if let Some(stream) = child.stderr.take() {
            complaints.listen(stream);
        }
        thread::spawn(move || {
            for text in out.into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok) {
                line(number, &text);
            }
        });
        Ok(Self { child, started_ns })
    }

    pub(super) fn number(&self) -> u32 {
        self.child.id()
    }

    /// How it ended, if it did.
    pub(super) fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    pub(super) fn kill(&mut self) -> io::Result<()> {
        self.child.kill()?;
        self.child.wait().map(drop)
    }

    /// Asks it to end and waits so long; `None` when it did not.
    pub(super) fn end(&mut self, patience: Duration) -> io::Result<Option<ExitStatus>> {
        signal(self.child.id(), Signal::TERM);
        let started = Instant::now();
        while started.elapsed() < patience {
            if let Some(status) = self.child.try_wait()? {
                return Ok(Some(status));
            }
            thread::sleep(Duration::from_millis(2));
        }
        Ok(None)
    }
}

/// Sends a signal to a process that may have ended.
pub(super) fn signal(number: u32, signal: Signal) {
    let pid = i32::try_from(number).ok().and_then(Pid::from_raw);
    // That it has ended already is what is wanted.
    let _ = pid.map(|pid| kill_process(pid, signal));
}

/// A process that somebody else started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) number: u32,
    /// `CLOCK_BOOTTIME` of its start, rounded down to 10 ms: times from there are up to 10 ms too long, never too short.
    pub(super) started_ns: u64,
}

/// The living child of `parent` with this role.
pub(super) fn child_of(parent: u32, role: Role) -> Option<Found> {
    processes().find_map(|number| {
        let (of, started_ns) = parent_and_start(number)?;
        let is_it = of == parent && words(number).get(1).is_some_and(|word| word == role.name());
        is_it.then_some(Found { number, started_ns })
    })
}

/// Living processes with this word on their command line.
pub(super) fn with_word(word: &str) -> Vec<u32> {
    processes().filter(|&number| words(number).iter().any(|found| found == word)).collect()
}

fn processes() -> impl Iterator<Item = u32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().filter_map(Result::ok);
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// A process that has ended, or is only waited for, has no command line.
fn words(number: u32) -> Vec<String> {
    let line = fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&line).split('\0').map(str::to_owned).collect()
}

/// Fields 4 and 22 of `/proc/PID/stat`; the second field is a name in parentheses that may hold anything.
fn parent_and_start(number: u32) -> Option<(u32, u64)> {
    let line = fs::read_to_string(format!("/proc/{number}/stat")).ok()?;
    let mut fields = line.rsplit_once(')')?.1.split_whitespace().skip(1);
    let parent = fields.next()?.parse().ok()?;
    let ticks: u64 = fields.nth(17)?.parse().ok()?;
    Some((parent, ticks * TICK_NS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parent_and_start_of_this_process_are_found() {
        let (parent, started_ns) = parent_and_start(std::process::id()).unwrap();
        assert_eq!(parent, std::os::unix::process::parent_id());
        assert!(started_ns <= boot_ns() && started_ns > 0);
    }
}
