//! What one client counts.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tagbus_client::{Detections, DetectionsHeader};

/// What messages of one change had in common.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InForce {
    pub(crate) decimation: f64,
    pub(crate) hamming: i64,
    pub(crate) flags: u64,
    /// The first and the last frame that was searched so.
    pub(crate) frames: [u64; 2],
    /// The smallest and the largest id of a tag, when there was one.
    pub(crate) ids: Option<[u64; 2]>,
}

/// The counters of one client.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    /// Messages that arrived.
    pub(crate) received: u64,
    /// Messages that were sent but left this client's queue before it came to them.
    pub(crate) missed: u64,
    /// Messages before which a frame is neither sent nor counted as skipped.
    pub(crate) unaccounted: u64,
    /// Starts of the camera or the detector after the first.
    pub(crate) restarts: u64,
    /// Messages of an older change than the message before.
    pub(crate) backwards: u64,
    /// Messages whose parameters differ from another message of the same change.
    pub(crate) mixed: u64,
    /// By number of the change.
    pub(crate) changes: BTreeMap<u64, InForce>,
    /// The header of the last message.
    pub(crate) last: Option<DetectionsHeader>,
}

impl Tally {
    /// Takes note of a message.
    pub(crate) fn take(&mut self, message: &Detections) {
        let header = message.header();
        self.received += 1;
        self.follow(header);
        let tags = message.tags().iter().map(|tag| u64::from(tag.id));
        let ids = tags.clone().min().zip(tags.max()).map(|(least, most)| [least, most]);
        self.note_parameters(header, ids);
    }

    /// Reads a message that may lie in every field, and counts it.
    pub(crate) fn count(&mut self, message: &Detections) {
        self.received += 1;
        std::hint::black_box(format!("{:?} {:?}", message.header(), message.tags()));
    }

    /// Between two messages each frame was sent, or counted by the detector as skipped.
    fn follow(&mut self, header: &DetectionsHeader) {
        let Some(last) = self.last.replace(*header) else { return };
        if (last.epoch, last.detector_epoch) != (header.epoch, header.detector_epoch) {
            self.restarts += 1;
            return;
        }
        let messages = header.message_number.saturating_sub(last.message_number);
        let frames = header.sequence.saturating_sub(last.sequence);
        let skipped = header.skipped_total.saturating_sub(last.skipped_total);
        self.missed += messages.saturating_sub(1);
        self.unaccounted += u64::from(messages == 0 || frames != messages + skipped);
        self.backwards += u64::from(header.control_number < last.control_number);
    }

    fn note_parameters(&mut self, header: &DetectionsHeader, ids: Option<[u64; 2]>) {
        let now = InForce {
            decimation: f64::from(header.decimation),
            hamming: i64::from(header.hamming),
            flags: u64::from(header.flags),
            frames: [header.sequence; 2],
            ids,
        };
        let known = self.changes.entry(header.control_number).or_insert_with(|| now.clone());
        let parameters = |of: &InForce| (of.decimation, of.hamming, of.flags);
        self.mixed += u64::from(parameters(known) != parameters(&now));
        known.widen(&now);
    }

    /// One line, from which [`Tally::read`] makes the counters again.
    pub(crate) fn line(&self) -> String {
        let change = |(number, now): (&u64, &InForce)| {
            json!([number, now.decimation, now.hamming, now.flags, now.frames, now.ids])
        };
        let changes: Vec<Value> = self.changes.iter().map(change).collect();
        let Self { received, missed, unaccounted, restarts, backwards, mixed, .. } = self;
        json!({
            "received": received, "missed": missed, "unaccounted": unaccounted, "restarts": restarts,
            "backwards": backwards, "mixed": mixed, "changes": changes,
        })
        .to_string()
    }

    /// `None` for a line that is none of ours.
    pub(crate) fn read(line: &str) -> Option<Self> {
        let line: Value = serde_json::from_str(line).ok()?;
        let number = |name: &str| line[name].as_u64();
        let changes: Option<BTreeMap<_, _>> = line["changes"].as_array()?.iter().map(change).collect();
        Some(Self {
            received: number("received")?,
            missed: number("missed")?,
            unaccounted: number("unaccounted")?,
            restarts: number("restarts")?,
            backwards: number("backwards")?,
            mixed: number("mixed")?,
            changes: changes?,
            last: None,
        })
    }
}

impl InForce {
    /// Takes in the frames and ids of `other`.
    pub(crate) fn widen(&mut self, other: &Self) {
        let widened = |a: [u64; 2], b: [u64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.frames = widened(self.frames, other.frames);
        self.ids = match (self.ids, other.ids) {
            (Some(own), Some(others)) => Some(widened(own, others)),
            (own, others) => own.or(others),
        };
    }
}

fn change(value: &Value) -> Option<(u64, InForce)> {
    let pair = |value: &Value| Some([value.get(0)?.as_u64()?, value.get(1)?.as_u64()?]);
    let now = InForce {
        decimation: value[1].as_f64()?,
        hamming: value[2].as_i64()?,
        flags: value[3].as_u64()?,
        frames: pair(&value[4])?,
        ids: pair(&value[5]),
    };
    Some((value[0].as_u64()?, now))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(message_number: u64, sequence: u64, skipped_total: u64) -> DetectionsHeader {
        DetectionsHeader { message_number, sequence, skipped_total, ..DetectionsHeader::default() }
    }

    #[test]
    fn a_frame_that_is_neither_sent_nor_counted_is_noticed() {
        let mut tally = Tally::default();
        for header in [header(0, 7, 1), header(1, 8, 1), header(4, 13, 3)] {
            tally.follow(&header);
        }
        assert_eq!((tally.missed, tally.unaccounted), (2, 0));
        tally.follow(&header(5, 16, 4));
        assert_eq!(tally.unaccounted, 1);
        tally.follow(&header(5, 16, 4));
        assert_eq!(tally.unaccounted, 2);
    }

    #[test]
    fn two_parameter_sets_under_one_number_and_numbers_that_go_back_are_noticed() {
        let mut tally = Tally::default();
        let change =
            |control_number, hamming| DetectionsHeader { control_number, hamming, ..header(0, 0, 0) };
        tally.note_parameters(&change(1, 2), Some([3, 5]));
        tally.note_parameters(&change(1, 2), Some([1, 4]));
        assert_eq!((tally.mixed, tally.changes[&1].ids), (0, Some([1, 5])));
        tally.note_parameters(&change(1, 0), None);
        assert_eq!(tally.mixed, 1);
        for (message, number) in [(0, 4), (1, 3)] {
            tally.follow(&DetectionsHeader { control_number: number, ..header(message, message, 0) });
        }
        assert_eq!(tally.backwards, 1);
        assert_eq!(Tally::read(&tally.line()).unwrap(), Tally { last: None, ..tally });
    }
}
