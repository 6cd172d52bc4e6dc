//! Topics opened or made, as the pairs of ports that roles work with.
//!
//! A topic with an event is a publish-subscribe service, a bell (`bell.rs`) by which our receivers are woken, and an event service of the same
//! name for those of other programs: send first, then notify.
//! Ports are dropped before their services and those before the node, in the order of the fields: what is left is then
//! removed by whoever is last (`held.rs`).

use std::cell::RefCell;
use std::fmt::{self, Debug};
use std::io;
use std::mem::MaybeUninit;
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::port::notifier::{Notifier, NotifierNotifyError};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{LoanError, ReceiveError, SendError};
use iceoryx2::prelude::{
    BackpressureStrategy, CallbackProgression, EventId, MessagingPattern, PortFactory, Service, ServiceName,
    ZeroCopySend,
};
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use iceoryx2::service::port_factory::event::PortFactory as EventService;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as DataService;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::bell::{Bell, Use};
use crate::bus::{Bus, BusError, Part, Patience};
use crate::description::Description;
use crate::detection::{DetectionsHeader, TagDetection};
use crate::frame::FrameHeader;
use crate::held::Held;
use crate::info::CameraInfo;
pub use crate::pages::LendError;
use crate::pages::Pages;
use crate::qos::{self, Reserved, TopicQos};
use crate::room::{self, SHARED_MEMORY};
use crate::sweep;
use crate::topics;

/// A topic has one publisher.
const MAX_PUBLISHERS: usize = 1;

/// States a quality of service on one of iceoryx2's builders, whose types differ with payload and header.
macro_rules! with_qos {
    ($builder:expr, $qos:expr) => {
        $builder
            .max_publishers(MAX_PUBLISHERS)
            .max_nodes(qos::MAX_NODES)
            .max_subscribers($qos.subscribers)
            .subscriber_max_buffer_size($qos.buffer)
            .subscriber_max_borrowed_samples($qos.borrowed)
            .history_size($qos.history)
            .enable_safe_overflow(true)
    };
}

/// A topic of slices of `T` with a header `H`, seen from its one publisher.
#[derive(Debug)]
pub struct Output<S: Service, T: Debug + ZeroCopySend + 'static, H: Debug + Default + ZeroCopySend + 'static>
{
    held: Held<Sending<S, T, H>>,
    reserved: Reserved,
    pages: RefCell<Pages>,
    /// The file of the publisher's chunks, where it was found.
    memory: Option<PathBuf>,
    bus: Bus<S>,
}

/// What an [`Output`] holds.
#[derive(Debug)]
struct Sending<S: Service, T: Debug + ZeroCopySend + 'static, H: Debug + Default + ZeroCopySend + 'static> {
    publisher: Publisher<S, [T], H>,
    notifier: Notifier<S>,
    bell: Bell,
    data: DataService<S, [T], H>,
    events: EventService<S>,
}

/// A topic of slices of `T` with a header `H`, seen from one of its subscribers.
#[derive(Debug)]
pub struct Input<S: Service, T: Debug + ZeroCopySend + 'static, H: Debug + ZeroCopySend + 'static> {
    held: Held<Receiving<S, T, H>>,
    buffer: usize,
    bus: Bus<S>,
}

/// What an [`Input`] holds.
#[derive(Debug)]
struct Receiving<S: Service, T: Debug + ZeroCopySend + 'static, H: Debug + ZeroCopySend + 'static> {
    subscriber: Subscriber<S, [T], H>,
    bell: Bell,
    data: DataService<S, [T], H>,
}

/// The frames topic of a camera.
pub type FramesOut<S> = Output<S, u8, FrameHeader>;
/// The frames topic of a detector or viewer.
pub type FramesIn<S> = Input<S, u8, FrameHeader>;
/// The detections topic of a detector.
pub type DetectionsOut<S> = Output<S, TagDetection, DetectionsHeader>;
/// The detections topic of a client.
pub type DetectionsIn<S> = Input<S, TagDetection, DetectionsHeader>;

