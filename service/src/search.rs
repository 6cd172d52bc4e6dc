//! One frame: from the received sample to the sent message.

use std::time::Instant;

use iceoryx2::sample::Sample;

use tagbus_detector::{Detection, Geometry, LumaView};
use tagbus_message::Local;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::control::DetectorState;
use tagbus_message::detection::{DetectionsHeader, header_flags};
use tagbus_message::frame::FrameHeader;
use tagbus_message::ports::DetectionsOut;

use crate::config::{FrameSeen, Moment, Observer, Reporter, ServiceConfig, Watch};
use crate::convert::{self, FamilyName};
use crate::in_force::{InForce, Wish};
use crate::pace::Pace;
use crate::recorder::{PhaseClock, Recorder};
use crate::region;
use crate::report::{Limiter, Report, ServiceError, Summary};

/// A frame in shared memory.
pub(crate) type FrameSample = Sample<Local, [u8], FrameHeader>;

/// Changes that are told a second; a gap in their numbers says that there were more.
const CHANGES_TOLD: u32 = 10;

/// Everything that is kept from frame to frame.
pub(crate) struct Search {
    pub(crate) in_force: InForce,
    /// [`DetectionsHeader::detector_epoch`]; also the time of the start, `CLOCK_MONOTONIC` nanoseconds.
    pub(crate) epoch: u64,
    pub(crate) state: DetectorState,
    /// Width and height of the last frame.
    pub(crate) frame_size: Option<(u32, u32)>,
    chosen: Vec<usize>,
    pub(crate) pace: Pace,
    pub(crate) summary: Summary,
    pub(crate) recorder: Recorder,
    refusals: Limiter,
    troubles: Limiter,
    changes: Limiter,
    max_tags: usize,
    always: bool,
    report: Reporter,
    observer: Option<Observer>,
    watch: Option<Watch>,
}

impl Search {
    /// Takes the parts of the configuration that concern the search.
    pub(crate) fn new(config: ServiceConfig) -> Result<Self, ServiceError> {
        let wish = Wish { families: config.families, settings: config.settings, region: config.region };
        // Two starts never fall on one nanosecond of the same clock.
        let epoch = monotonic_ns();
        Ok(Self {
            in_force: InForce::new(wish, epoch, 0)?,
            epoch,
            state: DetectorState::WaitingForCamera,
            frame_size: None,
            chosen: Vec::with_capacity(config.max_tags),
            pace: Pace::new(),
            summary: Summary::default(),
            recorder: Recorder::new(epoch),
            refusals: Limiter::of(1),
            troubles: Limiter::of(1),
            changes: Limiter::of(CHANGES_TOLD),
            max_tags: config.max_tags,
            always: config.always,
            report: config.report,
            observer: config.observer,
            watch: config.watch,
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
        self.frame_size = Some((header.width, header.height));
        if !self.always && out.subscribers() == 0 {
            self.state = DetectorState::Paused;
            self.summary.frames_unwatched += 1;
            return;
        }
        self.state = DetectorState::Detecting;
        let InForce { detector, wish, names, template, .. } = &mut self.in_force;
        let part = region::cut(&view, wish.region, wish.settings.decimation);
        let detect_start_ns = monotonic_ns();
        if let (Some(observer), Some(part)) = (&mut self.observer, &part) {
            let payload = frame.payload().as_ptr_range();
            observer(&FrameSeen { header: &header, view: &part.view, payload });
        }
        // A region that lies outside holds nothing.
        let mut phases = PhaseClock::new(monotonic_ns());
        let detections = part
            .as_ref()
            .map_or(&[][..], |part| detector.detect_observed(&part.view, |phase| phases.ends(phase)));
        let detect_end_ns = monotonic_ns();
        let origin = part.map_or([0.0; 2], |part| part.origin);
        self.summary.frames_searched += 1;
        self.summary.search_ns += detect_end_ns - detect_start_ns;
        self.summary.tags_found += detections.len() as u64;
        convert::choose(detections, self.max_tags, &mut self.chosen);
        let message = DetectionsHeader {
            message_number: self.summary.messages_sent,
            receive_ns,
            detect_start_ns,
            detect_end_ns,
            count: self.chosen.len() as u32,
            found: detections.len() as u32,
            flags: template.flags
                | if self.chosen.len() < detections.len() { header_flags::MORE_FOUND } else { 0 },
            skipped: u32::try_from(step.skipped).unwrap_or(u32::MAX),
            skipped_total: self.summary.frames_skipped,
            refused_total: self.summary.frames_refused,
            ..convert::header_of_frame(template, &header)
        };
        // The camera gets its chunk back before clients are woken.
        drop(frame);
        let tags = Tags { detections, chosen: &self.chosen, names, origin };
        match send(message, &tags, out, &mut self.watch) {
            Ok(sent) => {
                self.summary.messages_sent += 1;
                self.recorder.frame(&sent, &phases, monotonic_ns());
            }
            Err(reason) => self.trouble(reason),
        }
    }

    /// Is to be called before a frame is taken.
    pub(crate) fn receives(&mut self) {
        if let Some(watch) = &mut self.watch {
            watch(Moment::Receive);
        }
    }

    /// Tells the user something that happens rarely.
    pub(crate) fn tell(&mut self, report: &Report) {
        (self.report)(report);
    }

    /// Tells of a change, unless there are many.
    pub(crate) fn changed(&mut self, number: u64, what: String) {
        if self.changes.lets_through(Instant::now()) {
            self.tell(&Report::Changed { number, what });
        }
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

/// The tags of a message.
struct Tags<'a> {
    detections: &'a [Detection],
    /// Places of those that are sent.
    chosen: &'a [usize],
    names: &'a [FamilyName],
    /// Where the part that was searched begins in the frame.
    origin: [f64; 2],
}

/// Writes a message into shared memory, sends it and then wakes the clients. Gives back the header as it was sent.
fn send(
    mut header: DetectionsHeader,
    tags: &Tags,
    out: &DetectionsOut<Local>,
    watch: &mut Option<Watch>,
) -> Result<DetectionsHeader, String> {
    let Tags { detections, chosen, names, origin } = tags;
    let loan = out
        .lend(chosen.len())
        .map_err(|error| format!("no memory for a message of {} tags: {error}", chosen.len()))?;
    let mut loan = loan.write_from_fn(|place| convert::tag(&detections[chosen[place]], names, *origin));
    header.send_ns = monotonic_ns();
    *loan.user_header_mut() = header;
    loan.send().map_err(|error| format!("a message could not be sent ({error:?})"))?;
    if let Some(watch) = watch {
        watch(Moment::Sent);
    }
    out.notify().map_err(|error| format!("clients could not be woken: {error}"))?;
    Ok(header)
}
