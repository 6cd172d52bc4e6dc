//! What a detector is asked, and what it answers.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

use super::asking::{CONTROL_SCHEMA, Outcome, REPLY_TEXT_BYTES, RequestKind, check_schema, read_text};
use super::fault::ControlFault;
use super::parameters::{DetectorChange, DetectorParameters, ParameterBlock, read_change, write_change};
use crate::text;

/// What a detector is asked.
#[derive(Clone, Debug, PartialEq)]
pub enum DetectorAsk {
    /// Nothing but the answer.
    Get,
    /// Other parameters from the next frame on: all of the change, or none of it.
    Set(DetectorChange),
    /// Statistics that begin anew.
    ResetStatistics,
}

/// A request to a detector as it travels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("tagbus.DetectorRequest.v1")]
pub struct DetectorRequest {
    /// Always [`CONTROL_SCHEMA`].
    pub schema: u32,
    /// A [`RequestKind`] code.
    pub kind: u32,
    /// One bit for each parameter that is set.
    pub mask: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// The values of those parameters.
    pub parameters: ParameterBlock,
}

const _: () = {
    assert!(size_of::<DetectorRequest>() == 1096);
    assert!(offset_of!(DetectorRequest, schema) == 0);
    assert!(offset_of!(DetectorRequest, kind) == 4);
    assert!(offset_of!(DetectorRequest, mask) == 8);
    assert!(offset_of!(DetectorRequest, reserved) == 12);
    assert!(offset_of!(DetectorRequest, parameters) == 16);
};

impl DetectorRequest {
    /// The request as it travels; a change that does not fit is an error.
    pub fn of(ask: &DetectorAsk) -> Result<Self, ControlFault> {
        let (kind, (parameters, mask)) = match ask {
            DetectorAsk::Get => (RequestKind::Get, Default::default()),
            DetectorAsk::Set(change) => (RequestKind::Set, write_change(change)?),
            DetectorAsk::ResetStatistics => (RequestKind::ResetStatistics, Default::default()),
        };
        Ok(Self { schema: CONTROL_SCHEMA, kind: kind.code(), mask, reserved: 0, parameters })
    }

    /// What is asked. Copy the request out of shared memory first and check the copy.
    pub fn checked(&self) -> Result<DetectorAsk, ControlFault> {
        check_schema(self.schema)?;
        match RequestKind::from_code(self.kind)? {
            RequestKind::Get => Ok(DetectorAsk::Get),
            RequestKind::Set => read_change(&self.parameters, self.mask).map(DetectorAsk::Set),
            RequestKind::ResetStatistics => Ok(DetectorAsk::ResetStatistics),
        }
    }
}

/// What a detector is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum DetectorState {
    /// Not known: a code of a newer version.
    Unknown = 0,
    /// The camera is not there.
    WaitingForCamera = 1,
    /// The camera is there, and its frames are searched as they come.
    Detecting = 2,
    /// The camera's topic is there, and no frame has come for three frame times.
    Silent = 3,
    /// Frames come, and are not searched because nobody subscribes to the detections.
    Paused = 4,
}

impl DetectorState {
    /// The state of a code.
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            1 => Self::WaitingForCamera,
            2 => Self::Detecting,
            3 => Self::Silent,
            4 => Self::Paused,
            _ => Self::Unknown,
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::WaitingForCamera => "waiting_for_camera",
            Self::Detecting => "detecting",
            Self::Silent => "silent",
            Self::Paused => "paused",
        }
    }
}

/// What a detector did since its start, or since its statistics were reset.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.DetectorStatistics.v1")]
pub struct DetectorStatistics {
    /// When the detector started, `CLOCK_MONOTONIC` nanoseconds.
    pub started_ns: u64,
    /// When these counts began, `CLOCK_MONOTONIC` nanoseconds.
    pub since_ns: u64,
    /// When these counts were taken, `CLOCK_MONOTONIC` nanoseconds.
    pub taken_ns: u64,
    /// Frames that were searched.
    pub frames_searched: u64,
    /// Frames that were passed over: no time for them, or lost by the camera.
    pub frames_skipped: u64,
    /// Frames whose header did not fit their bytes.
    pub frames_refused: u64,
    /// Tags found.
    pub tags_found: u64,
    /// Messages sent.
    pub messages_sent: u64,
    /// Time spent searching, nanoseconds.
    pub search_ns: u64,
    /// Starts of the camera that were seen.
    pub camera_starts: u64,
    /// Times that no frame came for three frame times.
    pub deadlines_missed: u64,
    /// Dead processes cleaned up.
    pub dead_cleaned: u64,
    /// Requests answered.
    pub requests_answered: u64,
    /// Requests that were not possible.
    pub requests_refused: u64,
}

