//! One process of several: starting it, and what its end means.

use std::env;
use std::fmt;
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::process::{self, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use super::part::Part;

/// Pause before the first restart; doubled with each further one.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Who lived so long has not failed to start: the next pause is the first again.
const HEALTHY_AFTER: Duration = Duration::from_secs(5);
/// How long a process that was asked to end may take for it while others go on.
const PATIENCE: Duration = Duration::from_secs(2);
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

/// When processes are started again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Upkeep {
    /// When they crash. Whoever ends by himself, or only watches, has come to his end.
    Crashes,
    /// When they crash or fail: what is wrong may pass, and the others are needed.
    Failures,
}

/// A process that is running, or waits to be started.
#[derive(Debug)]
pub(super) struct Child {
    pub(super) part: Part,
    upkeep: Upkeep,
    state: State,
    pause: Duration,
}

#[derive(Debug)]
enum State {
    Due(Instant),
    Running {
        process: process::Child,
        since: Instant,
    },
    /// Was asked to end, and is started again after that or not.
    Ending {
        process: process::Child,
        asked: Instant,
        again: bool,
    },
    Ended,
}

/// What became of a process.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// It runs, or waits to be started.
    None,
    /// It crashed or failed and will be started again.
    Crashed(ExitStatus),
    /// It ended by itself, or crashed and is not started again.
    Ended(ExitStatus),
    /// It ended because it was asked to.
    Left,
}

impl Child {
    /// A process that is to be started at once.
    pub(super) fn new(part: Part, upkeep: Upkeep) -> Self {
        Self { part, upkeep, state: State::Due(Instant::now()), pause: FIRST_PAUSE }
    }

    /// When something has to be done about it even if nothing happens.
    pub(super) fn due(&self) -> Option<Instant> {
        match self.state {
            State::Due(due) => Some(due),
            State::Ending { asked, .. } => Some(asked + PATIENCE),
            State::Running { .. } | State::Ended => None,
        }
    }

    /// Whether its process lives.
    pub(super) fn is_running(&self) -> bool {
        matches!(self.state, State::Running { .. } | State::Ending { .. })
    }

    /// Whether nothing more is to be expected of it.
    pub(super) fn has_ended(&self) -> bool {
        matches!(self.state, State::Ended)
    }

    /// Whether it was asked to end for good.
    pub(super) fn is_leaving(&self) -> bool {
        matches!(self.state, State::Ending { again: false, .. })
    }

    /// Starts the process if its time has come, and kills one that does not end although it was asked to.
    pub(super) fn do_what_is_due(&mut self, now: Instant) -> io::Result<()> {
        if self.due().is_none_or(|due| due > now) {
            return Ok(());
        }
        match &mut self.state {
            State::Due(_) => {
                self.state = State::Running { process: command(&self.part)?.spawn()?, since: now }
            }
            State::Ending { process, .. } => process.kill()?,
            State::Running { .. } | State::Ended => {}
        }
        Ok(())
    }

    /// Looks whether the process has ended.
    pub(super) fn look(&mut self) -> io::Result<Change> {
        match &mut self.state {
            State::Due(_) | State::Ended => Ok(Change::None),
            State::Ending { process, again, .. } => {
                if process.try_wait()?.is_none() {
                    return Ok(Change::None);
                }
                self.state = if *again { State::Due(Instant::now()) } else { State::Ended };
                self.pause = FIRST_PAUSE;
                Ok(Change::Left)
            }
            State::Running { process, since } => {
                let Some(status) = process.try_wait()? else { return Ok(Change::None) };
                let was_healthy = since.elapsed() >= HEALTHY_AFTER;
                Ok(self.ended(status, was_healthy))
            }
        }
    }

    fn ended(&mut self, status: ExitStatus, was_healthy: bool) -> Change {
        if was_healthy {
            self.pause = FIRST_PAUSE;
        }
        if !self.is_started_again(status) {
            self.state = State::Ended;
            return Change::Ended(status);
        }
        self.state = State::Due(Instant::now() + self.pause);
        self.pause = (self.pause * 2).min(LONGEST_PAUSE);
        Change::Crashed(status)
    }

