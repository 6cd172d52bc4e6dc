//! A camera's place on the bus: where its frames and its information go out, and where what was lost is counted.

use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use tagbus_message::Local;
use tagbus_message::bus::{Bus, BusError};
use tagbus_message::clock;
use tagbus_message::frame::Fourcc;
use tagbus_message::info::{CameraInfo, CameraState};
use tagbus_message::ports::{InfoOut, LendError};
use tagbus_message::qos::FRAMES;
use tagbus_message::stats::CameraStats;
use tagbus_message::stats_ports::StatsOut;
use tagbus_message::stop::Stop;
use tagbus_message::text;

use crate::config::CameraConfig;
use crate::desk::{Controls, Desk};
use crate::format::FrameShape;
use crate::loan::{self, Loan};
use crate::publish::{Epoch, FramePublisher, Lost, Moment};
use crate::run::{CameraError, CameraEvent, Ending, MAX_SEND_FAILURES, Summary};
use crate::source::{Damage, Filled};
use crate::space::Space;

/// How often subscribers that came late are handed the camera's information.
pub(crate) const GREETING_PERIOD: Duration = Duration::from_secs(1);

/// What has to be known of a source before it gets a place on the bus.
pub(crate) struct Offer<'a> {
    /// Format and size of the largest frame.
    pub(crate) largest: FrameShape,
    /// The format in which the source holds its frames.
    pub(crate) stored_format: Fourcc,
    /// What the source is.
    pub(crate) model: &'a str,
    /// Nominal time from frame to frame; zero when there is none.
    pub(crate) frame_time: Duration,
}

/// A camera that is on the bus. Fields are dropped in this order: topics before the node that both hold.
pub(crate) struct Outlet<'a> {
    publisher: FramePublisher,
    info_out: InfoOut<Local>,
    desk: Desk,
    tape: StatsOut<Local, CameraStats>,
    pub(crate) info: CameraInfo,
    /// Frames given up since the last one that was sent.
    pub(crate) lost: Lost,
    pub(crate) summary: Summary,
    send_failures: u32,
    /// How often shared memory was full.
    refusals: u64,
    greeted: Instant,
    /// When was last looked whether the topic is still there.
    looked: Instant,
    report: &'a mut dyn FnMut(CameraEvent),
}

