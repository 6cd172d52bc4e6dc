//! The control topic of a role: one server that answers between frames, a few clients that ask.
//!
//! It is a request-response service and an event service of one name; the event wakes the server. A client looks for its
//! answer every now and then instead of being woken: a wake-up would cost the detector's thread some microseconds for
//! every client that is connected, and a change waits for the end of a frame anyway.
//!
//! Nobody can stall the server: each client has room for one request, of which a newer one takes the place; requests are
//! taken in rounds, in which each client has its turn once; a client that never takes its answers loses them.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt;
use std::fmt::Debug;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{
    BackpressureStrategy, CallbackProgression, EventId, MessagingPattern, PortFactory, Service, ServiceName,
    ZeroCopySend,
};
use iceoryx2::service::port_factory::event::PortFactory as EventService;
use iceoryx2::service::port_factory::request_response::PortFactory as AskService;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::bus::{Bus, BusError, Part, Patience};
use crate::control::{CameraReply, CameraRequest, DetectorReply, DetectorRequest};
use crate::description::Description;
use crate::held::Held;
use crate::ports::{describe_types, remember, service_name};
use crate::qos;
use crate::room::{self, MORE_ROOM, SHARED_MEMORY};
use crate::sweep;
use crate::topics;

/// One role answers, and one listener wakes it.
const MAX_SERVERS: usize = 1;

type Round<S, Q, A> = VecDeque<ActiveRequest<S, Q, (), A, ()>>;
type Services<S, Q, A> = (AskService<S, Q, (), A, ()>, EventService<S>);
type Answering<S, Q, A> = (Server<S, Q, (), A, ()>, Listener<S>, Services<S, Q, A>);
type Asking<S, Q, A> = (Client<S, Q, (), A, ()>, Notifier<S>, Services<S, Q, A>);

/// A control topic, seen from the role that answers.
#[derive(Debug)]
pub struct ControlServer<
    S: Service,
    Q: Debug + Copy + ZeroCopySend + 'static,
    A: Debug + Copy + ZeroCopySend + 'static,
> {
    /// Requests of this round that were not handled yet. While one of a client is here, no further one is taken of it.
    round: RefCell<Round<S, Q, A>>,
    held: Held<Answering<S, Q, A>>,
    _bus: Bus<S>,
}

/// A control topic, seen from one who asks.
#[derive(Debug)]
pub struct ControlClient<
    S: Service,
    Q: Debug + Copy + ZeroCopySend + 'static,
    A: Debug + Copy + ZeroCopySend + 'static,
> {
    held: Held<Asking<S, Q, A>>,
    bus: Bus<S>,
}

/// The control topic of a detector, from its own side.
pub type DetectorDesk<S> = ControlServer<S, DetectorRequest, DetectorReply>;
/// The control topic of a detector, from a client's side.
pub type DetectorAsker<S> = ControlClient<S, DetectorRequest, DetectorReply>;
/// The control topic of a camera, from its own side.
pub type CameraDesk<S> = ControlServer<S, CameraRequest, CameraReply>;
/// The control topic of a camera, from a client's side.
pub type CameraAsker<S> = ControlClient<S, CameraRequest, CameraReply>;

