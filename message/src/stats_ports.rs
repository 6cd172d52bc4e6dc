//! The topics of the flight recorder. They have no event: whoever wants to know looks.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::port::ReceiveError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    BackpressureStrategy, CallbackProgression, MessagingPattern, PortFactory as _, Service, ZeroCopySend,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::bus::{Bus, BusError, Part, Patience};
use crate::domain::DomainError;
use crate::held::Held;
use crate::ports::{remember, service_name};
use crate::qos::{self, STATS};
use crate::room;
use crate::stats::{CameraStats, ClientStats, DetectorStats, STATS_PERIOD, Stats};
use crate::topics;

type Telling<S, T> = (Publisher<S, T, ()>, PortFactory<S, T, ()>);
type Hearing<S, T> = (Subscriber<S, T, ()>, PortFactory<S, T, ()>);

/// How long is tried to make a topic; others wait meanwhile. What one who was killed left half made is mended once even so.
const PATIENCE: Duration = Duration::from_millis(100);
/// Pause after it could not be had.
const TRY_AGAIN: Duration = Duration::from_secs(1);

/// A topic of the recorder, as one who publishes has it. It is made or joined when it is due for the first time: roles start
/// sooner so.
#[derive(Debug)]
pub struct StatsOut<S: Service, T: Debug + ZeroCopySend + Copy + 'static> {
    held: Option<Held<Telling<S, T>>>,
    bus: Bus<S>,
    topic: String,
    part: Part,
    due: Instant,
}

/// A topic of the recorder, as one who reads has it.
#[derive(Debug)]
pub struct StatsIn<S: Service, T: Debug + ZeroCopySend + Copy + 'static> {
    held: Held<Hearing<S, T>>,
    _bus: Bus<S>,
}

/// Keeps the topic of a detector's clients there, for those who come, from the first time on that it is looked after.
#[derive(Debug)]
pub struct ClientsTopic<S: Service> {
    held: Option<Held<PortFactory<S, ClientStats, ()>>>,
    bus: Bus<S>,
    topic: String,
}

impl<S: Service, T: Debug + ZeroCopySend + Copy> StatsOut<S, T> {
    fn new(bus: &Bus<S>, topic: String, part: Part) -> Self {
        Self { held: None, bus: bus.clone(), topic, part, due: Instant::now() + STATS_PERIOD }
    }

    /// Whether it is time to publish again.
    #[must_use]
    pub fn is_due(&self) -> bool {
        Instant::now() >= self.due
    }

    /// Publishes a copy. That it reaches nobody is no error, nor that shared memory is full: what it says is said again. Errors are that the topic cannot be had;
    /// it is tried again when this is due again.
    pub fn publish(&mut self, stats: &T) -> Result<(), BusError> {
        self.due = Instant::now() + TRY_AGAIN;
        let held = match &mut self.held {
            Some(held) => held,
            empty => empty.insert(self.bus.join_stats(&self.topic, self.part)?),
        };
        self.due = Instant::now() + STATS_PERIOD;
        if !room::is_short() {
            let _ = held.get().0.send_copy(*stats);
        }
        Ok(())
    }
}

impl<S: Service> ClientsTopic<S> {
    /// Makes the topic unless it is there. Errors are that it cannot be had.
    pub fn look(&mut self) -> Result<(), BusError> {
        if self.held.is_none() {
            let (bus, part) = (&self.bus, Part::Producer);
            let service =
                bus.stats_service(&self.topic, qos::MAX_CLIENT_STATS, part, Patience::AtMost(PATIENCE))?;
            let described = [remember(&service, MessagingPattern::PublishSubscribe, bus)];
            self.held = Some(Held::new(service, described, bus.domain()));
        }
        Ok(())
    }
}

impl<S: Service, T: Debug + ZeroCopySend + Stats> StatsIn<S, T> {
    /// The next copy that has come and may be believed; with several publishers copies of all come in turn.
    pub fn next(&self) -> Result<Option<T>, ReceiveError> {
        Ok(self.next_with_publisher()?.map(|(_, stats)| stats))
    }

    /// The same, with the number of its publisher.
    pub fn next_with_publisher(&self) -> Result<Option<(u128, T)>, ReceiveError> {
        while let Some(sample) = self.held.get().0.receive()? {
            // Copied out once, then checked, then used.
            let stats = *sample;
            if stats.checked().is_ok() {
                return Ok(Some((sample.header().publisher_id().value(), stats)));
            }
        }
        Ok(None)
    }

