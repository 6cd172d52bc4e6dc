//! A camera of libcamera from its opening to its end: waited for when it goes, and opened again.

use std::io;
use std::time::{Duration, Instant};

use tagbus_message::info::CameraState;
use tagbus_message::stop::Stop;

use super::library::Library;
use super::session::{Frame, Session, Taken};
use crate::config::CameraConfig;
use crate::control::{ControlInfo, ControlSettings};
use crate::desk::{Changed, Controls, NoControls};
use crate::device::Transfer;
use crate::outlet::{Offer, Outlet};
use crate::run::{CameraError, CameraEvent, Ending, Summary};
use crate::source::{Damage, Filled, OpenError};
use crate::stamps::Stamps;

/// How long a frame is waited for before it is looked whether there is something else to do.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A camera that brings no frame for so long has stopped delivering: sensors take a while to start.
const SILENT: Duration = Duration::from_secs(5);

/// How often a camera that went is looked for.
const LOOKING_PERIOD: Duration = Duration::from_millis(500);

/// Publishes frames of the camera of that id, or of the first one, until `stop` is triggered.
pub(crate) fn publish(
    config: &CameraConfig,
    id: Option<&str>,
    stop: &Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    let library = Library::start().map_err(OpenError::Device)?;
    let controls = config.options.controls.clone();
    let mut session = Session::open(&library, id, &config.options, &controls).map_err(OpenError::Device)?;
    let offer = Offer {
        largest: session.agreed.shape,
        stored_format: session.agreed.format,
        model: &session.model.clone(),
        frame_time: session.frame_time,
    };
    let outlet = Outlet::open(config, &offer, stop, report)?;
    session.start().map_err(|error| {
        OpenError::Device(format!("libcamera:{}: it cannot be started: {error}", session.id))
    })?;
    let id = session.id.clone();
    LibraryCamera { config, library: &library, id, controls, outlet, damage: Damage::default() }
        .work(session, stop)
}

/// Why a session ended.
enum Over {
    Stopped,
    Broke(String),
}

struct LibraryCamera<'a> {
    config: &'a CameraConfig,
    library: &'a Library,
    id: String,
    /// Set whenever the camera is opened: those of the configuration, and those that were set since.
    controls: ControlSettings,
    outlet: Outlet<'a>,
    damage: Damage,
}