impl<S: Service, T: Debug + ZeroCopySend, H: Debug + Default + ZeroCopySend> Output<S, T, H> {
    /// Where messages are loaned. What roles send they take by [`Output::lend`].
    #[must_use]
    pub fn publisher(&self) -> &Publisher<S, [T], H> {
        &self.held.get().publisher
    }

    /// Memory for a message of `length` items, which has its pages: writing it cannot fail. Once warm, nothing is allocated for it
    /// and the system is not asked.
    ///
    /// # Errors
    /// Others hold all memory, or shared memory is full.
    pub fn lend(&self, length: usize) -> Result<SampleMutUninit<S, [MaybeUninit<T>], H>, LendError> {
        let mut loan = self.publisher().loan_slice_uninit(length).map_err(LendError::Taken)?;
        let (start, bytes) = (loan.payload_mut().as_ptr().addr(), length * size_of::<T>());
        match self.pages.borrow_mut().provide(start, bytes) {
            Ok(()) => Ok(loan),
            Err(_) => Err(LendError::Full { bytes }),
        }
    }

    /// Wakes every subscriber that waits: ours by the bell, others by iceoryx2's event. To be called after sending.
    pub fn notify(&self) -> Result<(), NotifyError> {
        let sending = self.held.get();
        sending.bell.ring().map_err(NotifyError::Bell)?;
        if sending.events.dynamic_config().number_of_listeners() > 0 {
            sending.notifier.notify().map_err(NotifyError::Event)?;
        }
        Ok(())
    }

    /// Subscribers of the topic; one that died counts until somebody cleans up.
    #[must_use]
    pub fn subscribers(&self) -> usize {
        self.held.get().data.dynamic_config().number_of_subscribers()
    }

    /// Memory that the publisher has reserved.
    #[must_use]
    pub fn reserved(&self) -> Reserved {
        self.reserved
    }

    /// Bytes of the reserved memory that were ever written and so take room; `None` when the system does not say.
    #[must_use]
    pub fn touched_bytes(&self) -> Option<u64> {
        self.memory.as_deref().and_then(sweep::bytes_in_use)
    }

    /// Whether those who come can still find the topic and its memory. They cannot when somebody removed its files by force: those who
    /// are connected go on, and only making the topic anew helps the others. To be asked about once a second: it makes three system calls.
    #[must_use]
    pub fn is_in_place(&self) -> bool {
        let is_heard = self.held.get().bell.is_in_place();
        is_heard && self.memory.as_ref().is_none_or(|file| file.exists()) && self.held.is_current()
    }

    /// The place on the bus that the topic was made from.
    #[must_use]
    pub fn bus(&self) -> &Bus<S> {
        &self.bus
    }
}

impl<S: Service, T: Debug + ZeroCopySend, H: Debug + ZeroCopySend> Input<S, T, H> {
    /// The next message in the queue, without waiting.
    pub fn receive(&self) -> Result<Option<Sample<S, [T], H>>, ReceiveError> {
        self.held.get().subscriber.receive()
    }

    /// The newest message in the queue, without waiting. Older ones are given back one by one, so that never more than
    /// one is held.
    pub fn newest(&self) -> Result<Option<Sample<S, [T], H>>, ReceiveError> {
        let subscriber = &self.held.get().subscriber;
        let mut newest = subscriber.receive()?;
        while newest.is_some() && subscriber.has_samples().map_err(ReceiveError::ConnectionFailure)? {
            drop(newest.take());
            newest = subscriber.receive()?;
        }
        Ok(newest)
    }

