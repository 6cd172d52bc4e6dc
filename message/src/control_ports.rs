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
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{
    BackpressureStrategy, EventId, MessagingPattern, PortFactory, Service, ServiceName, ZeroCopySend,
};
use iceoryx2::service::port_factory::event::PortFactory as EventService;
use iceoryx2::service::port_factory::request_response::PortFactory as AskService;

use crate::bus::{Bus, BusError, Part, Patience};
use crate::control::{CameraReply, CameraRequest, DetectorReply, DetectorRequest};
use crate::ports::service_name;
use crate::qos;
use crate::topics;

type Round<S, Q, A> = VecDeque<ActiveRequest<S, Q, (), A, ()>>;
type Services<S, Q, A> = (AskService<S, Q, (), A, ()>, EventService<S>);

/// A control topic, seen from the role that answers.
#[derive(Debug)]
pub struct ControlServer<
    S: Service,
    Q: Debug + Copy + ZeroCopySend + 'static,
    A: Debug + Copy + ZeroCopySend + 'static,
> {
    /// Requests of this round that were not handled yet. While one of a client is here, no further one is taken of it.
    round: RefCell<Round<S, Q, A>>,
    server: Server<S, Q, (), A, ()>,
    listener: Listener<S>,
    _services: Services<S, Q, A>,
    _bus: Bus<S>,
}

/// A control topic, seen from one who asks.
#[derive(Debug)]
pub struct ControlClient<
    S: Service,
    Q: Debug + Copy + ZeroCopySend + 'static,
    A: Debug + Copy + ZeroCopySend + 'static,
> {
    client: Client<S, Q, (), A, ()>,
    notifier: Notifier<S>,
    services: Services<S, Q, A>,
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
            match self.server.receive() {
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
        &self.listener
    }
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> Asked<S, Q, A> {
    /// The request, copied out of shared memory: to be checked before it is believed.
    #[must_use]
    pub fn request(&self) -> Q {
        *self.active.payload()
    }

    /// Answers. That the answer reaches nobody is the client's loss: it has gone, or never takes its answers.
    pub fn answer(self, reply: &A) {
        let _ = self.active.send_copy(*reply);
    }
}

impl<S: Service, Q: Debug + Copy + ZeroCopySend, A: Debug + Copy + ZeroCopySend> ControlClient<S, Q, A> {
    /// Sends a request and wakes the server.
    pub fn ask(&self, request: &Q) -> Result<Pending<S, Q, A>, AskError> {
        let pending = self.client.send_copy(*request).map_err(|error| AskError::broken(&error))?;
        if pending.number_of_server_connections() == 0 {
            return Err(AskError::Nobody);
        }
        self.notifier.notify().map_err(|error| AskError::broken(&error))?;
        Ok(Pending { pending })
    }

    /// Whether there is a server. One that was killed counts until its remains are cleaned up.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.services.0.dynamic_config().number_of_servers() > 0
    }

    /// Whether the topic of this name is still the one that was opened; see [`crate::ports::Input::is_current`].
    #[must_use]
    pub fn is_current(&self) -> bool {
        let ask = &self.services.0;
        match S::details(ask.name(), self.bus.node().config(), MessagingPattern::RequestResponse) {
            Ok(Some(there)) => there.static_details.unique_service_id() == ask.unique_service_id(),
            Ok(None) => false,
            // Half made or not to be read now: the next time tells.
            Err(_) => true,
        }
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
        let name = service_name(topic)?;
        let (produce, patience) = (Part::Producer, Patience::Endless);
        let ask = self.persist(topic, produce, patience, || self.control_service(&name))?;
        let events = self.persist(topic, produce, patience, || {
            self.node()
                .service_builder(&name)
                .event()
                .max_nodes(qos::MAX_NODES)
                .max_listeners(1)
                .max_notifiers(qos::MAX_CONTROL_CLIENTS)
                .event_id_max_value(qos::EVENT_MAX)
                .open_or_create()
        })?;
        let server = self.persist(topic, produce, patience, || {
            ask.server_builder()
                .max_loaned_responses_per_request(1)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })?;
        let listener = self.persist(topic, produce, patience, || events.listener_builder().create())?;
        let round = RefCell::new(VecDeque::with_capacity(2 * qos::MAX_CONTROL_CLIENTS));
        Ok(ControlServer { round, server, listener, _services: (ask, events), _bus: self.clone() })
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
            .max_servers(1)
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
        let ask = self.persist(topic, consume, patience, || {
            self.node().service_builder(&name).request_response::<Q, A>().open()
        })?;
        let events =
            self.persist(topic, consume, patience, || self.node().service_builder(&name).event().open())?;
        let client = self.persist(topic, consume, patience, || {
            ask.client_builder().backpressure_strategy(BackpressureStrategy::DiscardData).create()
        })?;
        let notifier = self.persist(topic, consume, patience, || {
            events.notifier_builder().default_event_id(EventId::new(qos::EVENT_SENT)).create()
        })?;
        Ok(ControlClient { client, notifier, services: (ask, events), bus: self.clone() })
    }
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
