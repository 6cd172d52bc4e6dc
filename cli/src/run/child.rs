//! One process of three: starting it, and what its end means.

use std::env;
use std::fmt;
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::process::{self, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// Pause before the first restart; doubled with each further one.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Who lived so long has not failed to start: the next pause is the first again.
const HEALTHY_AFTER: Duration = Duration::from_secs(5);
/// Rust's exit code of a panic.
const PANICKED: i32 = 101;

/// What a process is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Watch,
    Service,
    Camera,
}

impl Role {
    /// The subcommand.
    fn name(self) -> &'static str {
        match self {
            Self::Watch => "watch",
            Self::Service => "service",
            Self::Camera => "camera",
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A process that is running, or waits to be started.
#[derive(Debug)]
pub(super) struct Child {
    pub(super) role: Role,
    command: Command,
    state: State,
    pause: Duration,
}

#[derive(Debug)]
enum State {
    Due(Instant),
    Running { process: process::Child, since: Instant },
    Ended,
}

/// What became of a process.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// It runs, or waits to be started.
    None,
    /// It crashed and will be started again.
    Crashed(ExitStatus),
    /// It ended by itself, or crashed and is not started again.
    Ended(ExitStatus),
}

impl Child {
    /// A process that is to be started at once with these flags.
    pub(super) fn new(role: Role, arguments: Vec<String>) -> io::Result<Self> {
        let mut command = Command::new(env::current_exe()?);
        // Everything that is in force is in the arguments: files have been read.
        command.arg(role.name()).args(arguments).arg("--config=/dev/null");
        command.arg(format!("--die-with-parent={}", process::id()));
        command.stdin(Stdio::null());
        if role != Role::Watch {
            command.stdout(Stdio::null());
        }
        Ok(Self { role, command, state: State::Due(Instant::now()), pause: FIRST_PAUSE })
    }

    /// When it is to be started, if it waits for that.
    pub(super) fn due(&self) -> Option<Instant> {
        if let State::Due(due) = self.state { Some(due) } else { None }
    }

    /// Whether its process lives.
    pub(super) fn is_running(&self) -> bool {
        matches!(self.state, State::Running { .. })
    }

    /// Starts the process if its time has come.
    pub(super) fn start_if_due(&mut self, now: Instant) -> io::Result<()> {
        if self.due().is_some_and(|due| due <= now) {
            self.state = State::Running { process: self.command.spawn()?, since: now };
        }
        Ok(())
    }

    /// Looks whether the process has ended.
    pub(super) fn look(&mut self) -> io::Result<Change> {
        let State::Running { process, since } = &mut self.state else { return Ok(Change::None) };
        let Some(status) = process.try_wait()? else { return Ok(Change::None) };
        if since.elapsed() >= HEALTHY_AFTER {
            self.pause = FIRST_PAUSE;
        }
        if self.role == Role::Watch || !has_crashed(status) {
            self.state = State::Ended;
            return Ok(Change::Ended(status));
        }
        self.state = State::Due(Instant::now() + self.pause);
        self.pause = (self.pause * 2).min(LONGEST_PAUSE);
        Ok(Change::Crashed(status))
    }

    /// Asks the process to end, and never starts it again.
    pub(super) fn ask_to_end(&mut self) {
        match &self.state {
            State::Running { process, .. } => {
                // The process was not waited for, so its number is still its own.
                let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
                // It may have ended already, which is what is wanted.
                let _ = pid.map(|pid| kill_process(pid, Signal::TERM));
            }
            State::Due(_) => self.state = State::Ended,
            State::Ended => {}
        }
    }

    /// Ends the process by force.
    pub(super) fn kill(&mut self) -> io::Result<()> {
        if let State::Running { process, .. } = &mut self.state {
            process.kill()?;
            process.wait()?;
            self.state = State::Ended;
        }
        Ok(())
    }
}

fn has_crashed(status: ExitStatus) -> bool {
    status.signal().is_some() || status.code() == Some(PANICKED)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn child(role: Role, script: &str) -> Child {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Child { role, command, state: State::Due(Instant::now()), pause: FIRST_PAUSE }
    }

    fn change(child: &mut Child) -> Change {
        child.start_if_due(Instant::now()).unwrap();
        loop {
            match child.look().unwrap() {
                Change::None => std::thread::sleep(Duration::from_millis(1)),
                change => return change,
            }
        }
    }

    #[test]
    fn what_is_killed_or_panics_is_started_again_after_longer_and_longer_pauses() {
        for script in ["kill -9 $$", "exit 101"] {
            let mut child = child(Role::Camera, script);
            let now = Instant::now();
            assert!(matches!(change(&mut child), Change::Crashed(_)));
            assert!(child.due().unwrap() >= now + FIRST_PAUSE);
            assert_eq!(child.pause, 2 * FIRST_PAUSE);
        }
    }

    #[test]
    fn what_ends_by_itself_is_not_started_again_and_neither_is_what_watches() {
        for (role, script) in
            [(Role::Camera, "exit 0"), (Role::Service, "exit 2"), (Role::Watch, "kill -9 $$")]
        {
            let mut child = child(role, script);
            assert!(matches!(change(&mut child), Change::Ended(_)));
            assert!(child.due().is_none() && !child.is_running());
        }
    }

    #[test]
    fn a_process_that_is_asked_to_end_does() {
        let mut child = child(Role::Watch, "sleep 100");
        child.start_if_due(Instant::now()).unwrap();
        child.ask_to_end();
        assert!(matches!(change(&mut child), Change::Ended(_)));
    }
}
