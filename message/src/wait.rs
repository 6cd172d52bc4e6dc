//! Waiting for messages, for the stop request and for time, in one place a thread.
//!
//! Below is iceoryx2's epoll and not its wait set, which asks more of the system for the same
//! ([why](../../docs/decisions/0012-waking.md)): waking takes one `epoll_wait` and nothing else. Nothing is allocated for a wait.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::fmt::Debug;
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{FileDescriptor, FileDescriptorBased, Service};
use iceoryx2_bb_linux::epoll::{
    Epoll, EpollBuilder, EpollEvent, EpollGuard, EpollWaitError, EventType, InputFlag,
};

use crate::bell::Bell;
use crate::stop::Stop;

/// The longest that the system waits; who asks for more is woken for nothing after 24 days.
const LONGEST: Duration = Duration::from_millis(i32::MAX as u64);

/// Why [`Waiter::wait`] returned. The first that applies is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// The role was asked to stop.
    Stop,
    /// The topic's bell rang, or may have rung: look whether there is something to receive.
    Event,
    /// Something else that was attached to the wait set is ready.
    Other,
    /// Nothing happened in the given time.
    TimedOut,
}

/// What one thread waits for. It leaves signals to whoever owns the process.
#[derive(Debug)]
pub struct WaitSet {
    epoll: Epoll,
}

/// Something stays attached to a wait set until this is dropped.
#[must_use]
pub struct Attached<'a> {
    _guard: EpollGuard<'a, 'a>,
}

impl WaitSet {
    /// A set that waits for nothing yet. Fails when the process has no file descriptor left.
    pub fn new() -> Result<Self, WaitError> {
        let epoll = EpollBuilder::new().set_close_on_exec(true).create();
        epoll.map(|epoll| Self { epoll }).map_err(|error| WaitError(format!("{error:?}")))
    }

    /// Wakes from now on when there is something to read.
    pub fn attach<'a, F: FileDescriptorBased>(&'a self, source: &'a F) -> Result<Attached<'a>, WaitError> {
        let attached = self.epoll.add(source.file_descriptor()).event_type(EventType::ReadyToRead).attach();
        attached.map(|guard| Attached { _guard: guard }).map_err(|error| WaitError(format!("{error:?}")))
    }

    /// As [`WaitSet::attach`], for as long as both live: the system forgets what was closed.
    pub fn keep<F: FileDescriptorBased>(&self, source: &F) -> Result<(), WaitError> {
        self.attach(source).map(std::mem::forget)
    }

    /// Wakes from now on, once for each time that the bell rang, and at once if it ever did.
    pub fn attach_bell<'a>(&'a self, bell: &'a Bell) -> Result<Attached<'a>, WaitError> {
        let source = self.epoll.add(bell.file_descriptor()).event_type(EventType::ReadyToRead);
        let attached = source.flags(InputFlag::EdgeTriggeredNotification).attach();
        attached.map(|guard| Attached { _guard: guard }).map_err(|error| WaitError(format!("{error:?}")))
    }

    /// As [`WaitSet::attach_bell`], for as long as both live.
    pub fn hear(&self, bell: &Bell) -> Result<(), WaitError> {
        self.attach_bell(bell).map(std::mem::forget)
    }

    /// Whether anything happens within the time.
    #[cfg(test)]
    pub(crate) fn is_woken(&self, timeout: Duration) -> Result<bool, WaitError> {
        let mut woken = false;
        self.wait(timeout, |_| woken = true)?;
        Ok(woken)
    }

    fn wait(&self, timeout: Duration, mut ready: impl FnMut(&EpollEvent)) -> Result<(), WaitError> {
        match self.epoll.timed_wait(|event| ready(&event), timeout.min(LONGEST)) {
            // A signal is no reason to wake, but none to go on waiting for too long either.
            Ok(_) | Err(EpollWaitError::Interrupt) => Ok(()),
            Err(error) => Err(WaitError(format!("{error:?}"))),
        }
    }
}

/// A wait set with a stop request and the bell of a topic attached.
pub struct Waiter<'a, S: Service> {
    set: &'a WaitSet,
    stop: &'a Stop,
    bell: Option<&'a Bell>,
    requests: Option<Requests<'a, S>>,
    _attached: [Option<Attached<'a>>; 2],
}

