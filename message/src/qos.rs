//! Every number of the topics' quality of service, and the memory that follows from them.

use std::fmt;
use std::mem::size_of;
use std::time::Duration;

use crate::detection::{DetectionsHeader, TagDetection};
use crate::frame::FrameHeader;

/// Frame chunks may not be more than this: the kernel's limit of buffers of a V4L2 queue, so that each chunk can
/// keep a buffer index of its own.
pub const MAX_FRAME_CHUNKS: usize = 32;
/// Tags that a detections message holds unless configured otherwise.
pub const DEFAULT_MAX_TAGS: usize = 512;
/// Tags that a detections message can be configured to hold.
pub const MAX_TAGS_LIMIT: usize = 65_536;
/// Processes (or roles within one) that may have a topic open.
pub const MAX_NODES: usize = 64;
/// Ports that may be woken by a topic.
pub const MAX_LISTENERS: usize = 48;
/// Ports that may wake on a topic.
pub const MAX_NOTIFIERS: usize = 8;
/// Programs that can have a control topic open to ask, beside the one role that answers.
pub const MAX_CONTROL_CLIENTS: usize = 8;
/// The event that says that there is something to receive.
pub const EVENT_SENT: usize = 1;
/// The event that a producer's coming causes.
pub const EVENT_PRODUCER_CAME: usize = 10;
/// The event that a producer's orderly end causes.
pub const EVENT_PRODUCER_WENT: usize = 11;
/// The event that is caused by whoever finds a producer dead.
pub const EVENT_PRODUCER_DIED: usize = 12;
/// Highest event number.
pub const EVENT_MAX: usize = 15;
/// How long iceoryx2 waits for a half-made topic before it says so; the start loop has the patience.
pub const CREATION_TIMEOUT: Duration = Duration::from_millis(100);
/// Bytes that iceoryx2 puts before each user header.
const CHUNK_HEADER: usize = 48;

/// Quality of service of a publish-subscribe topic. Overflow is on everywhere: the newest message replaces the
/// oldest, and no subscriber can block a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicQos {
    /// Subscribers that can be there at once.
    pub subscribers: usize,
    /// Messages queued for each subscriber.
    pub buffer: usize,
    /// Messages that each subscriber can hold at once.
    pub borrowed: usize,
    /// Messages that a late subscriber gets.
    pub history: usize,
    /// Messages that the publisher can have in work at once.
    pub loans: usize,
}

/// Frames: few readers, each of which wants the newest. Five loans: four for a driver's queue and one being sent.
pub const FRAMES: TopicQos = TopicQos { subscribers: 6, buffer: 2, borrowed: 2, history: 1, loans: 5 };
/// Detections: many readers of small messages.
pub const DETECTIONS: TopicQos = TopicQos { subscribers: 40, buffer: 4, borrowed: 2, history: 1, loans: 2 };
/// Camera information: the last one counts.
pub const INFO: TopicQos = TopicQos { subscribers: 40, buffer: 1, borrowed: 1, history: 1, loans: 1 };
/// What roles count about themselves: the last copy counts. Clients of one detector share a topic, on which each is a publisher.
pub const STATS: TopicQos = TopicQos { subscribers: 8, buffer: 2, borrowed: 1, history: 1, loans: 1 };
/// Clients of one detector that can publish what they count: as many as there can be.
pub const MAX_CLIENT_STATS: usize = DETECTIONS.subscribers;
/// Frames that a detector lets queue: it wants the newest only.
pub const DETECTOR_FRAME_BUFFER: usize = 1;

impl TopicQos {
    /// Chunks that a publisher reserves so that a loan can never fail for want of memory.
    #[must_use]
    pub const fn chunks(&self) -> usize {
        self.subscribers * (self.buffer + self.borrowed) + self.history + self.loans
    }

    /// The sum of [`TopicQos::chunks`] in words and numbers.
    #[must_use]
    pub fn arithmetic(&self) -> String {
        let Self { subscribers, buffer, borrowed, history, loans } = self;
        format!(
            "{subscribers} subscribers x ({buffer} buffered + {borrowed} borrowed) + {history} history + {loans} loans = {} chunks",
            self.chunks()
        )
    }
}