    fn is_started_again(&self, status: ExitStatus) -> bool {
        match self.upkeep {
            Upkeep::Crashes => self.part.role != Role::Watch && has_crashed(status),
            Upkeep::Failures => !status.success(),
        }
    }

    /// Asks the process to end, and never starts it again.
    pub(super) fn ask_to_end(&mut self) {
        self.ask(false);
    }

    /// From now on it is to be this: its process ends and is started again.
    pub(super) fn become_part(&mut self, part: Part) {
        self.part = part;
        self.ask(true);
    }

    fn ask(&mut self, again: bool) {
        self.state = match std::mem::replace(&mut self.state, State::Ended) {
            State::Running { process, .. } => {
                terminate(&process);
                State::Ending { process, asked: Instant::now(), again }
            }
            State::Ending { process, asked, .. } => State::Ending { process, asked, again },
            State::Due(_) | State::Ended if again => State::Due(Instant::now()),
            State::Due(_) | State::Ended => State::Ended,
        };
    }

    /// Ends the process by force.
    pub(super) fn kill(&mut self) -> io::Result<()> {
        if let State::Running { process, .. } | State::Ending { process, .. } = &mut self.state {
            process.kill()?;
            process.wait()?;
        }
        self.state = State::Ended;
        Ok(())
    }
}

fn command(part: &Part) -> io::Result<Command> {
    let mut command = Command::new(env::current_exe()?);
    // Everything that is in force is in the arguments: files have been read.
    command.arg(part.role.name()).args(&part.arguments).arg("--config=/dev/null");
    command.arg(format!("--die-with-parent={}", process::id()));
    command.stdin(Stdio::null());
    if part.role != Role::Watch {
        command.stdout(Stdio::null());
    }
    Ok(command)
}

fn terminate(process: &process::Child) {
    // The process was not waited for, so its number is still its own.
    let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
    // It may have ended already, which is what is wanted.
    let _ = pid.map(|pid| kill_process(pid, Signal::TERM));
}

fn has_crashed(status: ExitStatus) -> bool {
    status.signal().is_some() || status.code() == Some(PANICKED)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn running(role: Role, upkeep: Upkeep, script: &str) -> Child {
        let mut command = Command::new("sh");
        let process = command.args(["-c", script]).spawn().unwrap();
        let part = Part { name: "part".to_owned(), role, arguments: Vec::new(), detectors: Vec::new() };
        let mut child = Child::new(part, upkeep);
        child.state = State::Running { process, since: Instant::now() };
        child
    }

    fn change(child: &mut Child) -> Change {
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
            let mut child = running(Role::Camera, Upkeep::Crashes, script);
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
            let mut child = running(role, Upkeep::Crashes, script);
            assert!(matches!(change(&mut child), Change::Ended(_)));
            assert!(child.has_ended() && !child.is_running());
        }
    }

    #[test]
    fn of_a_whole_machine_what_fails_is_started_again_and_what_has_done_its_work_is_not() {
        let mut child = running(Role::Camera, Upkeep::Failures, "exit 2");
        assert!(matches!(change(&mut child), Change::Crashed(_)));
        let mut child = running(Role::Camera, Upkeep::Failures, "exit 0");
        assert!(matches!(change(&mut child), Change::Ended(_)));
    }

    #[test]
    fn a_process_that_is_asked_to_end_does() {
        let mut child = running(Role::Watch, Upkeep::Crashes, "sleep 100");
        child.ask_to_end();
        assert_eq!(change(&mut child), Change::Left);
        assert!(child.has_ended());
    }

    #[test]
    fn what_becomes_another_ends_and_is_due_again_and_is_killed_where_it_does_not_end() {
        let mut child =
            running(Role::Service, Upkeep::Failures, "trap '' TERM; while :; do sleep 0.05; done");
        // The shell must have set its trap.
        std::thread::sleep(Duration::from_millis(300));
        let part = Part { name: "other".to_owned(), ..child.part.clone() };
        child.become_part(part);
        child.do_what_is_due(Instant::now()).unwrap();
        assert_eq!(child.look().unwrap(), Change::None, "it has time for an orderly end");
        child.do_what_is_due(Instant::now() + PATIENCE).unwrap();
        assert_eq!(change(&mut child), Change::Left);
        assert!(child.due().is_some_and(|due| due <= Instant::now()) && child.part.name == "other");
    }
}
