//! One request and its answer, whoever is asked.

use std::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::prelude::ZeroCopySend;

use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::control_ports::{AskError, ControlClient, Pending};
use tagbus_message::stop::Stop;

use super::error::ControlError;
use crate::error::ConnectError;
use crate::feed::{Shared, explain};
use crate::options::ConnectOptions;

/// How long an answer is waited for unless another time is set.
pub const DEFAULT_TIMEOUT: Duration = Duration::from_secs(5);

/// How often an answer is looked for: it comes between two frames, and nobody wakes who waits for it.
const LOOKING_PERIOD: Duration = Duration::from_millis(1);
/// After so long without an answer it is asked whether there is still somebody.
const DOUBT: Duration = Duration::from_millis(200);
/// How long opening a topic again may take within one request.
const REOPEN: Duration = Duration::from_millis(500);

type Open<Q, A> = Box<dyn Fn(&Bus<Shared>, Patience) -> Result<ControlClient<Shared, Q, A>, BusError> + Send>;

/// A control topic with what is needed to open it again.
pub(super) struct Exchange<Q: Debug + Copy + ZeroCopySend + 'static, A: Debug + Copy + ZeroCopySend + 'static>
{
    /// `None` while the topic is gone that was open.
    client: Option<ControlClient<Shared, Q, A>>,
    open: Open<Q, A>,
    bus: Bus<Shared>,
    stop: Stop,
    role: String,
    pub(super) timeout: Duration,
}

impl<Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> Exchange<Q, A> {
    /// Opens the topic that `open` names, and waits until `role` is there to answer.
    pub(super) fn connect(
        options: &ConnectOptions,
        role: &str,
        open: Open<Q, A>,
    ) -> Result<Self, ConnectError> {
        let stop = match &options.stop {
            Some(stop) => stop.clone(),
            None => Stop::new().map_err(ConnectError::Io)?,
        };
        let started = Instant::now();
        let explain = |error| explain(error, options, role);
        let bus = Bus::start(&options.domain, &format!("control of {role}"), &stop).map_err(explain)?;
        let patience = options.deadline.map_or(Patience::Endless, Patience::AtMost);
        let client = Some(open(&bus, patience).map_err(explain)?);
        let timeout = DEFAULT_TIMEOUT;
        let exchange = Self { client, open, bus, stop, role: role.to_owned(), timeout };
        exchange.wait_for_server(options, started)?;
        Ok(exchange)
    }

    /// The topic may be there while nobody serves it: others who ask hold it.
    fn wait_for_server(&self, options: &ConnectOptions, started: Instant) -> Result<(), ConnectError> {
        self.bus.clean_up_dead();
        while !self.is_served() {
            let waited = started.elapsed();
            if options.deadline.is_some_and(|deadline| waited >= deadline) {
                let (publisher, domain) = (self.role.clone(), options.domain.name().to_owned());
                return Err(ConnectError::Absent { publisher, domain, waited });
            }
            if self.stop.wait(10 * LOOKING_PERIOD) {
                return Err(ConnectError::Stopped);
            }
        }
        Ok(())
    }

    /// Who is asked.
    pub(super) fn role(&self) -> &str {
        &self.role
    }

    /// Sends a request and waits for its answer.
    pub(super) fn ask(&mut self, request: &Q) -> Result<A, ControlError> {
        let started = Instant::now();
        let asked = self.current()?.ask(request);
        let pending = asked.map_err(|error| match error {
            AskError::Nobody => ControlError::Gone { role: self.role.clone() },
            other => ControlError::Broken(other.to_string()),
        })?;
        let mut asked_around = started;
        loop {
            if let Some(answer) = take(&pending)? {
                return Ok(answer);
            }
            if asked_around.elapsed() >= DOUBT {
                asked_around = Instant::now();
                self.look_around()?;
            }
            let waited = started.elapsed();
            if waited >= self.timeout {
                return Err(ControlError::Silent { role: self.role.clone(), waited });
            }
            if self.stop.wait(LOOKING_PERIOD) {
                return Err(ControlError::Stopped);
            }
        }
    }

    /// The topic, opened again where it was removed by force.
    fn current(&mut self) -> Result<&ControlClient<Shared, Q, A>, ControlError> {
        if !self.client.as_ref().is_some_and(ControlClient::is_current) {
            // The old one first: iceoryx2 keeps one account a node for all topics of one name.
            self.client = None;
            let opened = (self.open)(&self.bus, Patience::AtMost(REOPEN));
            self.client = Some(opened.map_err(|error| self.gone(error))?);
        }
        self.client.as_ref().ok_or_else(|| ControlError::Gone { role: self.role.clone() })
    }

    fn is_served(&self) -> bool {
        self.client.as_ref().is_some_and(ControlClient::is_served)
    }

    /// Nobody looks for the dead by himself; after that a server that was killed does not count any more.
    fn look_around(&self) -> Result<(), ControlError> {
        self.bus.clean_up_dead();
        if self.is_served() { Ok(()) } else { Err(ControlError::Gone { role: self.role.clone() }) }
    }

    fn gone(&self, error: BusError) -> ControlError {
        match error {
            BusError::Absent { .. } => ControlError::Gone { role: self.role.clone() },
            BusError::Stopped => ControlError::Stopped,
            other => ControlError::Bus(other),
        }
    }
}

fn take<Q, A>(pending: &Pending<Shared, Q, A>) -> Result<Option<A>, ControlError>
where
    Q: Debug + Copy + ZeroCopySend,
    A: Debug + Copy + ZeroCopySend,
{
    pending.answer().map_err(|error| ControlError::Broken(format!("{error:?}")))
}