impl<'a> Outlet<'a> {
    /// Makes the camera's topics, when there is room for them.
    pub(crate) fn open(
        config: &CameraConfig,
        offer: &Offer,
        stop: &Stop,
        report: &'a mut dyn FnMut(CameraEvent),
    ) -> Result<Outlet<'a>, CameraError> {
        let shape = offer.largest;
        let payload_bytes = loan::payload_bytes(shape.bytes());
        let space = Space::check(&FRAMES, payload_bytes)?;
        let bus = Bus::<Local>::start(&config.domain, &format!("camera {}", config.camera), stop)?;
        let frames = bus.create_frames(&config.camera, &FRAMES, payload_bytes)?;
        let info_out = bus.create_info(&config.camera)?;
        let desk = Desk::new(bus.create_camera_control(&config.camera)?);
        let tape = bus.camera_stats(&config.camera).map_err(BusError::from)?;
        report(CameraEvent::Started { shape, reserved: frames.reserved(), space });
        let info = describe(config, offer);
        let epoch = Epoch { number: info.epoch, info_number: 1, frame_time: offer.frame_time };
        Ok(Outlet {
            publisher: FramePublisher::new(frames, epoch, shape),
            info_out,
            desk,
            tape,
            info,
            lost: Lost::default(),
            summary: Summary { frames: 0, damaged: 0, no_loan: 0, repins: 0, ending: Ending::Stopped },
            send_failures: 0,
            refusals: 0,
            greeted: Instant::now(),
            looked: Instant::now(),
            report,
        })
    }

    /// Memory for a frame. There is none when shared memory is full, or when processes died that held more than their share, whose
    /// remains are then taken away; the frame is given up.
    pub(crate) fn loan(&mut self) -> Option<Loan> {
        let missing = match self.publisher.loan() {
            Ok(loan) => return Some(loan),
            Err(missing) => missing,
        };
        self.lost.no_loan += 1;
        self.summary.no_loan += 1;
        let dead = self.publisher.clean_up_dead();
        match missing {
            LendError::Full { bytes } => self.tell_full(bytes),
            _ => self.tell(CameraEvent::NoLoan { dead }),
        }
        None
    }

    /// Memory for a driver's queue. That there is none at the moment is no loss yet: the driver has other memory.
    pub(crate) fn lendable(&mut self) -> Option<Loan> {
        if let Ok(loan) = self.publisher.loan() {
            return Some(loan);
        }
        self.publisher.clean_up_dead();
        match self.publisher.loan() {
            Ok(loan) => return Some(loan),
            Err(LendError::Full { bytes }) => self.tell_full(bytes),
            Err(_) => {}
        }
        None
    }

    /// Told of now and then: it may last.
    fn tell_full(&mut self, bytes: usize) {
        self.refusals += 1;
        if self.refusals.is_power_of_two() {
            self.tell(CameraEvent::MemoryFull { bytes, total: self.refusals });
        }
    }

    /// Format and size that memory was made for.
    #[cfg(any(feature = "v4l", feature = "libcamera"))]
    pub(crate) fn largest(&self) -> FrameShape {
        self.publisher.largest()
    }

    /// Notes the exposure time of the next frame, nanoseconds; 0 when it is not known.
    #[cfg(feature = "libcamera")]
    pub(crate) fn note_exposure(&mut self, exposure_ns: u64) {
        self.publisher.note_exposure(exposure_ns);
    }

    /// Publishes a frame. That it did not reach everybody is no error, unless it happens many times in a row.
    pub(crate) fn send(&mut self, loan: Loan, filled: Filled, moment: Moment) -> Result<(), CameraError> {
        if self.looked.elapsed() >= GREETING_PERIOD {
            self.looked = Instant::now();
            if !self.publisher.is_in_place() {
                return Err(CameraError::Removed);
            }
        }
        match self.publisher.send(loan, filled, moment, std::mem::take(&mut self.lost)) {
            Ok(()) => {
                self.summary.frames += 1;
                self.send_failures = 0;
                Ok(())
            }
            Err(error) => self.count_send_failure(error),
        }
    }

    fn count_send_failure(&mut self, error: SendError) -> Result<(), CameraError> {
        self.send_failures += 1;
        if self.send_failures == MAX_SEND_FAILURES {
            return Err(CameraError::Send(error));
        }
        let dead = self.publisher.clean_up_dead();
        self.tell(CameraEvent::NotSent { error, dead });
        Ok(())
    }

    /// Takes note of frames that were damaged since the last call.
    pub(crate) fn note_damage(&mut self, damage: &Damage) {
        let count = damage.count - self.summary.damaged;
        if count > 0 {
            self.summary.damaged = damage.count;
            self.lost.damaged += count;
            self.tell(CameraEvent::Skipped { count, reason: damage.last_reason.clone() });
        }
    }

    /// Counts a stamp of the driver that cannot be right.
    #[cfg(any(feature = "v4l", feature = "libcamera"))]
    pub(crate) fn count_refused_stamp(&mut self) {
        self.publisher.count_refused_stamp();
    }

    /// Hands the camera's information to subscribers that came late, once a second.
    pub(crate) fn greet(&mut self) {
        if self.greeted.elapsed() >= GREETING_PERIOD {
            self.info_out.greet_late_subscribers();
            self.greeted = Instant::now();
        }
    }

    /// Publishes a state. A subscriber that cannot be told now gets it with the next greeting.
    pub(crate) fn announce(&mut self, state: CameraState) {
        self.info.state = state.code();
        announce(&mut self.info, &mut self.publisher, &self.info_out);
    }

    /// Answers those who ask, sets controls for them, and publishes what was counted when that is due. To be called between frames;
    /// when there is nothing to do, hardly any time passes.
    pub(crate) fn answer(&mut self, controls: &mut dyn Controls) {
        if self.tape.is_due() {
            self.publish_stats();
        }
        let Self { publisher, info_out, desk, info, summary, .. } = self;
        desk.look(summary, info, controls, &mut |info| announce(info, publisher, info_out));
    }

    fn publish_stats(&mut self) {
        if let Err(error) = self.tape.publish(self.publisher.stats(self.info.state)) {
            self.tell(CameraEvent::NoStats(error));
        }
    }

    /// Tells the user.
    pub(crate) fn tell(&mut self, event: CameraEvent) {
        (self.report)(event);
    }
}

/// Publishes the information with the next number, which frames name from here on.
fn announce(info: &mut CameraInfo, publisher: &mut FramePublisher, info_out: &InfoOut<Local>) {
    info.number += 1;
    info.updated_ns = clock::monotonic_ns();
    info.wall_offset_ns = clock::wall_offset_ns();
    publisher.set_info(info);
    let _ = info_out.publish(info);
}

/// What the camera says about itself; number and state come with each announcement.
fn describe(config: &CameraConfig, offer: &Offer) -> CameraInfo {
    let shape = offer.largest;
    let wall_ns = clock::monotonic_ns() as i64 + clock::wall_offset_ns();
    let mut info = CameraInfo {
        epoch: wall_ns as u64,
        source_fourcc: offer.stored_format.0,
        fourcc: shape.format().0,
        width: shape.width(),
        height: shape.height(),
        frame_time_ns: offer.frame_time.as_nanos() as u64,
        ..CameraInfo::default()
    };
    text::write_cut(&mut info.source, &config.source.to_string());
    text::write_cut(&mut info.model, offer.model);
    info
}