    /// Whether the topic of this name is still the one that was opened. It is not when somebody removed its files by
    /// force; then it has to be opened again. To be asked when a deadline was missed; it makes two system calls.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.held.get().bell.is_in_place() && self.held.is_current()
    }

    /// Gives up the connection to the publisher for a new one. A publisher and a subscriber of which one could not
    /// complete it in time, on a starved machine, never try again: so a silence may be that of a connection and not of
    /// the publisher. What was sent before does not come again.
    pub fn connect_anew(&mut self) -> Result<(), BusError> {
        let data = &self.held.get().data;
        let topic = data.name().as_str().to_owned();
        let connected = self.bus.persist(&topic, Part::Consumer, Patience::IfThere, || {
            data.subscriber_builder().buffer_size(self.buffer).history_request(0).create()
        });
        self.held.get_mut().subscriber = connected?;
        Ok(())
    }

    /// What wakes when a message was sent.
    #[must_use]
    pub fn bell(&self) -> &Bell {
        &self.held.get().bell
    }

    /// The place on the bus that the topic was opened from.
    #[must_use]
    pub fn bus(&self) -> &Bus<S> {
        &self.bus
    }
}

/// The description of a topic that was just opened.
pub(crate) fn remember<S: Service, F: PortFactory>(
    service: &F,
    pattern: MessagingPattern,
    bus: &Bus<S>,
) -> Description {
    let path = sweep::description_of(bus.domain(), service.service_hash().as_str());
    Description::remember(path, || match S::details(service.name(), bus.node().config(), pattern) {
        Ok(Some(there)) => there.static_details.unique_service_id() == service.unique_service_id(),
        Ok(None) => false,
        // Half made or not to be read now: who asks again will be told.
        Err(_) => true,
    })
}

/// Why not everybody could be woken.
#[derive(Debug)]
#[non_exhaustive]
pub enum NotifyError {
    /// Ours are not: the system refuses to write.
    Bell(io::Error),
    /// Listeners of other programs are not, at least one of them.
    Event(NotifierNotifyError),
}

impl fmt::Display for NotifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bell(error) => write!(f, "the bell of the topic cannot be rung ({error})"),
            Self::Event(error) => write!(f, "a listener of another program cannot be notified ({error:?})"),
        }
    }
}

impl std::error::Error for NotifyError {}

type TellingInfo<S> = (Publisher<S, CameraInfo, ()>, DataService<S, CameraInfo, ()>);
type HearingInfo<S> = (Subscriber<S, CameraInfo, ()>, DataService<S, CameraInfo, ()>);

/// The info topic of a camera. It has no event: whoever wants to know looks.
#[derive(Debug)]
pub struct InfoOut<S: Service> {
    held: Held<TellingInfo<S>>,
    _bus: Bus<S>,
}

impl<S: Service> InfoOut<S> {
    /// Publishes a change, unless shared memory is full.
    pub fn publish(&self, info: &CameraInfo) -> Result<usize, SendError> {
        if room::is_short() {
            return Err(SendError::LoanError(LoanError::OutOfMemory));
        }
        self.held.get().0.send_copy(*info)
    }

    /// Hands the last information to subscribers that came after it. To be called about once a second.
    pub fn greet_late_subscribers(&self) {
        // A subscriber that cannot be reached is dying or gone; it is tried again with the next call.
        let _ = self.held.get().0.update_connections();
    }
}

/// The info topic of anybody else.
#[derive(Debug)]
pub struct InfoIn<S: Service> {
    held: Held<HearingInfo<S>>,
    _bus: Bus<S>,
}

impl<S: Service> InfoIn<S> {
    /// The newest information that has come since the last call.
    pub fn newest(&self) -> Result<Option<CameraInfo>, ReceiveError> {
        let mut newest = None;
        while let Some(sample) = self.held.get().0.receive()? {
            newest = Some(*sample);
        }
        Ok(newest)
    }
}

