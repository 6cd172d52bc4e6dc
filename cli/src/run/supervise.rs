//! Three processes that live and end together.

use std::io;
use std::process::ExitStatus;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGCHLD, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::child::{Change, Child, Role};
use crate::outcome::{Failure, Outcome, complain};

/// How long processes have for an orderly end.
const GRACE: Duration = Duration::from_millis(500);
/// How long the last frames of a file have for their way to the terminal.
const LAST_FRAMES: Duration = Duration::from_millis(300);
/// The longest sleep when nothing is due.
const LONG: Duration = Duration::from_secs(3600);

/// What a supervisor is woken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    /// Somebody wants everything to end.
    Stop,
    /// A process may have ended.
    Child,
}

/// The signals of this process, in order.
pub(super) struct Events(Receiver<Event>);

impl Events {
    /// Takes over SIGINT, SIGTERM and SIGCHLD.
    pub(super) fn start() -> io::Result<Self> {
        let mut signals = Signals::new([SIGINT, SIGTERM, SIGCHLD])?;
        let (sender, receiver) = channel();
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in signals.forever() {
                let event = if signal == SIGCHLD { Event::Child } else { Event::Stop };
                if sender.send(event).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self(receiver))
    }

    /// The next event; `None` when none came before `until`.
    fn next(&self, until: Instant) -> Option<Event> {
        match self.0.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            // Without signals nobody could end us in good order: better now.
            Err(RecvTimeoutError::Disconnected) => Some(Event::Stop),
        }
    }
}

/// Starts processes, starts those again that crash, and ends all when one ends by itself.
pub(super) struct Supervisor {
    children: [Child; 3],
    events: Events,
    end: Option<Instant>,
}

impl Supervisor {
    /// `limit` ends everything after so long.
    pub(super) fn new(children: [Child; 3], events: Events, limit: Option<Duration>) -> Self {
        let end = limit.and_then(|limit| Instant::now().checked_add(limit));
        Self { children, events, end }
    }

    /// Works until the end, and leaves no process.
    pub(super) fn work(mut self) -> Result<Outcome, Failure> {
        let outcome = self.supervise();
        self.end_all()?;
        Ok(outcome?)
    }

    fn supervise(&mut self) -> io::Result<Outcome> {
        loop {
            let now = Instant::now();
            if self.end.is_some_and(|end| end <= now) {
                return Ok(Outcome::Done);
            }
            for child in &mut self.children {
                child.start_if_due(now)?;
            }
            if self.events.next(self.next_time(now)) == Some(Event::Stop) {
                return Ok(Outcome::Done);
            }
            if let Some((role, status)) = self.look()? {
                return Ok(self.outcome_of(role, status));
            }
        }
    }

    /// When something has to be done even if nothing happens.
    fn next_time(&self, now: Instant) -> Instant {
        let due = self.children.iter().filter_map(Child::due);
        due.chain(self.end).min().unwrap_or(now + LONG)
    }

    /// Reports crashes; gives who ended by himself.
    fn look(&mut self) -> io::Result<Option<(Role, ExitStatus)>> {
        for child in &mut self.children {
            match child.look()? {
                Change::None => {}
                Change::Crashed(status) => {
                    complain(format_args!("{} ended ({status}): starting it again", child.role));
                }
                Change::Ended(status) => return Ok(Some((child.role, status))),
            }
        }
        Ok(None)
    }

    fn outcome_of(&self, role: Role, status: ExitStatus) -> Outcome {
        match status.code() {
            Some(0) => {
                if role == Role::Camera {
                    self.wait_for_last_frames();
                }
                Outcome::Done
            }
            Some(1) => Outcome::NothingFound,
            // It has said why.
            Some(2) => Outcome::Failed,
            _ => {
                complain(format_args!("{role} ended ({status})"));
                Outcome::Failed
            }
        }
    }

    fn wait_for_last_frames(&self) {
        let until = Instant::now() + LAST_FRAMES;
        while self.events.next(until) == Some(Event::Child) {}
    }

    fn end_all(&mut self) -> io::Result<()> {
        self.children.iter_mut().for_each(Child::ask_to_end);
        let until = Instant::now() + GRACE;
        while self.children.iter().any(Child::is_running) && Instant::now() < until {
            self.events.next(until);
            for child in &mut self.children {
                child.look()?;
            }
        }
        self.children.iter_mut().try_for_each(Child::kill)
    }
}
