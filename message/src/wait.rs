//! Waiting for messages, for the stop request and for time, in one place a thread.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::fmt::Debug;
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{
    CallbackProgression, Service, SignalHandlingMode, SynchronousMultiplexing, WaitSet, WaitSetBuilder,
    WaitSetGuard,
};

use crate::stop::Stop;

/// Why [`Waiter::wait`] returned. The first that applies is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// The role was asked to stop.
    Stop,
    /// The topic's event came: there is something to receive, or its producer came or went.
    Event,
    /// Something else that was attached to the wait set is ready.
    Other,
    /// Nothing happened in the given time.
    TimedOut,
}

/// A wait set for [`Waiter`]; it leaves signals to whoever owns the process.
pub fn wait_set<S: Service>() -> Result<WaitSet<S>, WaitError> {
    WaitSetBuilder::new()
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create()
        .map_err(|error| WaitError(format!("{error:?}")))
}

/// A wait set with a stop request and the listener of a topic attached.
pub struct Waiter<'a, S: Service> {
    set: &'a WaitSet<S>,
    stop: &'a Stop,
    listener: Option<(&'a Listener<S>, WaitSetGuard<'a, 'a, S>)>,
    requests: Option<Requests<'a, S>>,
    _stop_guard: WaitSetGuard<'a, 'a, S>,
}

/// The listener of a control topic. It is detached for a while when requests come faster than they shall be answered.
struct Requests<'a, S: Service> {
    listener: &'a Listener<S>,
    guard: RefCell<Option<WaitSetGuard<'a, 'a, S>>>,
    called: Cell<bool>,
}

impl<'a, S: Service> Waiter<'a, S>
where
    Listener<S>: SynchronousMultiplexing + Debug,
{
    /// Attaches the stop request, and the listener of a topic where there is one.
    pub fn new(
        set: &'a WaitSet<S>,
        stop: &'a Stop,
        listener: Option<&'a Listener<S>>,
    ) -> Result<Self, WaitError> {
        let attach_error = |error| WaitError(format!("{error:?}"));
        let stop_guard = set.attach_notification(stop).map_err(attach_error)?;
        let listener = match listener {
            Some(listener) => Some((listener, set.attach_notification(listener).map_err(attach_error)?)),
            None => None,
        };
        Ok(Self { set, stop, listener, requests: None, _stop_guard: stop_guard })
    }

    /// Attaches the listener of a control topic too. Its events are [`Wake::Other`] and told by [`Waiter::take_request`].
    pub fn with_requests(mut self, listener: &'a Listener<S>) -> Result<Self, WaitError> {
        let (guard, called) = (RefCell::new(None), Cell::new(false));
        self.requests = Some(Requests { listener, guard, called });
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
            requests.guard.replace(None);
        }
    }

    /// Requests wake again; those that came meanwhile do so at once.
    pub fn resume_requests(&self) -> Result<(), WaitError> {
        if let Some(requests) = &self.requests
            && requests.guard.borrow().is_none()
        {
            let guard = self.set.attach_notification(requests.listener);
            requests.guard.replace(Some(guard.map_err(|error| WaitError(format!("{error:?}")))?));
        }
        Ok(())
    }

    /// Sleeps until something happens or the time is over. Events of the topic are taken from its queue.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, WaitError> {
        if self.stop.is_triggered() {
            return Ok(Wake::Stop);
        }
        let (mut event, mut request, mut other) = (false, false, false);
        let requests = self.requests.as_ref().map(|requests| requests.guard.borrow());
        let requests = requests.as_ref().and_then(|guard| guard.as_ref());
        let outcome = self.set.wait_and_process_once_with_timeout(
            |id| {
                match (&self.listener, requests) {
                    (Some((_, guard)), _) if id.has_event_from(guard) => event = true,
                    (_, Some(guard)) if id.has_event_from(guard) => request = true,
                    _ => other = true,
                }
                CallbackProgression::Continue
            },
            timeout,
        );
        outcome.map_err(|error| WaitError(format!("{error:?}")))?;
        if event {
            drain(self.listener.as_ref().map(|(listener, _)| *listener))?;
        }
        if request && let Some(requests) = &self.requests {
            requests.called.set(true);
            drain(Some(requests.listener))?;
        }
        Ok(match (self.stop.is_triggered(), event, other || request) {
            (true, ..) => Wake::Stop,
            (_, true, _) => Wake::Event,
            (_, _, true) => Wake::Other,
            _ => Wake::TimedOut,
        })
    }
}

fn drain<S: Service>(listener: Option<&Listener<S>>) -> Result<(), WaitError> {
    match listener {
        Some(listener) => {
            listener.try_wait(|_| ()).map_err(|error| WaitError(format!("{error:?}"))).map(drop)
        }
        None => Ok(()),
    }
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