impl<S: Service> Bus<S> {
    /// Makes the frames topic of a camera with loans of at most `payload_bytes` (picture and alignment).
    pub fn create_frames(
        &self,
        camera: &str,
        qos: &TopicQos,
        payload_bytes: usize,
    ) -> Result<FramesOut<S>, BusError> {
        let topic = topics::frames(camera)?;
        let reserved = Reserved::frames(qos, payload_bytes);
        self.output(&topic, qos, payload_bytes, reserved)
            .map_err(|error| self.name_the_other(error, "camera", camera))
    }

    /// Makes the detections topic of a detector with messages of at most `max_tags` tags.
    pub fn create_detections(
        &self,
        camera: &str,
        detector: &str,
        max_tags: usize,
    ) -> Result<DetectionsOut<S>, BusError> {
        let topic = topics::detections(camera, detector)?;
        let max_tags = qos::check_max_tags(max_tags)?;
        self.output(&topic, &qos::DETECTIONS, max_tags, Reserved::detections(max_tags))
            .map_err(|error| self.name_the_other(error, "detector", detector))
    }

    /// Opens a camera's frames topic, with a queue of `buffer` frames.
    pub fn open_frames(
        &self,
        camera: &str,
        buffer: usize,
        patience: Patience,
    ) -> Result<FramesIn<S>, BusError> {
        self.input(&topics::frames(camera)?, buffer, patience)
    }

    /// Opens a detector's detections topic, with the longest queue there is.
    pub fn open_detections(
        &self,
        camera: &str,
        detector: &str,
        patience: Patience,
    ) -> Result<DetectionsIn<S>, BusError> {
        self.input(&topics::detections(camera, detector)?, qos::DETECTIONS.buffer, patience)
    }

    /// Makes the info topic of a camera.
    pub fn create_info(&self, camera: &str) -> Result<InfoOut<S>, BusError> {
        let topic = topics::info(camera)?;
        let name = service_name(&topic)?;
        let service = self.persist(&topic, Part::Producer, Patience::Endless, || {
            let builder = self.node().service_builder(&name).publish_subscribe::<CameraInfo>();
            with_qos!(builder, qos::INFO).open_or_create()
        });
        let service = service.map_err(|error| self.explain(error, &name, &qos::INFO))?;
        let publisher = self
            .persist(&topic, Part::Producer, Patience::Endless, || {
                service
                    .publisher_builder()
                    .max_loaned_samples(qos::INFO.loans)
                    .backpressure_strategy(BackpressureStrategy::DiscardData)
                    .create()
            })
            .map_err(|error| self.name_the_other(error, "camera", camera))?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        Ok(InfoOut { held: Held::new((publisher, service), described, self.domain()), _bus: self.clone() })
    }

    /// Opens a camera's info topic.
    pub fn open_info(&self, camera: &str, patience: Patience) -> Result<InfoIn<S>, BusError> {
        let topic = topics::info(camera)?;
        let name = service_name(&topic)?;
        let service = self.persist(&topic, Part::Consumer, patience, || {
            self.node().service_builder(&name).publish_subscribe::<CameraInfo>().open()
        })?;
        let subscriber =
            self.persist(&topic, Part::Consumer, patience, || service.subscriber_builder().create())?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        Ok(InfoIn { held: Held::new((subscriber, service), described, self.domain()), _bus: self.clone() })
    }

    fn output<T, H>(
        &self,
        topic: &str,
        qos: &TopicQos,
        slice_len: usize,
        reserved: Reserved,
    ) -> Result<Output<S, T, H>, BusError>
    where
        T: Debug + ZeroCopySend,
        H: Debug + Default + ZeroCopySend,
    {
        loop {
            if let Some(output) = self.try_output(topic, qos, slice_len, reserved)? {
                return Ok(output);
            }
        }
    }