impl LibraryCamera<'_> {
    fn work(mut self, first: Session, stop: &Stop) -> Result<Summary, CameraError> {
        let ended = self.stream_on(first, stop);
        self.outlet.announce(CameraState::Ended);
        self.outlet.summary.ending = ended?;
        Ok(self.outlet.summary)
    }

    fn stream_on(&mut self, first: Session, stop: &Stop) -> Result<Ending, CameraError> {
        let mut session = first;
        loop {
            self.tell_begun(&session);
            let reason = match self.stream(&mut session, stop)? {
                Over::Stopped => return Ok(Ending::Stopped),
                Over::Broke(reason) => reason,
            };
            // Closed before it is looked for.
            drop(session);
            match self.wait_for_it(reason, stop) {
                Some(again) => session = again,
                None => return Ok(Ending::Stopped),
            }
        }
    }

    fn tell_begun(&mut self, session: &Session) {
        self.outlet.tell(CameraEvent::Opened {
            device: format!(
                "libcamera:{} ({}, libcamera {})",
                session.id,
                session.model,
                self.library.version()
            ),
            format: session.agreed.format,
            frame_time: session.frame_time,
            changed: session.agreed.changed.clone(),
            controls: session.controls.clone(),
            transfer: Transfer::Shared { buffers: session.buffers() },
        });
        self.outlet.announce(CameraState::Streaming);
    }

    fn stream(&mut self, session: &mut Session, stop: &Stop) -> Result<Over, CameraError> {
        let mut stamps = Stamps::new(session.frame_time);
        let mut last_frame = Instant::now();
        loop {
            match session.take(LOOK_EVERY) {
                Taken::Nothing => {}
                Taken::Gone => return Ok(Over::Broke("the camera was disconnected".to_owned())),
                Taken::Frame(frame) => {
                    last_frame = Instant::now();
                    if let Err(error) = self.publish(*frame, session, &mut stamps)? {
                        return Ok(Over::Broke(format!("the camera takes no more requests: {error}")));
                    }
                }
            }
            if stop.is_triggered() {
                return Ok(Over::Stopped);
            }
            self.outlet.greet();
            self.outlet.answer(&mut OfSession { session, kept: &mut self.controls });
            if last_frame.elapsed() >= SILENT {
                return Ok(Over::Broke(format!("no frame for {:.1} s", last_frame.elapsed().as_secs_f64())));
            }
        }
    }

    /// Sends one frame. The outer error is the camera's, the inner one the library's.
    fn publish(
        &mut self,
        frame: Frame,
        session: &mut Session,
        stamps: &mut Stamps,
    ) -> Result<io::Result<()>, CameraError> {
        let moment = stamps.take_note(&frame.stamp, &mut self.outlet);
        let exposure_ns = frame.exposure_ns;
        let loan = match frame.damage {
            Some(reason) => {
                self.damage.note(format_args!("{reason}"));
                None
            }
            None => self.outlet.loan(),
        };
        let copied = loan.and_then(|mut loan| match session.copy(&frame, loan.picture()) {
            Ok(()) => Some(loan),
            Err(error) => {
                self.damage.note(format_args!("{error}"));
                None
            }
        });
        // The camera has its memory back before anybody is woken.
        let given_back = session.give_back(frame);
        self.outlet.note_damage(&self.damage);
        if let Some(loan) = copied {
            self.outlet.note_exposure(exposure_ns);
            self.outlet.send(loan, Filled { shape: session.agreed.shape, copies: 1 }, moment)?;
        }
        Ok(given_back)
    }

    /// Looks for the camera until it streams again; `None` when a stop is asked for.
    fn wait_for_it(&mut self, why: String, stop: &Stop) -> Option<Session> {
        let mut reason = why;
        let mut told = None;
        loop {
            let state = if self.library.find(Some(&self.id)).is_ok() {
                CameraState::Waiting
            } else {
                CameraState::Lost
            };
            if told.as_ref() != Some(&(state, reason.clone())) {
                told = Some((state, reason.clone()));
                self.outlet.announce(state);
                self.outlet.tell(CameraEvent::Interrupted { state, reason: reason.clone() });
            }
            if stop.wait(LOOKING_PERIOD) {
                return None;
            }
            self.outlet.greet();
            self.outlet.answer(&mut NoControls("the camera is not there at present"));
            match self.open_again() {
                Ok(session) => {
                    self.outlet.lost.in_driver += 1;
                    return Some(session);
                }
                Err(error) => reason = error,
            }
        }
    }

    fn open_again(&mut self) -> Result<Session, String> {
        let mut session = Session::open(self.library, Some(&self.id), &self.config.options, &self.controls)?;
        let (seen, expected) = (session.agreed.shape, self.outlet.largest());
        if seen.bytes() > expected.bytes() {
            return Err(format!(
                "it came back with frames of {seen}, and memory was made for {expected}: start the camera anew"
            ));
        }
        session.start().map_err(|error| format!("it cannot be started: {error}"))?;
        Ok(session)
    }
}

/// The controls of a camera that streams, as others may set them.
struct OfSession<'a> {
    session: &'a mut Session,
    kept: &'a mut ControlSettings,
}

impl Controls for OfSession<'_> {
    fn list(&self) -> Vec<ControlInfo> {
        self.session.list_controls()
    }

    fn set(&mut self, settings: &ControlSettings) -> Result<Changed, String> {
        let text = self.session.set(settings)?;
        self.kept.0.retain(|kept| settings.0.iter().all(|setting| setting.name != kept.name));
        self.kept.0.extend(settings.0.iter().cloned());
        // Each frame's own exposure stands in its header.
        Ok(Changed { text, exposure_ns: 0, is_automatic: false })
    }
}
