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
use tagbus_message::bus::BusError;
use tagbus_message::clock;
use tagbus_message::frame::Fourcc;
use tagbus_message::info::CameraState;
use tagbus_message::qos::{FRAMES, Reserved};
use tagbus_message::room::{MORE_ROOM, SHARED_MEMORY};
use tagbus_message::stop::Stop;

use crate::config::{CameraConfig, Source};
use crate::desk::NoControls;
use crate::device::{self, Transfer};
use crate::format::FrameShape;
use crate::libcamera;
use crate::outlet::{Offer, Outlet};
use crate::pace::Pacer;
use crate::publish::Moment;
use crate::rpicam;
use crate::source::{self, Damage, FrameError, FrameSource, OpenError};
use crate::space::{Space, SpaceError};

/// So many frames in a row that cannot be sent end the camera: no subscriber's death explains them any more.
pub(crate) const MAX_SEND_FAILURES: u32 = 100;

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
    /// A device begins to deliver.
    Opened {
        /// Its node, and what the driver says it is.
        device: String,
        /// The format in which it holds its frames.
        format: Fourcc,
        /// Nominal time from frame to frame; zero when it does not say.
        frame_time: Duration,
        /// What was asked for and is not so.
        changed: Vec<String>,
        /// Controls that were set, with the values that the device says they have.
        controls: Vec<String>,
        /// How its frames get into shared memory.
        transfer: Transfer,
    },
    /// A device delivers no more; it is looked for until it does again.
    Interrupted {
        /// Whether it is there (waiting) or not (lost).
        state: CameraState,
        /// What happened, or why it cannot be opened again.
        reason: String,
    },
    /// A driver's stamp cannot be right; the time at which the process got the frame stands in its place.
    StampRefused {
        /// What is wrong with it.
        reason: String,
        /// How many there were since the device was opened.
        total: u64,
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
    /// Shared memory has no room for a frame, which was given up, or left to the driver's other memory.
    MemoryFull {
        /// What a frame takes.
        bytes: usize,
        /// How often that was so.
        total: u64,
    },
    /// A driver had to pin memory anew under a buffer number that it knew for other memory: slower, and right all the same.
    Repinned {
        /// How often since the device was opened.
        total: u64,
        /// Buffer numbers that the driver grants.
        numbers: usize,
    },
    /// The topic's files in shared memory were removed by force; the camera begins anew.
    Removed,
    /// What is counted cannot be published: nobody can watch this camera.
    NoStats(BusError),
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
            Self::Opened { device, format, frame_time, changed, controls, transfer } => {
                write!(f, "{device}: {format}")?;
                if !frame_time.is_zero() {
                    write!(f, " at {:.2} frames/s", 1.0 / frame_time.as_secs_f64())?;
                }
                write!(f, "; {transfer}")?;
                if !changed.is_empty() {
                    write!(f, "; the device gives {}", changed.join(", "))?;
                }
                if controls.is_empty() { Ok(()) } else { write!(f, "; controls: {}", controls.join(", ")) }
            }
            Self::Interrupted { state, reason } => write!(f, "{}: {reason}", state.name()),
            Self::StampRefused { reason, total } => {
                write!(f, "a stamp of the driver is not used: {reason} ({total} so far)")
            }
            Self::Skipped { count, reason } => write!(f, "skipped {count}: {reason}"),
            Self::NoLoan { dead } => {
                write!(f, "no memory was free for a frame ({dead} dead processes cleaned up)")
            }
            Self::MemoryFull { bytes, total } => write!(
                f,
                "{SHARED_MEMORY} is full: no room for a frame of {bytes} bytes (so far: {total}); {MORE_ROOM}"
            ),
            Self::Repinned { total, numbers } => write!(
                f,
                "the driver pinned memory anew {total} times so far: it grants {numbers} buffer numbers for {} pieces of memory",
                FRAMES.chunks()
            ),
            Self::Removed => write!(
                f,
                "its files in {SHARED_MEMORY} were removed (logind does that at logout, see RemoveIPC=): beginning anew"
            ),
            Self::NoStats(error) => write!(f, "nobody can watch this camera: {error}"),
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
    /// How often a driver had to pin memory anew under a buffer number that it knew for other memory.
    pub repins: u64,
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
    /// The topic's files in shared memory were removed by force. [`run`] begins anew then, so that nobody sees this.
    Removed,
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(error) => error.fmt(f),
            Self::Frame(error) => error.fmt(f),
            Self::Space(error) => error.fmt(f),
            Self::Bus(error) => error.fmt(f),
            Self::Removed => write!(f, "its files in {SHARED_MEMORY} were removed"),
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
            Self::Removed => None,
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
    loop {
        match run_once(&config, &stop, report) {
            Err(CameraError::Removed) => report(CameraEvent::Removed),
            Err(CameraError::Bus(BusError::Stopped)) => {
                return Ok(Summary { frames: 0, damaged: 0, no_loan: 0, repins: 0, ending: Ending::Stopped });
            }
            ended => return ended,
        }
    }
}