    /// `None` when the topic had to be forgotten, because its one place for a publisher is taken by nobody.
    fn try_output<T, H>(
        &self,
        topic: &str,
        qos: &TopicQos,
        slice_len: usize,
        reserved: Reserved,
    ) -> Result<Option<Output<S, T, H>>, BusError>
    where
        T: Debug + ZeroCopySend,
        H: Debug + Default + ZeroCopySend,
    {
        let name = service_name(topic)?;
        let produce = Part::Producer;
        let data = self
            .persist(topic, produce, Patience::Endless, || {
                let builder =
                    self.node().service_builder(&name).publish_subscribe::<[T]>().user_header::<H>();
                with_qos!(builder, *qos).open_or_create()
            })
            .map_err(|error| self.explain(error, &name, qos))?;
        let events = self.persist(topic, produce, Patience::Endless, || {
            self.node()
                .service_builder(&name)
                .event()
                .max_nodes(qos::MAX_NODES)
                .max_listeners(qos::MAX_LISTENERS)
                .max_notifiers(qos::MAX_NOTIFIERS)
                .event_id_max_value(qos::EVENT_MAX)
                .notifier_created_event(EventId::new(qos::EVENT_PRODUCER_CAME))
                .notifier_dropped_event(EventId::new(qos::EVENT_PRODUCER_WENT))
                .notifier_dead_event(EventId::new(qos::EVENT_PRODUCER_DIED))
                .open_or_create()
        })?;
        let description = remember(&data, MessagingPattern::PublishSubscribe, self);
        let publisher = self.persist(topic, produce, Patience::Endless, || {
            data.publisher_builder()
                .initial_max_slice_len(slice_len)
                .max_loaned_samples(qos.loans)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        });
        let publisher = match publisher {
            Err(BusError::Crowded { .. }) if self.is_haunted(|| publishers_of(&data), MAX_PUBLISHERS) => {
                self.forget(description.path())?;
                return Ok(None);
            }
            made => made?,
        };
        let notifier = self.persist(topic, produce, Patience::Endless, || {
            events.notifier_builder().default_event_id(EventId::new(qos::EVENT_SENT)).create()
        })?;
        let bell = self.bell(topic, &data, Use::Ring)?;
        let memory = sweep::file_of(self.domain(), &format!("_{}.data", publisher.id().value()));
        let described = [description, remember(&events, MessagingPattern::Event, self)];
        let sending = Sending { publisher, notifier, bell, data, events };
        let held = Held::new(sending, described, self.domain());
        let pages = RefCell::new(Pages::new(slice_len * size_of::<T>(), qos.chunks()));
        let output = Output { held, reserved, pages, memory, bus: self.clone() };
        // Now there is room for the first piece's headers, for which nobody asks.
        drop(output.lend(0));
        Ok(Some(output))
    }

    fn input<T, H>(&self, topic: &str, buffer: usize, patience: Patience) -> Result<Input<S, T, H>, BusError>
    where
        T: Debug + ZeroCopySend,
        H: Debug + ZeroCopySend,
    {
        let name = service_name(topic)?;
        let consume = Part::Consumer;
        let data = self.persist(topic, consume, patience, || {
            self.node().service_builder(&name).publish_subscribe::<[T]>().user_header::<H>().open()
        });
        let data = data.map_err(|error| self.explain_types::<T, H>(error, &name))?;
        let bell = self.bell(topic, &data, Use::Hear)?;
        let subscriber = self
            .persist(topic, consume, patience, || data.subscriber_builder().buffer_size(buffer).create())?;
        let described = [remember(&data, MessagingPattern::PublishSubscribe, self)];
        let receiving = Receiving { subscriber, bell, data };
        let held = Held::new(receiving, described, self.domain());
        Ok(Input { held, buffer, bus: self.clone() })
    }

    fn bell<F: PortFactory>(&self, topic: &str, service: &F, purpose: Use) -> Result<Bell, BusError> {
        let bell = Bell::of_topic(self.domain(), service.service_hash().as_str(), purpose);
        bell.map_err(|error| match error.kind() {
            io::ErrorKind::StorageFull => BusError::NoRoom { free: 0 },
            _ => BusError::Stuck {
                topic: topic.to_owned(),
                reason: format!("its bell in {SHARED_MEMORY}: {error}"),
                waited: Duration::ZERO,
            },
        })
    }

