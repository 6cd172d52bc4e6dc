//! What a client counts about itself, for those who watch over all of them.

use tagbus_message::bus::Bus;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::detection::DetectionsHeader;
use tagbus_message::domain::DomainError;
use tagbus_message::frame::ClockKind;
use tagbus_message::stats::{CLIENT_HOPS, ClientStats};
use tagbus_message::stats_ports::StatsOut;
use tagbus_message::tally::{Tally, UNKNOWN, between};
use tagbus_message::text;

use crate::feed::Shared;

/// Places in [`CLIENT_HOPS`].
const DELIVER: usize = 0;
const TOTAL: usize = 1;

/// Counts from the client's start, and publishes twice a second out of `receive`. That it cannot is never an error: who wants
/// detections gets them.
pub(crate) struct Recorder {
    stats: Box<ClientStats>,
    tally: Tally<{ CLIENT_HOPS.len() }>,
    tape: StatsOut<Shared, ClientStats>,
}

impl Recorder {
    pub(crate) fn new(
        bus: &Bus<Shared>,
        name: &str,
        camera: &str,
        detector: &str,
    ) -> Result<Self, DomainError> {
        let started_ns = monotonic_ns();
        let mut stats = Box::new(ClientStats { epoch: started_ns, started_ns, ..ClientStats::default() });
        text::write_cut(&mut stats.name, name);
        Ok(Self { stats, tally: Tally::default(), tape: bus.client_stats(camera, detector)? })
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
        let is_known = header.capture_ns > 0 && header.capture_clock == ClockKind::Monotonic.code();
        let mut hops = [UNKNOWN; CLIENT_HOPS.len()];
        hops[DELIVER] = between(header.send_ns, client_ns);
        hops[TOTAL] = between(if is_known { header.capture_ns } else { header.dequeue_ns }, client_ns);
        self.tally.frame(hops, &mut stats.hops);
    }

    /// Counts a message that could not be read.
    pub(crate) fn refused(&mut self) {
        self.stats.refused += 1;
    }

    /// Publishes when it is time to.
    pub(crate) fn look(&mut self) {
        if self.tape.is_due() {
            self.tally.count(&mut self.stats.hops);
            self.stats.written_ns = monotonic_ns();
            let _ = self.tape.publish(&self.stats);
        }
    }
}