/// The frames topic with another number of loans (a driver's buffers and one more).
///
/// Refused when the sum of chunks passes [`MAX_FRAME_CHUNKS`].
pub fn frames_with_loans(loans: usize) -> Result<TopicQos, QosError> {
    let qos = TopicQos { loans, ..FRAMES };
    if loans == 0 || qos.chunks() > MAX_FRAME_CHUNKS {
        return Err(QosError::FrameChunks(qos));
    }
    Ok(qos)
}

/// Checks a capacity of detections messages.
pub fn check_max_tags(max_tags: usize) -> Result<usize, QosError> {
    if (1..=MAX_TAGS_LIMIT).contains(&max_tags) { Ok(max_tags) } else { Err(QosError::MaxTags(max_tags)) }
}

/// Memory of one publisher. It is virtual: only pages that were touched take room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reserved {
    /// Chunks.
    pub chunks: usize,
    /// Bytes of one chunk.
    pub chunk_bytes: usize,
}

impl Reserved {
    /// What a frames publisher reserves for payloads of `payload_bytes`.
    #[must_use]
    pub fn frames(qos: &TopicQos, payload_bytes: usize) -> Self {
        let chunk_bytes = CHUNK_HEADER + size_of::<FrameHeader>() + payload_bytes;
        Self { chunks: qos.chunks(), chunk_bytes: chunk_bytes.next_multiple_of(8) }
    }

    /// What a detections publisher reserves for messages of at most `max_tags` tags.
    #[must_use]
    pub fn detections(max_tags: usize) -> Self {
        let chunk_bytes = CHUNK_HEADER + size_of::<DetectionsHeader>() + max_tags * size_of::<TagDetection>();
        Self { chunks: DETECTIONS.chunks(), chunk_bytes }
    }

    /// All bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.chunks * self.chunk_bytes
    }
}

impl fmt::Display for Reserved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let megabytes = self.bytes() as f64 / 1e6;
        write!(
            f,
            "{} chunks of {} bytes = {megabytes:.1} MB reserved, pages are used when touched",
            self.chunks, self.chunk_bytes
        )
    }
}

/// Why a quality of service was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum QosError {
    /// Too many frame chunks, or no loan at all.
    FrameChunks(TopicQos),
    /// A message must hold at least one tag and not more than [`MAX_TAGS_LIMIT`].
    MaxTags(usize),
}

impl fmt::Display for QosError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FrameChunks(qos) => write!(
                f,
                "{}, but frames need at least 1 loan and may have at most {MAX_FRAME_CHUNKS} chunks (buffers of a V4L2 queue): use 1 to {} loans",
                qos.arithmetic(),
                MAX_FRAME_CHUNKS - (FRAMES.chunks() - FRAMES.loans)
            ),
            Self::MaxTags(seen) => {
                write!(f, "room for {seen} tags in a message is not possible: use 1 to {MAX_TAGS_LIMIT}")
            }
        }
    }
}

impl std::error::Error for QosError {}

const _: () = assert!(FRAMES.chunks() <= MAX_FRAME_CHUNKS);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_those_of_the_bus_contract() {
        assert_eq!(FRAMES.chunks(), 30);
        assert_eq!(DETECTIONS.chunks(), 243);
        assert_eq!(Reserved::frames(&FRAMES, 1280 * 800).bytes() / 1_000_000, 30);
        assert_eq!(Reserved::detections(512).bytes() / 1_000_000, 63);
    }

    #[test]
    fn too_many_loans_are_refused_with_the_arithmetic() {
        assert!(frames_with_loans(7).is_ok());
        let error = frames_with_loans(8).unwrap_err().to_string();
        assert!(
            error.contains("6 subscribers x (2 buffered + 2 borrowed) + 1 history + 8 loans = 33"),
            "{error}"
        );
        assert!(error.contains("1 to 7 loans"), "{error}");
        assert!(frames_with_loans(0).is_err());
    }

    #[test]
    fn a_message_without_room_is_refused() {
        assert!(check_max_tags(0).is_err() && check_max_tags(MAX_TAGS_LIMIT + 1).is_err());
        assert_eq!(check_max_tags(1), Ok(1));
    }
}
