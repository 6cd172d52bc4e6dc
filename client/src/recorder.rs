//! What a client counts about itself, for those who watch over all of them.

use std::time::{Duration, Instant};

use tagbus_message::bus::Bus;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::detection::DetectionsHeader;
use tagbus_message::frame::ClockKind;
use tagbus_message::stats::{ClientStats, STATS_PERIOD};
use tagbus_message::stats_ports::StatsOut;
use tagbus_message::text;

use crate::feed::Shared;

/// Places in [`tagbus_message::stats::CLIENT_HOPS`].
const DELIVER: usize = 0;
const TOTAL: usize = 1;

/// Pause after the topic could not be joined.
const JOIN_AGAIN: Duration = Duration::from_secs(5);

/// Counts from the client's start, and publishes twice a second out of `receive`. That it cannot is never an error: who wants
/// detections gets them.
pub(crate) struct Recorder {
    stats: Box<ClientStats>,
    tape: Option<StatsOut<Shared, ClientStats>>,
    place: (String, String),
    /// When to join the topic: not at once, so that connecting stays quick.
    join_at: Instant,
}

impl Recorder {
    pub(crate) fn new(name: &str, camera: &str, detector: &str) -> Self {
        let started_ns = monotonic_ns();
        let mut stats = Box::new(ClientStats { epoch: started_ns, started_ns, ..ClientStats::default() });
        text::write_cut(&mut stats.name, name);
        let place = (camera.to_owned(), detector.to_owned());
        Self { stats, tape: None, place, join_at: Instant::now() + STATS_PERIOD }
    }

    /// Counts a message that was received at `client_ns`.
    pub(crate) fn message(&mut self, header: &DetectionsHeader, client_ns: u64) {
        let stats = &mut self.stats;
        let expected = match stats.received {
            0 => header.message_number,
            // A detector that was started again counts from 0.
            _ if stats.detector_epoch != header.detector_epoch => 0,
            _ => stats.last_message.wrapping_add(1),
        };
        stats.missed = stats.missed.saturating_add(header.message_number.saturating_sub(expected));
        stats.received += 1;
        (stats.detector_epoch, stats.last_message) = (header.detector_epoch, header.message_number);
        stats.hops[DELIVER].record(header.send_ns, client_ns);
        let is_known = header.capture_ns > 0 && header.capture_clock == ClockKind::Monotonic.code();
        stats.hops[TOTAL].record(if is_known { header.capture_ns } else { header.dequeue_ns }, client_ns);
    }

    /// Counts a message that could not be read.
    pub(crate) fn refused(&mut self) {
        self.stats.refused += 1;
    }

    /// Publishes when it is time to.
    pub(crate) fn look(&mut self, bus: &Bus<Shared>) {
        if let Some(tape) = &mut self.tape {
            if tape.is_due() {
                self.stats.written_ns = monotonic_ns();
                tape.publish(&self.stats);
            }
        } else if Instant::now() >= self.join_at {
            self.tape = bus.join_clients_topic(&self.place.0, &self.place.1).ok();
            self.join_at = Instant::now() + JOIN_AGAIN;
        }
    }
}
