//! What is known in the text format of Prometheus.

use std::collections::BTreeMap;
use std::fmt::Write;

use tagbus_message::control::DetectorState;
use tagbus_message::info::CameraState;
use tagbus_message::stats::{CAMERA_HOPS, CLIENT_HOPS, DETECTOR_HOPS};

use super::seen::{ClientLife, DetectorKey, Seen, client_name};
use super::track::{Counted, Life, Track};

/// Limits of the buckets are powers of two of nanoseconds, at which the recorder's own buckets end: nothing is guessed.
const FIRST_LIMIT: u32 = 13;
const LAST_LIMIT: u32 = 33;

const CAMERA_STATES: [CameraState; 6] = [
    CameraState::Unknown,
    CameraState::Starting,
    CameraState::Streaming,
    CameraState::Waiting,
    CameraState::Lost,
    CameraState::Ended,
];
const DETECTOR_STATES: [DetectorState; 5] = [
    DetectorState::Unknown,
    DetectorState::WaitingForCamera,
    DetectorState::Detecting,
    DetectorState::Silent,
    DetectorState::Paused,
];

/// The page.
pub(super) fn page(seen: &Seen, now_ns: u64) -> String {
    let mut page = Page::default();
    for (name, track) in &seen.cameras {
        let labels = Labels::new("camera", name, "", "", 0);
        page.role(&labels, track, &CAMERA_HOPS, track.life() == Life::Alive, now_ns);
        page.camera(&labels, track.last());
    }
    for (key, track) in &seen.detectors {
        let labels = Labels::new("detector", &key.camera, &key.detector, "", 0);
        page.role(&labels, track, &DETECTOR_HOPS, track.life() == Life::Alive, now_ns);
        page.detector(&labels, track.last());
    }
    let mut namesakes = BTreeMap::new();
    for (key, track) in &seen.clients {
        let DetectorKey { camera, detector } = &key.detector;
        let name = unique(&mut namesakes, &key.detector, client_name(track), track.last().process);
        let labels = Labels::new("client", camera, detector, &name, track.last().process);
        let life = seen.client_life(key, track, now_ns);
        page.role(&labels, track, &CLIENT_HOPS, life == ClientLife::Alive, now_ns);
        page.client(&labels, track.last(), life);
    }
    page.text()
}

/// Clients of one name in one process are numbered: no two series may have the same labels.
fn unique<'a>(
    namesakes: &mut BTreeMap<(&'a DetectorKey, String, u32), u32>,
    detector: &'a DetectorKey,
    name: String,
    process: u32,
) -> String {
    let count = namesakes.entry((detector, name.clone(), process)).or_default();
    *count += 1;
    if *count == 1 { name } else { format!("{name} {count}") }
}

/// Labels, as they are written.
struct Labels(String);

impl Labels {
    fn new(role: &str, camera: &str, detector: &str, client: &str, process: u32) -> Self {
        let mut text = format!("role=\"{role}\",camera=\"{}\"", escaped(camera));
        if role != "camera" {
            let _ = write!(text, ",detector=\"{}\"", escaped(detector));
        }
        if role == "client" {
            let _ = write!(text, ",client=\"{}\",process=\"{process}\"", escaped(client));
        }
        Self(text)
    }

    fn with(&self, name: &str, value: &str) -> Self {
        Self(format!("{},{name}=\"{}\"", self.0, escaped(value)))
    }
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

/// Lines by the metric that they belong to: those of one metric must stand together.
#[derive(Default)]
struct Page {
    metrics: BTreeMap<&'static str, (Metric, String)>,
}

/// What a metric is.
struct Metric {
    kind: &'static str,
    help: &'static str,
}

impl Page {
    fn lines(&mut self, name: &'static str, kind: &'static str, help: &'static str) -> &mut String {
        &mut self.metrics.entry(name).or_insert_with(|| (Metric { kind, help }, String::new())).1
    }

    fn counter(&mut self, name: &'static str, help: &'static str, labels: &Labels, value: u64) {
        let lines = self.lines(name, "counter", help);
        let _ = writeln!(lines, "{name}{{{}}} {value}", labels.0);
    }

    fn gauge(&mut self, name: &'static str, help: &'static str, labels: &Labels, value: f64) {
        let lines = self.lines(name, "gauge", help);
        let _ = writeln!(lines, "{name}{{{}}} {value}", labels.0);
    }

    fn states<'a>(&mut self, labels: &Labels, names: impl Iterator<Item = &'a str>, now: &str) {
        for name in names {
            let value = f64::from(u8::from(name == now));
            let help = "1 for the state that a camera or detector is in, 0 for all others.";
            self.gauge("tagbus_state", help, &labels.with("state", name), value);
        }
    }

    fn memory(&mut self, labels: &Labels, reserved: u64, touched: u64) {
        self.gauge(
            "tagbus_memory_reserved_bytes",
            "Shared memory that the topic of frames or of detections has reserved.",
            labels,
            reserved as f64,
        );
        self.gauge(
            "tagbus_memory_touched_bytes",
            "Shared memory of that topic that was ever written.",
            labels,
            touched as f64,
        );
    }

