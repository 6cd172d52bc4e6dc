//! The camera's work, from opening its source to its last frame.
//!
//! ```text
//! open the source ─▶ room in shared memory? ─▶ onto the bus ─▶ info: streaming
//!   ┌──────────────────────────────────────────────────────────────┐
//!   └▶ wait until due ─▶ loan ─▶ source fills it ─▶ header ─▶ send ─▶ notify
//! end of the source or stop ─▶ info: ended ─▶ off the bus
//! ```

use std::fmt;
use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::prelude::ipc;
use tagbus_message::bus::{Bus, BusError};
use tagbus_message::clock;
use tagbus_message::info::{CameraInfo, CameraState};
use tagbus_message::ports::InfoOut;
use tagbus_message::qos::{FRAMES, Reserved};
use tagbus_message::stop::Stop;
use tagbus_message::text;

use crate::config::CameraConfig;
use crate::format::FrameShape;
use crate::loan;
use crate::pace::Pacer;
use crate::publish::{Epoch, FramePublisher, Lost};
use crate::source::{self, Damage, FrameError, FrameSource, OpenError};
use crate::space::{Space, SpaceError};

/// How often subscribers that came late are handed the camera's information.
const GREETING_PERIOD: Duration = Duration::from_secs(1);

/// So many frames in a row that cannot be sent end the camera: no subscriber's death explains them any more.
const MAX_SEND_FAILURES: u32 = 100;

/// What a camera reports while it works.
#[derive(Debug)]
#[non_exhaustive]
pub enum CameraEvent {
    /// Frames are about to be published.
    Started {
        /// Format and size of the largest frame.
        shape: FrameShape,
        /// Memory that the frames topic has reserved.
        reserved: Reserved,
        /// Room in shared memory before that.
        space: Space,
    },
    /// Frames (or pictures of a folder) were passed over because they cannot be used.
    Skipped {
        /// How many since the last report.
        count: u64,
        /// Why the last one was passed over.
        reason: String,
    },
    /// No memory was free for a frame, which was given up; what dead processes held was taken back.
    NoLoan {
        /// How many dead processes there were.
        dead: u64,
    },
    /// A frame did not reach every subscriber; what dead processes held was taken back.
    NotSent {
        /// What iceoryx2 says.
        error: SendError,
        /// How many dead processes there were.
        dead: u64,
    },
}

impl fmt::Display for CameraEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Started { shape, reserved, space } => {
                write!(f, "publishing {shape}: {reserved}")?;
                let megabytes = space.available / 1_000_000;
                if space.is_tight() { write!(f, "; only {megabytes} MB are free") } else { Ok(()) }
            }
            Self::Skipped { count, reason } => write!(f, "skipped {count}: {reason}"),
            Self::NoLoan { dead } => {
                write!(f, "no memory was free for a frame ({dead} dead processes cleaned up)")
            }
            Self::NotSent { error, dead } => {
                write!(
                    f,
                    "a frame did not reach every subscriber: {error} ({dead} dead processes cleaned up)"
                )
            }
        }
    }
}

/// Why a camera came to its orderly end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// It was asked to stop.
    Stopped,
    /// The source has no further frames.
    SourceEnded,
}

/// What a camera did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Summary {
    /// Frames published.
    pub frames: u64,
    /// Frames passed over because they could not be used.
    pub damaged: u64,
    /// Frames given up because no memory was free.
    pub no_loan: u64,
    /// Why it ended.
    pub ending: Ending,
}

/// Why a camera cannot start or go on.
#[derive(Debug)]
#[non_exhaustive]
pub enum CameraError {
    /// The source cannot be opened.
    Open(OpenError),
    /// The source gives no further frames.
    Frame(FrameError),
    /// Shared memory is too full.
    Space(SpaceError),
    /// The bus refuses the camera: its name is taken, or domain or topic cannot be used.
    Bus(BusError),
    /// Many frames in a row could not be sent.
    Send(SendError),
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(error) => error.fmt(f),
            Self::Frame(error) => error.fmt(f),
            Self::Space(error) => error.fmt(f),
            Self::Bus(error) => error.fmt(f),
            Self::Send(error) => write!(f, "{MAX_SEND_FAILURES} frames in a row could not be sent: {error}"),
        }
    }
}

impl std::error::Error for CameraError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Open(error) => Some(error),
            Self::Frame(error) => Some(error),
            Self::Space(error) => Some(error),
            Self::Bus(error) => Some(error),
            Self::Send(error) => Some(error),
        }
    }
}

impl From<OpenError> for CameraError {
    fn from(error: OpenError) -> Self {
        Self::Open(error)
    }
}

impl From<FrameError> for CameraError {
    fn from(error: FrameError) -> Self {
        Self::Frame(error)
    }
}

impl From<SpaceError> for CameraError {
    fn from(error: SpaceError) -> Self {
        Self::Space(error)
    }
}

impl From<BusError> for CameraError {
    fn from(error: BusError) -> Self {
        Self::Bus(error)
    }
}

/// Publishes frames until the source ends or `stop` is triggered.
///
/// # Errors
/// See [`CameraError`]. Being stopped is no error.
pub fn run(config: CameraConfig, stop: Stop) -> Result<Summary, CameraError> {
    run_reporting(config, stop, &mut |_| {})
}

/// [`run`], with a report of its start and of whatever goes wrong on the way.
///
/// # Errors
/// See [`CameraError`]. Being stopped is no error.
pub fn run_reporting(
    config: CameraConfig,
    stop: Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    let mut damage = Damage::default();
    let source = source::open(&config.source, &config.options, &mut damage)?;
    if damage.count > 0 {
        report(CameraEvent::Skipped { count: damage.count, reason: damage.last_reason });
    }
    match Camera::start(&config, source, &stop, report) {
        Ok(camera) => camera.work(&stop),
        Err(CameraError::Bus(BusError::Stopped)) => {
            Ok(Summary { frames: 0, damaged: 0, no_loan: 0, ending: Ending::Stopped })
        }
        Err(error) => Err(error),
    }
}