    /// The numbers of those who publish here, and their processes. One who ended is not among them, one who was killed is until
    /// somebody cleans up.
    #[must_use]
    pub fn publishers(&self) -> BTreeMap<u128, u32> {
        let mut publishers = BTreeMap::new();
        self.held.get().1.dynamic_config().list_publishers(|details| {
            let process = details.node_id.pid::<S>().map_or(0, |process| process.value() as u32);
            publishers.insert(details.publisher_id.value(), process);
            CallbackProgression::Continue
        });
        publishers
    }
}

impl<S: Service> Bus<S> {
    /// The topic of a camera's statistics, of which there is one publisher.
    pub fn camera_stats(&self, camera: &str) -> Result<StatsOut<S, CameraStats>, DomainError> {
        Ok(StatsOut::new(self, topics::camera_stats(camera)?, Part::Producer))
    }

    /// Opens it.
    pub fn open_camera_stats(
        &self,
        camera: &str,
        patience: Patience,
    ) -> Result<StatsIn<S, CameraStats>, BusError> {
        self.stats_in(topics::camera_stats(camera), patience)
    }

    /// The topic of a detector's statistics, of which there is one publisher.
    pub fn detector_stats(
        &self,
        camera: &str,
        detector: &str,
    ) -> Result<StatsOut<S, DetectorStats>, DomainError> {
        Ok(StatsOut::new(self, topics::detector_stats(camera, detector)?, Part::Producer))
    }

    /// Opens it.
    pub fn open_detector_stats(
        &self,
        camera: &str,
        detector: &str,
        patience: Patience,
    ) -> Result<StatsIn<S, DetectorStats>, BusError> {
        self.stats_in(topics::detector_stats(camera, detector), patience)
    }

    /// The topic on which a detector's clients publish what they count, as the detector has it.
    pub fn clients_topic(&self, camera: &str, detector: &str) -> Result<ClientsTopic<S>, DomainError> {
        Ok(ClientsTopic { held: None, bus: self.clone(), topic: topics::client_stats(camera, detector)? })
    }

    /// A client's place on that topic. It is joined where it is there: a client has better things to do than to wait for it.
    pub fn client_stats(
        &self,
        camera: &str,
        detector: &str,
    ) -> Result<StatsOut<S, ClientStats>, DomainError> {
        Ok(StatsOut::new(self, topics::client_stats(camera, detector)?, Part::Consumer))
    }

    /// Opens it to read.
    pub fn open_client_stats(
        &self,
        camera: &str,
        detector: &str,
        patience: Patience,
    ) -> Result<StatsIn<S, ClientStats>, BusError> {
        self.stats_in(topics::client_stats(camera, detector), patience)
    }

    fn stats_service<T: Debug + ZeroCopySend>(
        &self,
        topic: &str,
        publishers: usize,
        part: Part,
        patience: Patience,
    ) -> Result<PortFactory<S, T, ()>, BusError> {
        let name = service_name(topic)?;
        let builder = || self.node().service_builder(&name).publish_subscribe::<T>();
        if part == Part::Consumer {
            return self.persist(topic, part, patience, || builder().open());
        }
        self.persist(topic, part, patience, || {
            builder()
                .max_publishers(publishers)
                .max_nodes(qos::MAX_NODES)
                .max_subscribers(STATS.subscribers)
                .subscriber_max_buffer_size(STATS.buffer)
                .subscriber_max_borrowed_samples(STATS.borrowed)
                .history_size(STATS.history)
                .enable_safe_overflow(true)
                .open_or_create()
        })
    }

    fn join_stats<T: Debug + ZeroCopySend + Copy>(
        &self,
        topic: &str,
        part: Part,
    ) -> Result<Held<Telling<S, T>>, BusError> {
        let patience = Patience::AtMost(if part == Part::Producer { PATIENCE } else { Duration::ZERO });
        let service = self.stats_service(topic, 1, part, patience)?;
        let publisher = self.persist(topic, part, patience, || {
            service
                .publisher_builder()
                .max_loaned_samples(STATS.loans)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        Ok(Held::new((publisher, service), described, self.domain()))
    }

    fn stats_in<T: Debug + ZeroCopySend + Copy>(
        &self,
        topic: Result<String, DomainError>,
        patience: Patience,
    ) -> Result<StatsIn<S, T>, BusError> {
        let topic = topic?;
        let service = self.stats_service(&topic, 0, Part::Consumer, patience)?;
        let subscriber =
            self.persist(&topic, Part::Consumer, patience, || service.subscriber_builder().create())?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        Ok(StatsIn { held: Held::new((subscriber, service), described, self.domain()), _bus: self.clone() })
    }
}