/// One request, to be answered.
#[derive(Debug)]
pub struct Asked<S: Service, Q: Debug + ZeroCopySend + 'static, A: Debug + ZeroCopySend + 'static> {
    active: ActiveRequest<S, Q, (), A, ()>,
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> ControlServer<S, Q, A> {
    /// The next request that somebody waits for, without waiting.
    pub fn next(&self) -> Result<Option<Asked<S, Q, A>>, ReceiveError> {
        let mut round = self.round.borrow_mut();
        if round.is_empty() {
            self.begin_round(&mut round)?;
        }
        Ok(round.pop_front().map(|active| Asked { active }))
    }

    /// Takes at most one request of each client.
    fn begin_round(&self, round: &mut Round<S, Q, A>) -> Result<(), ReceiveError> {
        // Requests that nobody waits for any more count too: a client that only sends must not keep this loop busy.
        for _ in 0..2 * qos::MAX_CONTROL_CLIENTS {
            match self.held.get().0.receive() {
                Ok(Some(active)) if active.is_connected() => round.push_back(active),
                Ok(Some(_given_up)) => {}
                Ok(None) | Err(ReceiveError::ExceedsMaxBorrows) => break,
                Err(error) if round.is_empty() => return Err(error),
                Err(_) => break,
            }
        }
        Ok(())
    }

    /// What wakes when somebody asks.
    #[must_use]
    pub fn listener(&self) -> &Listener<S> {
        &self.held.get().1
    }
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> Asked<S, Q, A> {
    /// The request, copied out of shared memory: to be checked before it is believed.
    #[must_use]
    pub fn request(&self) -> Q {
        *self.active.payload()
    }

    /// Answers. That the answer reaches nobody is the client's loss: it has gone, or never takes its answers, or shared memory is full.
    pub fn answer(self, reply: &A) {
        if room::is_short() {
            return;
        }
        let _ = self.active.send_copy(*reply);
    }
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> ControlClient<S, Q, A> {
    /// Sends a request and wakes the server.
    pub fn ask(&self, request: &Q) -> Result<Pending<S, Q, A>, AskError> {
        if room::is_short() {
            return Err(AskError::NoRoom);
        }
        let pending = self.held.get().0.send_copy(*request).map_err(|error| AskError::broken(&error))?;
        if pending.number_of_server_connections() == 0 {
            return Err(AskError::Nobody);
        }
        self.held.get().1.notify().map_err(|error| AskError::broken(&error))?;
        Ok(Pending { pending })
    }

    /// Whether there is a server. One that was killed counts until its remains are cleaned up.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.held.get().2.0.dynamic_config().number_of_servers() > 0
    }

    /// Whether the topic of this name is still the one that was opened; see [`crate::ports::Input::is_current`].
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.held.is_current()
    }

    /// The place on the bus that the topic was opened from.
    #[must_use]
    pub fn bus(&self) -> &Bus<S> {
        &self.bus
    }
}

/// Why a request could not be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AskError {
    /// Nobody is there to answer.
    Nobody,
    /// Shared memory is full.
    NoRoom,
    /// The connection is broken; iceoryx2's word for it.
    Broken(String),
}

impl AskError {
    fn broken(error: &impl Debug) -> Self {
        Self::Broken(format!("{error:?}"))
    }
}

impl fmt::Display for AskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nobody => write!(f, "nobody is there to answer"),
            Self::NoRoom => write!(f, "{SHARED_MEMORY} is full; {MORE_ROOM}"),
            Self::Broken(reason) => write!(f, "the connection is broken ({reason})"),
        }
    }
}

impl std::error::Error for AskError {}

/// A request that was sent; dropped, nobody waits for its answer any more, and it may not be handled at all.
#[derive(Debug)]
pub struct Pending<S: Service, Q: Debug + ZeroCopySend + 'static, A: Debug + ZeroCopySend + 'static> {
    pending: PendingResponse<S, Q, (), A, ()>,
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> Pending<S, Q, A> {
    /// The answer, copied out of shared memory, once it has come: to be checked before it is believed.
    pub fn answer(&self) -> Result<Option<A>, ReceiveError> {
        Ok(self.pending.receive()?.map(|response| *response))
    }
}

impl<S: Service> Bus<S> {
    /// Makes the control topic of a detector.
    pub fn create_detector_control(&self, camera: &str, detector: &str) -> Result<DetectorDesk<S>, BusError> {
        self.control_server(&topics::detector_control(camera, detector)?)
            .map_err(|error| name_the_other(self, error, "detector", detector))
    }

    /// Opens the control topic of a detector.
    pub fn open_detector_control(
        &self,
        camera: &str,
        detector: &str,
        patience: Patience,
    ) -> Result<DetectorAsker<S>, BusError> {
        self.control_client(&topics::detector_control(camera, detector)?, patience)
    }

