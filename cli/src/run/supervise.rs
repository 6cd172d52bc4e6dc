//! Processes that live and end together.

use std::io;
use std::process::ExitStatus;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGCHLD, SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::child::{Change, Child, Role, Upkeep};
use super::part::Part;
use super::plan::Plan;
use super::reload::reload;
use crate::outcome::{Failure, Outcome, complain};

/// How long processes have for an orderly end.
const GRACE: Duration = Duration::from_millis(500);
/// How long the last frames of a file have for their way to the terminal.
const LAST_FRAMES: Duration = Duration::from_millis(300);
/// The longest sleep when nothing is due.
const LONG: Duration = Duration::from_secs(3600);
/// How often is looked whether the file of a machine was changed.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// What a supervisor is woken by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    /// Somebody wants everything to end.
    Stop,
    /// A process may have ended.
    Child,
    /// The file is to be read again.
    Reload,
}

/// The signals of this process, in order.
pub(super) struct Events(Receiver<Event>);

impl Events {
    /// Takes over SIGINT, SIGTERM, SIGCHLD and SIGHUP. Where nothing can be read again, SIGHUP ends everything, as it does when a
    /// terminal is closed.
    pub(super) fn start(is_machine: bool) -> io::Result<Self> {
        let mut signals = Signals::new([SIGINT, SIGTERM, SIGCHLD, SIGHUP])?;
        let (sender, receiver) = channel();
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in signals.forever() {
                let event = match signal {
                    SIGCHLD => Event::Child,
                    SIGHUP if is_machine => Event::Reload,
                    _ => Event::Stop,
                };
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

/// Starts processes and starts those again that crash. Ends all when one ends by itself, or, of a whole machine, when all have ended.
pub(super) struct Supervisor<'a> {
    children: Vec<Child>,
    events: Events,
    end: Option<Instant>,
    /// Of a whole machine.
    plan: Option<Plan<'a>>,
}

impl<'a> Supervisor<'a> {
    /// `limit` ends everything after so long.
    pub(super) fn new(
        parts: Vec<Part>,
        events: Events,
        limit: Option<Duration>,
        plan: Option<Plan<'a>>,
    ) -> Self {
        let upkeep = if plan.is_some() { Upkeep::Failures } else { Upkeep::Crashes };
        let end = limit.and_then(|limit| Instant::now().checked_add(limit));
        let children = parts.into_iter().map(|part| Child::new(part, upkeep)).collect();
        Self { children, events, end, plan }
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
                child.do_what_is_due(now)?;
            }
            match self.events.next(self.next_time(now)) {
                Some(Event::Stop) => return Ok(Outcome::Done),
                Some(Event::Reload) => self.reload(),
                None if self.plan.as_mut().is_some_and(Plan::has_changed) => self.reload(),
                Some(Event::Child) | None => {}
            }
            if let Some(outcome) = self.look()? {
                return Ok(outcome);
            }
        }
    }

    /// When something has to be done even if nothing happens.
    fn next_time(&self, now: Instant) -> Instant {
        let due = self.children.iter().filter_map(Child::due);
        let look = self.plan.as_ref().map(|_| now + LOOK_EVERY);
        due.chain(self.end).chain(look).min().unwrap_or(now + LONG)
    }

    fn reload(&mut self) {
        if let Some(plan) = &mut self.plan {
            reload(plan, &mut self.children);
        }
    }

    /// Reports what became of processes; gives the outcome where everything is to end.
    fn look(&mut self) -> io::Result<Option<Outcome>> {
        let mut ended = None;
        for child in &mut self.children {
            let change = child.look()?;
            let name = &child.part.name;
            match change {
                Change::None | Change::Left => {}
                Change::Crashed(status) => {
                    complain(format_args!("{name} ended ({status}): starting it again"));
                }
                Change::Ended(_) if self.plan.is_some() => complain(format_args!("{name} has ended")),
                Change::Ended(status) => ended = ended.or(Some((child.part.role, status))),
            }
        }
        if let Some((role, status)) = ended {
            return Ok(Some(self.outcome_of(role, status)));
        }
        self.children.retain(|child| self.plan.is_none() || !child.has_ended());
        Ok(self.children.is_empty().then_some(Outcome::Done))
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
