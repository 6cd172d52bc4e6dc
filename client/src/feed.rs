//! One topic of one client: waiting, receiving, and opening it again when somebody removed it.

use std::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::port::ReceiveError as PortError;
use iceoryx2::prelude::{ZeroCopySend, ipc_threadsafe};
use iceoryx2::sample::Sample;

use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::ports::Input;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitError, WaitSet, Waiter, Wake};

use crate::error::{ConnectError, ReceiveError};
use crate::options::ConnectOptions;

/// The variant of iceoryx2 whose ports may move to another thread.
pub(crate) type Shared = ipc_threadsafe::Service;

/// After so long a silence a client looks for dead publishers and whether the topic is still the same.
const SILENCE: Duration = Duration::from_secs(1);
/// How long opening a topic again may take within one call.
const REOPEN: Duration = Duration::from_millis(200);
/// A connection that stays silent for so long is made anew, and again after twice the time. One that could not be completed in time, on a
/// starved machine, would be silent for ever.
const CONNECT_ANEW: Duration = Duration::from_secs(3);
const CONNECT_ANEW_LATEST: Duration = Duration::from_secs(60);

type Open<T, H> = Box<dyn Fn(&Bus<Shared>, Patience) -> Result<Input<Shared, T, H>, BusError> + Send>;

/// A topic of slices of `T` with a header `H`.
pub(crate) struct Feed<T: Debug + ZeroCopySend + 'static, H: Debug + ZeroCopySend + 'static> {
    /// `None` while the topic is gone that was open.
    input: Option<Input<Shared, T, H>>,
    open: Open<T, H>,
    /// Stop request and event of `input` are attached to it for as long as it lives.
    set: WaitSet,
    stop: Stop,
    bus: Bus<Shared>,
    limit: usize,
    /// When the last message came, or when the client last looked for the dead.
    looked: Instant,
    silence: Silence,
}

/// How long nothing has come, and from when on that may be the connection's fault.
struct Silence {
    since: Instant,
    suspect_after: Duration,
}

impl Silence {
    fn new() -> Self {
        Self { since: Instant::now(), suspect_after: CONNECT_ANEW }
    }

    /// Whether it is time to make the connection anew; said once, and again after twice the time.
    fn is_suspect(&mut self) -> bool {
        let suspect = self.since.elapsed() >= self.suspect_after;
        if suspect {
            self.since = Instant::now();
            self.suspect_after = (2 * self.suspect_after).min(CONNECT_ANEW_LATEST);
        }
        suspect
    }
}

/// A message of a feed.
pub(crate) type Message<T, H> = Sample<Shared, [T], H>;

impl<T: Debug + ZeroCopySend, H: Debug + ZeroCopySend> Feed<T, H> {
    /// Opens the topic that `open` names, as `publisher` makes it. `limit` messages may be held at once.
    pub(crate) fn connect(
        options: &ConnectOptions,
        publisher: &str,
        limit: usize,
        open: Open<T, H>,
    ) -> Result<Self, ConnectError> {
        let stop = match &options.stop {
            Some(stop) => stop.clone(),
            None => Stop::new().map_err(ConnectError::Io)?,
        };
        let explain = |error| explain(error, options, publisher);
        let bus = Bus::start(&options.domain, &format!("client of {publisher}"), &stop).map_err(explain)?;
        let patience = options.deadline.map_or(Patience::Endless, Patience::AtMost);
        let input = open(&bus, patience).map_err(explain)?;
        let set = watching(&stop, &input).map_err(ConnectError::Wait)?;
        let (looked, silence) = (Instant::now(), Silence::new());
        Ok(Self { input: Some(input), open, set, stop, bus, limit, looked, silence })
    }

    /// The next message in the queue; waits for one. `None` when the time is over or the client was stopped.
    pub(crate) fn receive(&mut self, timeout: Duration) -> Result<Option<Message<T, H>>, ReceiveError> {
        let started = Instant::now();
        loop {
            if let Some(message) = self.receive_now()? {
                (self.looked, self.silence) = (Instant::now(), Silence::new());
                return Ok(Some(message));
            }
            if self.looked.elapsed() >= SILENCE {
                self.look_around()?;
            }
            let left = timeout.saturating_sub(started.elapsed());
            if left.is_zero() || self.wait(left.min(SILENCE))? == Wake::Stop {
                return Ok(None);
            }
        }
    }

    /// The newest message in the queue, without waiting.
    pub(crate) fn newest(&mut self) -> Result<Option<Message<T, H>>, ReceiveError> {
        let Some(input) = &self.input else { return Ok(None) };
        input.newest().map_err(|error| self.explain(&error))
    }

    /// Whether the client was asked to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_triggered()
    }

    /// The place on the bus.
    pub(crate) fn bus(&self) -> &Bus<Shared> {
        &self.bus
    }

    fn receive_now(&self) -> Result<Option<Message<T, H>>, ReceiveError> {
        let Some(input) = &self.input else { return Ok(None) };
        input.receive().map_err(|error| self.explain(&error))
    }

    fn wait(&self, timeout: Duration) -> Result<Wake, ReceiveError> {
        let waiter = Waiter::<Shared>::of_kept(&self.set, &self.stop, self.input.as_ref().map(Input::bell));
        waiter.wait(timeout).map_err(ReceiveError::Wait)
    }

    /// Nobody looks for the dead by himself, and a topic that was removed by force sends nothing any more.
    fn look_around(&mut self) -> Result<(), ReceiveError> {
        self.looked = Instant::now();
        self.bus.clean_up_dead();
        match &mut self.input {
            Some(input) if input.is_current() => {
                if self.silence.is_suspect() {
                    // Without a place for a further subscriber the old connection has to do.
                    let _ = input.connect_anew();
                }
                Ok(())
            }
            _ => self.open_again(),
        }
    }

    fn open_again(&mut self) -> Result<(), ReceiveError> {
        // The old one first: iceoryx2 keeps one account a node for all topics of one name.
        self.input = None;
        match (self.open)(&self.bus, Patience::AtMost(REOPEN)) {
            Ok(input) => {
                self.set = watching(&self.stop, &input).map_err(ReceiveError::Wait)?;
                self.input = Some(input);
            }
            // Memory that is full now need not stay so.
            Err(BusError::Absent { .. } | BusError::NoRoom { .. } | BusError::Stopped) => {}
            Err(error) => return Err(ReceiveError::Bus(error)),
        }
        Ok(())
    }

    fn explain(&self, error: &PortError) -> ReceiveError {
        match error {
            PortError::ExceedsMaxBorrows => ReceiveError::Held { limit: self.limit },
            PortError::ConnectionFailure(reason) => ReceiveError::Broken(format!("{reason:?}")),
        }
    }
}

/// Attaches once what every message would otherwise pay for.
fn watching<T: Debug + ZeroCopySend, H: Debug + ZeroCopySend>(
    stop: &Stop,
    input: &Input<Shared, T, H>,
) -> Result<WaitSet, WaitError> {
    let set = WaitSet::new()?;
    set.keep(stop)?;
    set.hear(input.bell())?;
    Ok(set)
}

pub(crate) fn explain(error: BusError, options: &ConnectOptions, publisher: &str) -> ConnectError {
    match error {
        BusError::Absent { waited, .. } => ConnectError::Absent {
            publisher: publisher.to_owned(),
            domain: options.domain.name().to_owned(),
            waited,
        },
        BusError::Stopped => ConnectError::Stopped,
        other => ConnectError::Bus(other),
    }
}