/// The listener of a control topic. It is detached for a while when requests come faster than they shall be answered.
struct Requests<'a, S: Service> {
    listener: &'a Listener<S>,
    attached: RefCell<Option<Attached<'a>>>,
    called: Cell<bool>,
}

impl<'a, S: Service> Waiter<'a, S>
where
    Listener<S>: FileDescriptorBased,
{
    /// Attaches the stop request, and the bell of a topic where there is one.
    pub fn new(set: &'a WaitSet, stop: &'a Stop, bell: Option<&'a Bell>) -> Result<Self, WaitError> {
        let attached = [Some(set.attach(stop)?), bell.map(|bell| set.attach_bell(bell)).transpose()?];
        Ok(Self { set, stop, bell, requests: None, _attached: attached })
    }

    /// Uses a set to which both are attached for good ([`WaitSet::keep`], [`WaitSet::hear`]).
    #[must_use]
    pub fn of_kept(set: &'a WaitSet, stop: &'a Stop, bell: Option<&'a Bell>) -> Self {
        Self { set, stop, bell, requests: None, _attached: [None, None] }
    }

    /// Attaches the listener of a control topic too. Its events are [`Wake::Other`] and told by [`Waiter::take_request`].
    pub fn with_requests(mut self, listener: &'a Listener<S>) -> Result<Self, WaitError> {
        let (attached, called) = (RefCell::new(None), Cell::new(false));
        self.requests = Some(Requests { listener, attached, called });
        self.resume_requests()?;
        Ok(self)
    }

    /// Whether the control topic called since this was last asked.
    pub fn take_request(&self) -> bool {
        self.requests.as_ref().is_some_and(|requests| requests.called.take())
    }

    /// Requests do not wake any more.
    pub fn pause_requests(&self) {
        if let Some(requests) = &self.requests {
            requests.attached.replace(None);
        }
    }

    /// Requests wake again; those that came meanwhile do so at once.
    pub fn resume_requests(&self) -> Result<(), WaitError> {
        if let Some(requests) = &self.requests
            && requests.attached.borrow().is_none()
        {
            requests.attached.replace(Some(self.set.attach(requests.listener)?));
        }
        Ok(())
    }

    /// Sleeps until something happens or the time is over.
    ///
    /// A bell that rang since the last wait is told at once, without sleeping: whoever receives until there is nothing more and waits
    /// again misses nothing, because a message is sent before it is rung for.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, WaitError> {
        if self.stop.is_triggered() {
            return Ok(Wake::Stop);
        }
        let (event, request, other) = self.sleep(timeout)?;
        if request && let Some(requests) = &self.requests {
            requests.called.set(true);
            drain(requests.listener)?;
        }
        Ok(match (self.stop.is_triggered(), event, other || request) {
            (true, ..) => Wake::Stop,
            (_, true, _) => Wake::Event,
            (_, _, true) => Wake::Other,
            _ => Wake::TimedOut,
        })
    }

    /// Whether the topic, the control topic or anything else is ready.
    fn sleep(&self, timeout: Duration) -> Result<(bool, bool, bool), WaitError> {
        let (mut event, mut request, mut other) = (false, false, false);
        let comes_from = |source: &EpollEvent, descriptor: &FileDescriptor| matches!(source, EpollEvent::FileDescriptor(source) if source.originates_from(descriptor));
        self.set.wait(timeout, |source| match (self.bell, &self.requests) {
            (Some(bell), _) if comes_from(source, bell.file_descriptor()) => event = true,
            (_, Some(requests)) if comes_from(source, requests.listener.file_descriptor()) => request = true,
            _ => other = true,
        })?;
        Ok((event, request, other))
    }
}

fn drain<S: Service>(listener: &Listener<S>) -> Result<(), WaitError> {
    listener.try_wait(|_| ()).map(drop).map_err(|error| WaitError(format!("{error:?}")))
}

/// The operating system refuses to wait; its word for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaitError(String);

impl fmt::Display for WaitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "waiting for messages is not possible ({}): are there file descriptors left?", self.0)
    }
}

impl std::error::Error for WaitError {}
