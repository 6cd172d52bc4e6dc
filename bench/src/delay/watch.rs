//! Watching what a detector sees of a pattern.

use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, Detections};
use tagbus_message::detection::DetectionsHeader;
use tagbus_message::frame::ClockKind;

use super::interval::{Delay, Delays, Span};
use super::numbered;
use super::pattern::Pattern;
use crate::Failure;

/// A silence that is an error.
const PATIENCE: Duration = Duration::from_secs(10);

/// What the hops of a frame are called, from the moment that it shows to each of its stamps.
pub(super) const HOPS: [&str; 6] =
    ["stamp of the camera", "dequeue", "publish", "detector awake", "detector done", "client"];

/// What was seen of a pattern.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    /// From showing to each of [`HOPS`].
    pub(super) delays: [Delays; HOPS.len()],
    /// Messages without a tag of the pattern or with several different ones, or of frames without a number.
    pub(super) unclear: u64,
    /// Messages whose stamp is of another clock, which cannot be compared.
    pub(super) other_clock: u64,
}

/// Listens to a detector for so long.
pub(crate) fn watch(
    options: &ConnectOptions,
    pattern: &Pattern,
    duration: Duration,
) -> Result<Seen, Failure> {
    if pattern.is_number() {
        return numbered::watch(options, pattern, duration);
    }
    let mut client = Client::connect(options)?;
    let (begun, mut last, mut seen) = (Instant::now(), Instant::now(), Seen::default());
    while begun.elapsed() < duration {
        match client.receive(Duration::from_millis(200))? {
            Some(message) => {
                seen.take(&message, pattern);
                last = Instant::now();
            }
            None if last.elapsed() > PATIENCE => {
                return Err("the detector sends nothing: does its camera run?".into());
            }
            None => {}
        }
    }
    if seen.is_empty() {
        let family = pattern.family().name();
        return Err(format!(
            "no message of {} shows the pattern: is it in the picture, and does the detector look for {family}?",
            seen.unclear
        )
        .into());
    }
    Ok(seen)
}

impl Seen {
    fn take(&mut self, message: &Detections, pattern: &Pattern) {
        let family = pattern.family().name();
        let mut ids: Vec<u32> =
            message.tags().iter().filter(|tag| tag.family() == family).map(|tag| tag.id).collect();
        ids.dedup();
        let id = if let [id] = ids[..] { Some(id) } else { None };
        self.take_shown(id, pattern, message.header(), message.client_ns());
    }

    /// What a message's frame showed, if that is clear.
    pub(super) fn take_shown(
        &mut self,
        shown: Option<u32>,
        pattern: &Pattern,
        header: &DetectionsHeader,
        client_ns: u64,
    ) {
        match shown.and_then(|shown| pattern.shown(shown, client_ns)) {
            Some(span) => self.note(span, header, client_ns),
            None => self.unclear += 1,
        }
    }

    /// Whether nothing clear was seen.
    pub(super) fn is_empty(&self) -> bool {
        self.delays[HOPS.len() - 1].count() == 0
    }

    fn note(&mut self, span: Span, header: &DetectionsHeader, client_ns: u64) {
        let has_stamp = header.capture_clock == ClockKind::Monotonic as u32;
        self.other_clock += u64::from(!has_stamp);
        let stamp_ns = has_stamp.then_some(header.capture_ns);
        let stamps = [
            stamp_ns,
            Some(header.dequeue_ns),
            Some(header.publish_ns),
            Some(header.receive_ns),
            Some(header.detect_end_ns),
            Some(client_ns),
        ];
        for (delays, stamp_ns) in self.delays.iter_mut().zip(stamps) {
            if let Some(stamp_ns) = stamp_ns {
                delays.add(Delay::between(span, stamp_ns));
            }
        }
    }
}
