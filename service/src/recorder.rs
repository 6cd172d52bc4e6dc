//! What the detector counts about itself: how long each hop of each frame took. Published when there is nothing better to do.

use tagbus_detector::Phase;
use tagbus_message::Local;
use tagbus_message::bus::Bus;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::detection::DetectionsHeader;
use tagbus_message::domain::DomainError;
use tagbus_message::ports::DetectionsOut;
use tagbus_message::stats::{DETECTOR_HOPS, DetectorStats};
use tagbus_message::stats_ports::{ClientsTopic, StatsOut};
use tagbus_message::tally::{Tally, UNKNOWN, between};

use crate::search::Search;

/// Places in [`DETECTOR_HOPS`].
const RECEIVE: usize = 0;
const START: usize = 1;
const FIRST_PHASE: usize = 2;
const DETECT: usize = 6;
const SEND: usize = 7;
const WAKE: usize = 8;
const PHASES: usize = DETECT - FIRST_PHASE;

const _: () = assert!(WAKE + 1 == DETECTOR_HOPS.len());

/// How long the phases of one search took, of which each may come several times.
pub(crate) struct PhaseClock {
    last_ns: u64,
    spent_ns: [u64; PHASES],
}

impl PhaseClock {
    /// Starts with the search.
    pub(crate) fn new(start_ns: u64) -> Self {
        Self { last_ns: start_ns, spent_ns: [0; PHASES] }
    }

    /// To be called as a phase ends.
    pub(crate) fn ends(&mut self, phase: Phase) {
        let now_ns = monotonic_ns();
        let place = match phase {
            Phase::Binarize => 0,
            Phase::Cluster => 1,
            Phase::Fit => 2,
            Phase::Identify => 3,
        };
        self.spent_ns[place] += now_ns - self.last_ns;
        self.last_ns = now_ns;
    }
}

/// Counts, from the service's start to its end.
pub(crate) struct Recorder {
    stats: Box<DetectorStats>,
    tally: Tally<{ DETECTOR_HOPS.len() }>,
}

impl Recorder {
    pub(crate) fn new(epoch: u64) -> Self {
        let stats = Box::new(DetectorStats { epoch, started_ns: epoch, ..DetectorStats::default() });
        Self { stats, tally: Tally::default() }
    }

    /// Counts a frame whose message was sent and whose clients were woken at `woken_ns`.
    pub(crate) fn frame(&mut self, sent: &DetectionsHeader, phases: &PhaseClock, woken_ns: u64) {
        let mut hops = [UNKNOWN; DETECTOR_HOPS.len()];
        hops[RECEIVE] = between(sent.publish_ns, sent.receive_ns);
        hops[START] = between(sent.receive_ns, sent.detect_start_ns);
        hops[FIRST_PHASE..DETECT].copy_from_slice(&phases.spent_ns);
        hops[DETECT] = between(sent.detect_start_ns, sent.detect_end_ns);
        hops[SEND] = between(sent.detect_end_ns, sent.send_ns);
        hops[WAKE] = between(sent.send_ns, woken_ns);
        self.tally.frame(hops, &mut self.stats.hops);
    }
}

/// Where what was counted is published.
pub(crate) struct Tape<'a> {
    detections: &'a DetectionsOut<Local>,
    out: StatsOut<Local, DetectorStats>,
    clients: ClientsTopic<Local>,
    reserved_bytes: u64,
}

impl<'a> Tape<'a> {
    /// Names the topics of the detector's statistics and of its clients'; they are made when they are first due.
    pub(crate) fn new(
        bus: &Bus<Local>,
        camera: &str,
        detector: &str,
        detections: &'a DetectionsOut<Local>,
    ) -> Result<Self, DomainError> {
        Ok(Self {
            detections,
            out: bus.detector_stats(camera, detector)?,
            clients: bus.clients_topic(camera, detector)?,
            reserved_bytes: detections.reserved().bytes() as u64,
        })
    }

    /// Publishes when it is time to.
    pub(crate) fn look(&mut self, search: &mut Search) {
        if !self.out.is_due() {
            return;
        }
        let (state, summary) = (search.state.code(), search.summary);
        let Recorder { stats, tally } = &mut search.recorder;
        tally.count(&mut stats.hops);
        stats.state = state;
        stats.subscribers = self.detections.subscribers() as u32;
        stats.written_ns = monotonic_ns();
        stats.searched = summary.frames_searched;
        stats.skipped = summary.frames_skipped;
        stats.refused = summary.frames_refused;
        stats.unwatched = summary.frames_unwatched;
        stats.tags = summary.tags_found;
        stats.messages = summary.messages_sent;
        stats.reserved_bytes = self.reserved_bytes;
        stats.touched_bytes = self.detections.touched_bytes().unwrap_or(0);
        let published = self.out.publish(stats);
        if let Err(error) = published.and_then(|()| self.clients.look()) {
            search.trouble(format!("nobody can watch this detector: {error}"));
        }
    }
}