/// A detector's reply as it travels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.DetectorReply.v1")]
pub struct DetectorReply {
    /// Always [`CONTROL_SCHEMA`].
    pub schema: u32,
    /// An [`Outcome`] code.
    pub outcome: u32,
    /// Number of the change that is in force, 0 before the first:
    /// [`crate::detection::DetectionsHeader::control_number`] of every message from the next on.
    pub control_number: u64,
    /// A [`DetectorState`] code.
    pub state: u32,
    /// Pixels a row of the last frame; 0 before the first.
    pub width: u32,
    /// Rows of the last frame; 0 before the first.
    pub height: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// All parameters in force.
    pub parameters: ParameterBlock,
    /// Counts and their times.
    pub statistics: DetectorStatistics,
    /// What is wrong with the request, or worth knowing about it; see [`crate::text`].
    pub text: [u8; REPLY_TEXT_BYTES],
}

const _: () = {
    assert!(size_of::<DetectorStatistics>() == 112);
    assert!(offset_of!(DetectorStatistics, requests_refused) == 104);
    assert!(size_of::<DetectorReply>() == 1736);
    assert!(offset_of!(DetectorReply, schema) == 0);
    assert!(offset_of!(DetectorReply, outcome) == 4);
    assert!(offset_of!(DetectorReply, control_number) == 8);
    assert!(offset_of!(DetectorReply, state) == 16);
    assert!(offset_of!(DetectorReply, width) == 20);
    assert!(offset_of!(DetectorReply, height) == 24);
    assert!(offset_of!(DetectorReply, reserved) == 28);
    assert!(offset_of!(DetectorReply, parameters) == 32);
    assert!(offset_of!(DetectorReply, statistics) == 1112);
    assert!(offset_of!(DetectorReply, text) == 1224);
};

/// What a detector answered.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectorAnswer {
    /// How the request ended.
    pub outcome: Outcome,
    /// What is wrong with the request, or worth knowing about it; may be empty.
    pub text: String,
    /// Number of the change that is in force, 0 before the first.
    pub control_number: u64,
    /// What the detector is doing.
    pub state: DetectorState,
    /// Width and height of the last frame in pixels; `None` before the first.
    pub frame_size: Option<(u32, u32)>,
    /// All parameters in force.
    pub parameters: DetectorParameters,
    /// Counts and their times.
    pub statistics: DetectorStatistics,
}

impl DetectorReply {
    /// The answer as it travels.
    #[must_use]
    pub fn of(answer: &DetectorAnswer) -> Self {
        let (width, height) = answer.frame_size.unwrap_or_default();
        let mut reply = Self {
            schema: CONTROL_SCHEMA,
            outcome: answer.outcome.code(),
            control_number: answer.control_number,
            state: answer.state.code(),
            width,
            height,
            reserved: 0,
            parameters: ParameterBlock::of(&answer.parameters),
            statistics: answer.statistics,
            text: [0; REPLY_TEXT_BYTES],
        };
        text::write_cut(&mut reply.text, &answer.text);
        reply
    }