    fn role<T: Counted>(
        &mut self,
        labels: &Labels,
        track: &Track<T>,
        names: &[&str],
        is_up: bool,
        now_ns: u64,
    ) {
        let up = f64::from(u8::from(is_up));
        self.gauge("tagbus_up", "1 while a role carries on, 0 when it is stuck or gone.", labels, up);
        let age = track.age(now_ns).as_secs_f64();
        self.gauge("tagbus_age_seconds", "How old the numbers of a role are.", labels, age);
        for (hop, name) in track.last().hops().iter().zip(names) {
            self.hop(&labels.with("hop", name), hop);
        }
    }

    fn hop(&mut self, labels: &Labels, hop: &tagbus_message::histogram::Histogram) {
        self.counter(
            "tagbus_hop_backwards_total",
            "Hops that ended before they began: a clock that lies.",
            labels,
            hop.backwards,
        );
        let name = "tagbus_hop_seconds";
        let lines = self.lines(name, "histogram", "How long a hop took, since the role's start.");
        for limit in FIRST_LIMIT..=LAST_LIMIT {
            let limit_ns = 1_u64 << limit;
            let (le, count) = (limit_ns as f64 / 1e9, hop.count_up_to(limit_ns));
            let _ = writeln!(lines, "{name}_bucket{{{},le=\"{le}\"}} {count}", labels.0);
        }
        let _ = writeln!(lines, "{name}_bucket{{{},le=\"+Inf\"}} {}", labels.0, hop.count);
        let _ = writeln!(lines, "{name}_sum{{{}}} {}", labels.0, hop.sum_ns as f64 / 1e9);
        let _ = writeln!(lines, "{name}_count{{{}}} {}", labels.0, hop.count);
    }

    fn camera(&mut self, labels: &Labels, camera: &tagbus_message::stats::CameraStats) {
        self.counter("tagbus_frames_total", "Frames published.", labels, camera.frames);
        let lost = [
            ("driver", camera.lost_in_driver),
            ("damaged", camera.lost_damaged),
            ("no_memory", camera.lost_no_loan),
        ];
        for (cause, count) in lost {
            let help = "Frames lost, by cause.";
            self.counter("tagbus_frames_lost_total", help, &labels.with("cause", cause), count);
        }
        let help = "Frames of which a copy was made.";
        self.counter("tagbus_frames_copied_total", help, labels, camera.copied);
        self.memory(labels, camera.reserved_bytes, camera.touched_bytes);
        let now = CameraState::from_code(camera.state).name();
        self.states(labels, CAMERA_STATES.into_iter().map(CameraState::name), now);
    }

    fn detector(&mut self, labels: &Labels, detector: &tagbus_message::stats::DetectorStats) {
        let frames = [
            ("tagbus_frames_searched_total", "Frames searched.", detector.searched),
            (
                "tagbus_frames_skipped_total",
                "Frames that there was no time for, or that were lost.",
                detector.skipped,
            ),
            ("tagbus_frames_refused_total", "Frames whose header did not fit them.", detector.refused),
            ("tagbus_frames_unwatched_total", "Frames that nobody wanted searched.", detector.unwatched),
            ("tagbus_tags_total", "Tags found.", detector.tags),
            ("tagbus_messages_total", "Messages sent.", detector.messages),
        ];
        for (name, help, count) in frames {
            self.counter(name, help, labels, count);
        }
        let help = "Subscribers of a detector's messages.";
        self.gauge("tagbus_subscribers", help, labels, detector.subscribers.into());
        self.memory(labels, detector.reserved_bytes, detector.touched_bytes);
        let now = DetectorState::from_code(detector.state).name();
        self.states(labels, DETECTOR_STATES.into_iter().map(DetectorState::name), now);
    }

    fn client(&mut self, labels: &Labels, client: &tagbus_message::stats::ClientStats, life: ClientLife) {
        self.counter("tagbus_messages_received_total", "Messages received.", labels, client.received);
        let help = "Messages sent and not received: the client was too slow.";
        self.counter("tagbus_messages_missed_total", help, labels, client.missed);
        let help = "Messages of another version, or that contradict themselves.";
        self.counter("tagbus_messages_refused_total", help, labels, client.refused);
        let behind = match life {
            ClientLife::Stuck { behind, .. } => behind.unwrap_or_default(),
            ClientLife::Alive | ClientLife::Gone => 0,
        };
        let help = "Messages that a stuck client has not taken.";
        self.gauge("tagbus_messages_behind", help, labels, behind as f64);
    }

    fn text(&self) -> String {
        let metric = |(name, (metric, lines)): (&&str, &(Metric, String))| {
            format!("# HELP {name} {}\n# TYPE {name} {}\n{lines}", metric.help, metric.kind)
        };
        self.metrics.iter().map(metric).collect()
    }
}
