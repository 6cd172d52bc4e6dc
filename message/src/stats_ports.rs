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
use crate::stats::{CameraStats, ClientStats, DetectorStats, STATS_PERIOD, Stats};
use crate::topics;

type Telling<S, T> = (Publisher<S, T, ()>, PortFactory<S, T, ()>);
type Hearing<S, T> = (Subscriber<S, T, ()>, PortFactory<S, T, ()>);

/// A topic of the recorder, as one who publishes has it.
#[derive(Debug)]
pub struct StatsOut<S: Service, T: Debug + ZeroCopySend + Copy + 'static> {
    held: Held<Telling<S, T>>,
    _bus: Bus<S>,
    published: Instant,
}

/// A topic of the recorder, as one who reads has it.
#[derive(Debug)]
pub struct StatsIn<S: Service, T: Debug + ZeroCopySend + Copy + 'static> {
    held: Held<Hearing<S, T>>,
    _bus: Bus<S>,
}

/// Keeps the topic of a detector's clients there, for those who come.
#[derive(Debug)]
pub struct ClientsTopic<S: Service> {
    _held: Held<PortFactory<S, ClientStats, ()>>,
    _bus: Bus<S>,
}

impl<S: Service, T: Debug + ZeroCopySend + Copy> StatsOut<S, T> {
    /// Whether it is time to publish again.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.published.elapsed() >= STATS_PERIOD
    }

    /// Publishes a copy. That it reaches nobody is no error: what it says is said again.
    pub fn publish(&mut self, stats: &T) {
        self.published = Instant::now();
        let _ = self.held.get().0.send_copy(*stats);
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
    /// Makes the topic of a camera's statistics.
    pub fn create_camera_stats(&self, camera: &str) -> Result<StatsOut<S, CameraStats>, BusError> {
        self.stats_out(topics::camera_stats(camera), 1, Part::Producer, Patience::Endless)
    }

    /// Opens it.
    pub fn open_camera_stats(
        &self,
        camera: &str,
        patience: Patience,
    ) -> Result<StatsIn<S, CameraStats>, BusError> {
        self.stats_in(topics::camera_stats(camera), patience)
    }

    /// Makes the topic of a detector's statistics.
    pub fn create_detector_stats(
        &self,
        camera: &str,
        detector: &str,
    ) -> Result<StatsOut<S, DetectorStats>, BusError> {
        self.stats_out(topics::detector_stats(camera, detector), 1, Part::Producer, Patience::Endless)
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

    /// Makes the topic on which a detector's clients publish what they count.
    pub fn create_clients_topic(&self, camera: &str, detector: &str) -> Result<ClientsTopic<S>, BusError> {
        let topic = topics::client_stats(camera, detector)?;
        let service = self.stats_service(&topic, qos::MAX_CLIENT_STATS, Part::Producer, Patience::Endless)?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        Ok(ClientsTopic { _held: Held::new(service, described, self.domain()), _bus: self.clone() })
    }

    /// A client's place on that topic, where it is there. Tried once: a client has better things to do than to wait for it.
    pub fn join_clients_topic(
        &self,
        camera: &str,
        detector: &str,
    ) -> Result<StatsOut<S, ClientStats>, BusError> {
        self.stats_out(
            topics::client_stats(camera, detector),
            0,
            Part::Consumer,
            Patience::AtMost(Duration::ZERO),
        )
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

    fn stats_out<T: Debug + ZeroCopySend + Copy>(
        &self,
        topic: Result<String, DomainError>,
        publishers: usize,
        part: Part,
        patience: Patience,
    ) -> Result<StatsOut<S, T>, BusError> {
        let topic = topic?;
        let service = self.stats_service(&topic, publishers, part, patience)?;
        let publisher = self.persist(&topic, part, patience, || {
            service
                .publisher_builder()
                .max_loaned_samples(STATS.loans)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })?;
        let described = [remember(&service, MessagingPattern::PublishSubscribe, self)];
        let held = Held::new((publisher, service), described, self.domain());
        Ok(StatsOut { held, _bus: self.clone(), published: Instant::now() })
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