    /// What was answered. Copy the reply out of shared memory first and check the copy.
    pub fn checked(&self) -> Result<DetectorAnswer, ControlFault> {
        check_schema(self.schema)?;
        Ok(DetectorAnswer {
            outcome: Outcome::from_code(self.outcome),
            text: read_text(&self.text, "text of the reply")?,
            control_number: self.control_number,
            state: DetectorState::from_code(self.state),
            frame_size: (self.width > 0).then_some((self.width, self.height)),
            parameters: self.parameters.checked()?,
            statistics: self.statistics,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{MAX_ID_RANGES, RefinementChoice, Region, SamplingChoice, SearchChoice};
    use crate::detection::MAX_NAMED_FAMILIES;

    fn everything() -> DetectorChange {
        DetectorChange {
            decimation: Some(1.5),
            sampling: Some(SamplingChoice::Darkest),
            search: Some(SearchChoice::Fine),
            threads: Some(4),
            hamming: Some(Some(1)),
            refinement: Some(RefinementChoice::Tag),
            sharpening: Some(0.25),
            min_margin: Some(3.0),
            region: Some(Some(Region { x: 1, y: 2, width: 300, height: 400 })),
            families: Some(vec!["tag36h11".into(), "my-own".into()]),
            ids: Some(vec![(1, 20), (33, 33)]),
        }
    }

    fn answer() -> DetectorAnswer {
        DetectorAnswer {
            outcome: Outcome::Refused,
            text: "decimation 7.5 is not possible".into(),
            control_number: 9,
            state: DetectorState::Detecting,
            frame_size: Some((640, 480)),
            parameters: DetectorParameters {
                decimation: 2.0,
                sampling: SamplingChoice::Point,
                search: SearchChoice::Quick,
                threads: 1,
                hamming: None,
                refinement: RefinementChoice::Edges,
                sharpening: 1.0,
                min_margin: 0.0,
                region: None,
                families: vec!["tag36h11".into()],
                ids: vec![(3, 5)],
            },
            statistics: DetectorStatistics { frames_searched: 5, ..DetectorStatistics::default() },
        }
    }

    #[test]
    fn what_was_asked_is_what_is_read() {
        let backwards = DetectorChange {
            hamming: Some(None),
            region: Some(None),
            ids: Some(vec![]),
            ..Default::default()
        };
        for change in [everything(), backwards, DetectorChange::default()] {
            let ask = DetectorAsk::Set(change);
            assert_eq!(DetectorRequest::of(&ask).unwrap().checked().unwrap(), ask);
        }
        for ask in [DetectorAsk::Get, DetectorAsk::ResetStatistics] {
            assert_eq!(DetectorRequest::of(&ask).unwrap().checked().unwrap(), ask);
        }
    }

    #[test]
    fn what_was_answered_is_what_is_read() {
        assert_eq!(DetectorReply::of(&answer()).checked().unwrap(), answer());
    }

    #[test]
    fn a_value_that_is_not_set_is_not_looked_at() {
        let mut request = DetectorRequest::of(&DetectorAsk::Set(DetectorChange::default())).unwrap();
        request.parameters.decimation = f32::NAN;
        request.parameters.family_count = u32::MAX;
        request.parameters.search = 99;
        assert_eq!(request.checked().unwrap(), DetectorAsk::Set(DetectorChange::default()));
    }

    #[test]
    fn requests_that_cannot_be_are_refused_with_what_they_say() {
        let good = DetectorRequest::of(&DetectorAsk::Set(everything())).unwrap();
        let lie = |change: fn(&mut DetectorRequest)| {
            let mut request = good;
            change(&mut request);
            request.checked().unwrap_err().to_string()
        };
        assert!(lie(|request| request.schema = 7).contains("version 7"));
        assert!(lie(|request| request.kind = 0).contains("kind 0"));
        assert!(lie(|request| request.mask |= 1 << 30).contains("0x40000000"));
        assert!(lie(|request| request.parameters.decimation = f32::NAN).contains("NaN"));
        assert!(lie(|request| request.parameters.hamming = -2).contains("-2"));
        assert!(lie(|request| request.parameters.search = 3).contains("search number 3"));
        assert!(lie(|request| request.parameters.family_count = 17).contains("17 families"));
        assert!(lie(|request| request.parameters.id_count = 65).contains("65 ranges"));
        assert!(lie(|request| request.parameters.ids[0] = [5, 4]).contains("5 to 4"));
        assert!(lie(|request| request.parameters.families[1] = [0xff; 32]).contains("UTF-8"));
    }

    #[test]
    fn a_change_that_does_not_fit_is_refused_before_it_is_sent() {
        let refused = |change| DetectorRequest::of(&DetectorAsk::Set(change)).unwrap_err().to_string();
        let many = vec!["x".to_owned(); MAX_NAMED_FAMILIES + 1];
        let text = refused(DetectorChange { families: Some(many), ..Default::default() });
        assert!(text.contains("17 families, but at most 16"), "{text}");
        let long = vec!["x".repeat(33)];
        let text = refused(DetectorChange { families: Some(long), ..Default::default() });
        assert!(text.contains("33 bytes but at most 32"), "{text}");
        let ids = vec![(1, 1); MAX_ID_RANGES + 1];
        let text = refused(DetectorChange { ids: Some(ids), ..Default::default() });
        assert!(text.contains("65 ranges of ids"), "{text}");
    }

    #[test]
    fn no_bytes_of_a_request_or_reply_make_a_reader_panic() {
        let mut random = crate::random::Random::new(7);
        for _ in 0..2000 {
            let mut request = DetectorRequest::of(&DetectorAsk::Set(everything())).unwrap();
            let mut reply = DetectorReply::of(&answer());
            request.mask = random.next() as u32;
            let block = &mut request.parameters;
            (block.family_count, block.id_count) = (random.next() as u32 % 40, random.next() as u32 % 80);
            block.hamming = random.next() as i32;
            block.region = [0; 4].map(|_: u32| random.next() as u32);
            for field in block.families.iter_mut().flatten() {
                *field = random.next() as u8;
            }
            block.decimation = f32::from_bits(random.next() as u32);
            reply.parameters = *block;
            for byte in &mut reply.text {
                *byte = random.next() as u8;
            }
            let _ = (request.checked(), reply.checked());
        }
    }
}