/// A camera that is on the bus. Fields are dropped in this order: topics before the node that both hold.
struct Camera<'a> {
    publisher: FramePublisher,
    info_out: InfoOut<ipc::Service>,
    info: CameraInfo,
    source: Box<dyn FrameSource>,
    pacer: Pacer,
    damage: Damage,
    /// Frames given up since the last one that was sent.
    lost: Lost,
    summary: Summary,
    send_failures: u32,
    greeted: Instant,
    report: &'a mut dyn FnMut(CameraEvent),
}

impl<'a> Camera<'a> {
    fn start(
        config: &CameraConfig,
        source: Box<dyn FrameSource>,
        stop: &Stop,
        report: &'a mut dyn FnMut(CameraEvent),
    ) -> Result<Camera<'a>, CameraError> {
        let shape = source.largest();
        let payload_bytes = loan::payload_bytes(shape.bytes());
        let space = Space::check(&FRAMES, payload_bytes)?;
        let bus = Bus::<ipc::Service>::start(&config.domain, &format!("camera {}", config.camera), stop)?;
        let frames = bus.create_frames(&config.camera, &FRAMES, payload_bytes)?;
        let info_out = bus.create_info(&config.camera)?;
        report(CameraEvent::Started { shape, reserved: frames.reserved(), space });
        let now = Instant::now();
        let pacer = Pacer::new(config.options.pace, now);
        let info = describe(config, source.as_ref(), pacer.period());
        let epoch = Epoch { number: info.epoch, info_number: 1, frame_time: pacer.period() };
        Ok(Camera {
            publisher: FramePublisher::new(frames, epoch, shape),
            info_out,
            info,
            source,
            pacer,
            damage: Damage::default(),
            lost: Lost::default(),
            summary: Summary { frames: 0, damaged: 0, no_loan: 0, ending: Ending::Stopped },
            send_failures: 0,
            greeted: now,
            report,
        })
    }

    fn work(mut self, stop: &Stop) -> Result<Summary, CameraError> {
        self.announce(CameraState::Streaming);
        let ended = self.stream(stop);
        self.announce(CameraState::Ended);
        self.summary.ending = ended?;
        Ok(self.summary)
    }

    fn stream(&mut self, stop: &Stop) -> Result<Ending, CameraError> {
        while !self.pacer.wait(stop) {
            if self.greeted.elapsed() >= GREETING_PERIOD {
                self.info_out.greet_late_subscribers();
                self.greeted = Instant::now();
            }
            if !self.publish_next()? {
                return Ok(Ending::SourceEnded);
            }
        }
        Ok(Ending::Stopped)
    }

    /// One frame from the source onto the bus; `false` when the source has ended.
    fn publish_next(&mut self) -> Result<bool, CameraError> {
        let asked_ns = clock::monotonic_ns();
        let Ok(mut loan) = self.publisher.loan() else {
            self.give_up_frame();
            return Ok(true);
        };
        let filled = self.source.next(loan.picture(), &mut self.damage);
        self.report_damage();
        let Some(filled) = filled? else { return Ok(false) };
        match self.publisher.send(loan, filled, asked_ns, std::mem::take(&mut self.lost)) {
            Ok(()) => {
                self.summary.frames += 1;
                self.send_failures = 0;
            }
            Err(error) => self.count_send_failure(error)?,
        }
        Ok(true)
    }

    /// Cannot happen by the pool's arithmetic, unless processes died holding more than their share.
    fn give_up_frame(&mut self) {
        self.lost.no_loan += 1;
        self.summary.no_loan += 1;
        let dead = self.publisher.clean_up_dead();
        (self.report)(CameraEvent::NoLoan { dead });
    }

    fn report_damage(&mut self) {
        let seen = self.summary.damaged;
        let count = self.damage.count - seen;
        if count > 0 {
            self.summary.damaged = self.damage.count;
            self.lost.damaged += count;
            (self.report)(CameraEvent::Skipped { count, reason: self.damage.last_reason.clone() });
        }
    }

    fn count_send_failure(&mut self, error: SendError) -> Result<(), CameraError> {
        self.send_failures += 1;
        if self.send_failures == MAX_SEND_FAILURES {
            return Err(CameraError::Send(error));
        }
        let dead = self.publisher.clean_up_dead();
        (self.report)(CameraEvent::NotSent { error, dead });
        Ok(())
    }

    /// Publishes a state. A subscriber that cannot be told now gets it with the next greeting.
    fn announce(&mut self, state: CameraState) {
        self.info.number += 1;
        self.info.state = state.code();
        self.info.updated_ns = clock::monotonic_ns();
        self.info.wall_offset_ns = clock::wall_offset_ns();
        let _ = self.info_out.publish(&self.info);
    }
}

/// What the camera says about itself; number and state come with each announcement.
fn describe(config: &CameraConfig, source: &dyn FrameSource, frame_time: Duration) -> CameraInfo {
    let shape = source.largest();
    let wall_ns = clock::monotonic_ns() as i64 + clock::wall_offset_ns();
    let mut info = CameraInfo {
        epoch: wall_ns as u64,
        source_fourcc: source.stored_format().0,
        fourcc: shape.format().0,
        width: shape.width(),
        height: shape.height(),
        frame_time_ns: frame_time.as_nanos() as u64,
        ..CameraInfo::default()
    };
    text::write_cut(&mut info.source, &config.source.to_string());
    text::write_cut(&mut info.model, source.description());
    info
}