    /// The place of the one publisher is taken: by whom, in words that help.
    fn name_the_other(&self, error: BusError, role: &'static str, name: &str) -> BusError {
        match error {
            BusError::Crowded { reason, .. } if reason.contains("Publishers") => {
                BusError::Taken { role, name: name.to_owned(), domain: self.domain().name().to_owned() }
            }
            other => other,
        }
    }

    /// Adds both sides of a difference of layouts.
    fn explain_types<T, H>(&self, error: BusError, name: &ServiceName) -> BusError
    where
        T: Debug + ZeroCopySend,
        H: Debug + ZeroCopySend,
    {
        let BusError::Different { topic, reason, .. } = error else { return error };
        let here = [TypeDetail::new::<T>(TypeVariant::Dynamic), TypeDetail::new::<H>(TypeVariant::FixedSize)];
        let there = S::details(name, self.node().config(), MessagingPattern::PublishSubscribe);
        let there = there.ok().flatten().map(|details| {
            let types = *details.static_details.publish_subscribe().message_type_details();
            format!("; there: {}", describe_types(&[types.payload, types.user_header]))
        });
        let both = format!("; here: {}{}", describe_types(&here), there.unwrap_or_default());
        BusError::Different { topic, reason, both }
    }

    /// Adds both sides of a difference, and who holds the topic.
    fn explain(&self, error: BusError, name: &ServiceName, wanted: &TopicQos) -> BusError {
        let BusError::Different { topic, reason, .. } = error else { return error };
        let both = format!("; here: {}{}", wanted.arithmetic(), self.other_side(name).unwrap_or_default());
        BusError::Different { topic, reason, both }
    }

    fn other_side(&self, name: &ServiceName) -> Option<String> {
        let pattern = MessagingPattern::PublishSubscribe;
        let details = S::details(name, self.node().config(), pattern).ok()??;
        let there = details.static_details.publish_subscribe();
        let holders: Vec<_> = details.dynamic_details.iter().flat_map(|dynamic| &dynamic.nodes).collect();
        let holders: Vec<_> = holders.into_iter().filter_map(describe_node).collect();
        Some(format!(
            "; there: {} subscribers x ({} buffered + {} borrowed) + {} history of {}; held by {}",
            there.max_subscribers(),
            there.subscriber_max_buffer_size(),
            there.subscriber_max_borrowed_samples(),
            there.history_size(),
            there.message_type_details().payload.type_name(),
            if holders.is_empty() { "nobody alive".to_owned() } else { holders.join(", ") },
        ))
    }
}

/// Nodes of the publishers that a topic names.
fn publishers_of<S: Service, T: Debug + ZeroCopySend, H: Debug + ZeroCopySend>(
    data: &DataService<S, [T], H>,
) -> Vec<UniqueNodeId> {
    let mut nodes = Vec::new();
    data.dynamic_config().list_publishers(|publisher| {
        nodes.push(publisher.node_id);
        CallbackProgression::Continue
    });
    nodes
}

/// Payload and header as "u8 of 1 bytes with tagbus.FrameHeader.v1 of 160 bytes".
pub(crate) fn describe_types(types: &[TypeDetail; 2]) -> String {
    let [payload, header] = types.each_ref().map(|of| format!("{} of {} bytes", of.type_name(), of.size()));
    format!("{payload} with {header}")
}

fn describe_node<S: Service>(node: &NodeState<S>) -> Option<String> {
    let NodeState::Alive(node) = node else { return None };
    let details = node.details().as_ref()?;
    Some(format!("{} (process {})", details.name(), details.process_id().value()))
}

pub(crate) fn service_name(topic: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(topic).map_err(|error| BusError::Stuck {
        topic: topic.to_owned(),
        reason: format!("{error:?}"),
        waited: Duration::ZERO,
    })
}