    /// Makes the control topic of a camera.
    pub fn create_camera_control(&self, camera: &str) -> Result<CameraDesk<S>, BusError> {
        self.control_server(&topics::camera_control(camera)?)
            .map_err(|error| name_the_other(self, error, "camera", camera))
    }

    /// Opens the control topic of a camera.
    pub fn open_camera_control(&self, camera: &str, patience: Patience) -> Result<CameraAsker<S>, BusError> {
        self.control_client(&topics::camera_control(camera)?, patience)
    }

    fn control_server<Q, A>(&self, topic: &str) -> Result<ControlServer<S, Q, A>, BusError>
    where
        Q: Debug + Copy + ZeroCopySend,
        A: Debug + Copy + ZeroCopySend,
    {
        loop {
            if let Some(server) = self.try_control_server(topic)? {
                return Ok(server);
            }
        }
    }

    /// `None` when the topic had to be forgotten, because a place of which it has one is taken by nobody.
    fn try_control_server<Q, A>(&self, topic: &str) -> Result<Option<ControlServer<S, Q, A>>, BusError>
    where
        Q: Debug + Copy + ZeroCopySend,
        A: Debug + Copy + ZeroCopySend,
    {
        let name = service_name(topic)?;
        let (produce, patience) = (Part::Producer, Patience::Endless);
        let ask = self
            .persist(topic, produce, patience, || self.control_service(&name))
            .map_err(|error| explain::<S, Q, A>(self, error, &name))?;
        let events = self.persist(topic, produce, patience, || {
            self.node()
                .service_builder(&name)
                .event()
                .max_nodes(qos::MAX_NODES)
                .max_listeners(MAX_SERVERS)
                .max_notifiers(qos::MAX_CONTROL_CLIENTS)
                .event_id_max_value(qos::EVENT_MAX)
                .open_or_create()
        })?;
        let server = self.persist(topic, produce, patience, || {
            ask.server_builder()
                .max_loaned_responses_per_request(1)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        });
        let server = match server {
            Err(BusError::Crowded { .. }) if self.is_haunted(|| servers_of(&ask), MAX_SERVERS) => {
                self.forget(&sweep::description_of(self.domain(), ask.service_hash().as_str()))?;
                return Ok(None);
            }
            made => made?,
        };
        let listener = self.persist(topic, produce, patience, || events.listener_builder().create());
        let listener = match listener {
            Err(BusError::Crowded { .. }) if self.is_haunted(|| listeners_of(&events), MAX_SERVERS) => {
                self.forget(&sweep::description_of(self.domain(), events.service_hash().as_str()))?;
                return Ok(None);
            }
            made => made?,
        };
        let round = RefCell::new(VecDeque::with_capacity(2 * qos::MAX_CONTROL_CLIENTS));
        let described = described(&ask, &events, self);
        let held = Held::new((server, listener, (ask, events)), described, self.domain());
        Ok(Some(ControlServer { round, held, _bus: self.clone() }))
    }

    /// Fire and forget stays on, because with it iceoryx2 hands over every request, also one that nobody waits for any
    /// more; without it such requests are skipped within a loop of its own that a client which only sends could prolong.
    fn control_service<Q, A>(
        &self,
        name: &ServiceName,
    ) -> Result<
        AskService<S, Q, (), A, ()>,
        iceoryx2::service::builder::request_response::RequestResponseOpenOrCreateError,
    >
    where
        Q: Debug + Copy + ZeroCopySend,
        A: Debug + Copy + ZeroCopySend,
    {
        self.node()
            .service_builder(name)
            .request_response::<Q, A>()
            .max_nodes(qos::MAX_NODES)
            .max_servers(MAX_SERVERS)
            .max_clients(qos::MAX_CONTROL_CLIENTS)
            .max_active_requests_per_client(1)
            .max_loaned_requests(1)
            .max_response_buffer_size(1)
            .max_borrowed_responses_per_pending_response(1)
            .enable_safe_overflow_for_requests(true)
            .enable_safe_overflow_for_responses(true)
            .enable_fire_and_forget_requests(true)
            .open_or_create()
    }