/// From opening the source to its end, or until the topic is gone.
fn run_once(
    config: &CameraConfig,
    stop: &Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    match &config.source {
        Source::V4l(path) => device::publish(config, path, stop, report),
        Source::Libcamera(id) => libcamera::publish(config, id.as_deref(), stop, report),
        Source::Rpicam(program) => rpicam::publish(config, program.as_deref(), stop, report),
        _ => publish(config, stop, report),
    }
}

/// Publishes frames of a source that makes them when it is asked.
fn publish(
    config: &CameraConfig,
    stop: &Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    let mut damage = Damage::default();
    let source = source::open(&config.source, &config.options, &mut damage)?;
    if damage.count > 0 {
        report(CameraEvent::Skipped { count: damage.count, reason: damage.last_reason });
    }
    let pacer = Pacer::new(config.options.pace, Instant::now());
    let offer = Offer {
        largest: source.largest(),
        stored_format: source.stored_format(),
        model: source.description(),
        frame_time: pacer.period(),
    };
    let outlet = Outlet::open(config, &offer, stop, report)?;
    let delay = config.options.delay;
    Camera { outlet, source, pacer, damage: Damage::default(), delay }.work(stop)
}

/// A camera whose frames are made when they are due.
struct Camera<'a> {
    outlet: Outlet<'a>,
    source: Box<dyn FrameSource>,
    pacer: Pacer,
    damage: Damage,
    delay: Duration,
}

impl Camera<'_> {
    fn work(mut self, stop: &Stop) -> Result<Summary, CameraError> {
        self.outlet.announce(CameraState::Streaming);
        let ended = self.stream(stop);
        self.outlet.announce(CameraState::Ended);
        self.outlet.summary.ending = ended?;
        Ok(self.outlet.summary)
    }

    fn stream(&mut self, stop: &Stop) -> Result<Ending, CameraError> {
        let mut controls =
            NoControls("frames of this source come without a device, so there are no controls");
        while !self.pacer.wait(stop, || self.outlet.answer(&mut controls)) {
            self.outlet.greet();
            self.outlet.answer(&mut controls);
            if !self.publish_next()? {
                return Ok(Ending::SourceEnded);
            }
        }
        Ok(Ending::Stopped)
    }

    /// One frame from the source onto the bus; `false` when the source has ended.
    fn publish_next(&mut self) -> Result<bool, CameraError> {
        let asked_ns = clock::monotonic_ns();
        let Some(mut loan) = self.outlet.loan() else { return Ok(true) };
        let filled = self.source.next(loan.picture(), &mut self.damage);
        self.outlet.note_damage(&self.damage);
        let Some(filled) = filled? else { return Ok(false) };
        if !self.delay.is_zero() {
            std::thread::sleep(self.delay);
        }
        // These sources have no better moment than that at which they were asked.
        self.outlet.send(loan, filled, Moment::dequeued(asked_ns))?;
        Ok(true)
    }
}
