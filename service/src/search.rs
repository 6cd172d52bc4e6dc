//! One frame: from the received sample to the sent message.

use std::time::Instant;

use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;

use tagbus_detector::{Detection, Detector, Geometry, LumaView};
use tagbus_message::clock::monotonic_ns;
use tagbus_message::detection::{DetectionsHeader, header_flags};
use tagbus_message::frame::FrameHeader;
use tagbus_message::ports::DetectionsOut;

use crate::config::{FrameSeen, Observer, Reporter, ServiceConfig};
use crate::convert::{self, FamilyName};
use crate::pace::Pace;
use crate::report::{Limiter, Report, ServiceError, Summary};

/// The variant of iceoryx2 within this process: its ports stay in one thread.
pub(crate) type Local = ipc::Service;
/// A frame in shared memory.
pub(crate) type FrameSample = Sample<Local, [u8], FrameHeader>;

/// Everything that is kept from frame to frame.
pub(crate) struct Search {
    detector: Detector,
    names: Vec<FamilyName>,
    template: DetectionsHeader,
    chosen: Vec<usize>,
    pub(crate) pace: Pace,
    pub(crate) summary: Summary,
    refusals: Limiter,
    troubles: Limiter,
    max_tags: usize,
    report: Reporter,
    observer: Option<Observer>,
}

impl Search {
    /// Takes the parts of the configuration that concern the search.
    pub(crate) fn new(config: ServiceConfig) -> Result<Self, ServiceError> {
        let names = convert::family_names(&config.families).map_err(ServiceError::Family)?;
        let detector = Detector::new(&config.families, &config.settings).map_err(ServiceError::Settings)?;
        // Two starts never fall on one nanosecond of the same clock.
        let template = convert::header_template(&config.settings, &names, monotonic_ns());
        Ok(Self {
            detector,
            names,
            template,
            chosen: Vec::with_capacity(config.max_tags),
            pace: Pace::new(),
            summary: Summary::default(),
            refusals: Limiter::default(),
            troubles: Limiter::default(),
            max_tags: config.max_tags,
            report: config.report,
            observer: config.observer,
        })
    }

    /// Searches one frame and sends what was found; a frame that lies about itself is counted and reported instead.
    pub(crate) fn frame(&mut self, frame: FrameSample, out: &DetectionsOut<Local>) {
        let receive_ns = monotonic_ns();
        // The header is copied out once: the camera could change it while it is checked.
        let header = *frame.user_header();
        let view = match checked_view(&header, frame.payload()) {
            Ok(view) => view,
            Err(reason) => return self.refuse(&header, reason),
        };
        let step = self.pace.step(&header);
        self.summary.camera_starts += u64::from(step.new_epoch);
        self.summary.frames_skipped = self.summary.frames_skipped.saturating_add(step.skipped);
        if let Some(observer) = &mut self.observer {
            observer(&FrameSeen { header: &header, view: &view, payload: frame.payload().as_ptr_range() });
        }
        let detect_start_ns = monotonic_ns();
        let detections = self.detector.detect(&view);
        let detect_end_ns = monotonic_ns();
        self.summary.frames_searched += 1;
        self.summary.tags_found += detections.len() as u64;
        convert::choose(detections, self.max_tags, &mut self.chosen);
        let message = DetectionsHeader {
            message_number: self.summary.messages_sent,
            receive_ns,
            detect_start_ns,
            detect_end_ns,
            count: self.chosen.len() as u32,
            found: detections.len() as u32,
            flags: if self.chosen.len() < detections.len() { header_flags::MORE_FOUND } else { 0 },
            skipped: u32::try_from(step.skipped).unwrap_or(u32::MAX),
            skipped_total: self.summary.frames_skipped,
            refused_total: self.summary.frames_refused,
            ..convert::header_of_frame(&self.template, &header)
        };
        // The camera gets its chunk back before clients are woken.
        drop(frame);
        match send(message, detections, &self.chosen, &self.names, out) {
            Ok(()) => self.summary.messages_sent += 1,
            Err(reason) => self.trouble(reason),
        }
    }

    /// Tells the user something that happens rarely.
    pub(crate) fn tell(&mut self, report: &Report) {
        (self.report)(report);
    }

    /// Tells of something that went wrong, at most once a second.
    pub(crate) fn trouble(&mut self, reason: String) {
        if self.troubles.lets_through(Instant::now()) {
            self.tell(&Report::Trouble { reason });
        }
    }

    fn refuse(&mut self, header: &FrameHeader, reason: String) {
        self.summary.frames_refused += 1;
        if self.refusals.lets_through(Instant::now()) {
            let total = self.summary.frames_refused;
            self.tell(&Report::Refused { sequence: header.sequence, reason, total });
        }
    }
}

/// The luma of a frame where it lies, or what its header says that cannot be.
fn checked_view<'a>(header: &FrameHeader, payload: &'a [u8]) -> Result<LumaView<'a>, String> {
    let layout = header.validate(payload.len()).map_err(|error| error.to_string())?;
    let geometry = Geometry {
        offset: layout.offset,
        width: layout.width,
        height: layout.height,
        row_stride: layout.row_stride,
        pixel_step: layout.pixel_step,
    };
    LumaView::new(payload, geometry).map_err(|error| error.to_string())
}

/// Writes a message into shared memory, sends it and then wakes the clients.
fn send(
    mut header: DetectionsHeader,
    detections: &[Detection],
    chosen: &[usize],
    names: &[FamilyName],
    out: &DetectionsOut<Local>,
) -> Result<(), String> {
    let loan = out
        .publisher()
        .loan_slice_uninit(chosen.len())
        .map_err(|error| format!("no memory for a message of {} tags ({error:?})", chosen.len()))?;
    let mut loan = loan.write_from_fn(|place| convert::tag(&detections[chosen[place]], names));
    header.send_ns = monotonic_ns();
    *loan.user_header_mut() = header;
    loan.send().map_err(|error| format!("a message could not be sent ({error:?})"))?;
    out.notify().map_err(|error| format!("clients could not be woken ({error:?})"))?;
    Ok(())
}