    fn control_client<Q, A>(
        &self,
        topic: &str,
        patience: Patience,
    ) -> Result<ControlClient<S, Q, A>, BusError>
    where
        Q: Debug + Copy + ZeroCopySend,
        A: Debug + Copy + ZeroCopySend,
    {
        let name = service_name(topic)?;
        let consume = Part::Consumer;
        let ask = self
            .persist(topic, consume, patience, || {
                self.node().service_builder(&name).request_response::<Q, A>().open()
            })
            .map_err(|error| explain::<S, Q, A>(self, error, &name))?;
        let events =
            self.persist(topic, consume, patience, || self.node().service_builder(&name).event().open())?;
        let client = self.persist(topic, consume, patience, || {
            ask.client_builder().backpressure_strategy(BackpressureStrategy::DiscardData).create()
        })?;
        let notifier = self.persist(topic, consume, patience, || {
            events.notifier_builder().default_event_id(EventId::new(qos::EVENT_SENT)).create()
        })?;
        let described = described(&ask, &events, self);
        let held = Held::new((client, notifier, (ask, events)), described, self.domain());
        Ok(ControlClient { held, bus: self.clone() })
    }
}

fn described<S: Service, Q, A>(
    ask: &AskService<S, Q, (), A, ()>,
    events: &EventService<S>,
    bus: &Bus<S>,
) -> [Description; 2]
where
    Q: Debug + Copy + ZeroCopySend,
    A: Debug + Copy + ZeroCopySend,
{
    [remember(ask, MessagingPattern::RequestResponse, bus), remember(events, MessagingPattern::Event, bus)]
}

/// Nodes of the servers that a topic names.
fn servers_of<S: Service, Q, A>(ask: &AskService<S, Q, (), A, ()>) -> Vec<UniqueNodeId>
where
    Q: Debug + Copy + ZeroCopySend,
    A: Debug + Copy + ZeroCopySend,
{
    let mut nodes = Vec::new();
    ask.dynamic_config().list_servers(|server| {
        nodes.push(server.node_id);
        CallbackProgression::Continue
    });
    nodes
}

/// Nodes of the listeners that a topic names.
fn listeners_of<S: Service>(events: &EventService<S>) -> Vec<UniqueNodeId> {
    let mut nodes = Vec::new();
    events.dynamic_config().list_listeners(|listener| {
        nodes.push(listener.node_id);
        CallbackProgression::Continue
    });
    nodes
}

/// Adds both sides of a difference of layouts, whose names hold their versions.
fn explain<S: Service, Q, A>(bus: &Bus<S>, error: BusError, name: &ServiceName) -> BusError
where
    Q: Debug + Copy + ZeroCopySend,
    A: Debug + Copy + ZeroCopySend,
{
    let BusError::Different { topic, reason, .. } = error else { return error };
    let here = [TypeDetail::new::<Q>(TypeVariant::FixedSize), TypeDetail::new::<A>(TypeVariant::FixedSize)];
    let there = S::details(name, bus.node().config(), MessagingPattern::RequestResponse);
    let there = there.ok().flatten().map(|details| {
        let of = details.static_details.request_response();
        let types = [of.request_message_type_details().payload, of.response_message_type_details().payload];
        format!("; there: {}", describe_types(&types))
    });
    let both = format!("; here: {}{}", describe_types(&here), there.unwrap_or_default());
    BusError::Different { topic, reason, both }
}

/// The place of the one server is taken: by whom, in words that help.
fn name_the_other<S: Service>(bus: &Bus<S>, error: BusError, role: &'static str, name: &str) -> BusError {
    match error {
        BusError::Crowded { reason, .. } if reason.contains("Servers") || reason.contains("Listeners") => {
            BusError::Taken { role, name: name.to_owned(), domain: bus.domain().name().to_owned() }
        }
        other => other,
    }
}
