//! The service from start to end: one thread, one wait set.

use std::time::{Duration, Instant};

use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::domain::Domain;
use tagbus_message::ports::{DetectionsOut, FramesIn};
use tagbus_message::qos;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{Waiter, Wake, wait_set};

use crate::config::ServiceConfig;
use crate::report::{Report, ServiceError, Summary};
use crate::search::{Local, Search};

/// A silence that a user is told of; shorter ones are a hiccup.
const WORTH_TELLING: Duration = Duration::from_secs(1);

/// Where on the bus the service is.
struct Place {
    domain: Domain,
    camera: String,
    detector: String,
    max_tags: usize,
}

/// Why receiving ended.
enum End {
    /// The service was asked to stop.
    Stopped,
    /// The frames topic was removed by force: it has to be opened again.
    Replaced,
}

/// Searches the newest frame again and again until `stop` is triggered. Waits for a camera that is not there yet, and
/// goes on when the camera is started again.
///
/// Errors are what waiting does not mend: another detector of this name, a domain of another user, bad settings.
pub fn run(config: ServiceConfig, stop: Stop) -> Result<Summary, ServiceError> {
    let place = Place {
        domain: config.domain.clone(),
        camera: config.camera.clone(),
        detector: config.detector.clone(),
        max_tags: config.max_tags,
    };
    qos::check_max_tags(place.max_tags).map_err(BusError::from)?;
    let mut search = Search::new(config)?;
    match serve(&mut search, &place, &stop) {
        Ok(()) | Err(ServiceError::Bus(BusError::Stopped)) => Ok(search.summary),
        Err(error) => Err(error),
    }
}

/// The detections topic first, so that clients find it while the camera is waited for.
fn serve(search: &mut Search, place: &Place, stop: &Stop) -> Result<(), ServiceError> {
    let role = format!("detector {} of {}", place.detector, place.camera);
    let bus = Bus::<Local>::start(&place.domain, &role, stop)?;
    let out = bus.create_detections(&place.camera, &place.detector, place.max_tags)?;
    let touched = out.touched_bytes().unwrap_or(0);
    search.tell(&Report::Ready { reserved: out.reserved(), touched });
    loop {
        let frames = bus.open_frames(&place.camera, qos::DETECTOR_FRAME_BUFFER, Patience::Endless)?;
        search.tell(&Report::Connected);
        if let End::Stopped = receive(search, &frames, &out, stop)? {
            return Ok(());
        }
    }
}

fn receive(
    search: &mut Search,
    frames: &FramesIn<Local>,
    out: &DetectionsOut<Local>,
    stop: &Stop,
) -> Result<End, ServiceError> {
    let set = wait_set::<Local>()?;
    let waiter = Waiter::new(&set, stop, Some(frames.listener()))?;
    let mut last_frame = Instant::now();
    let mut told_silence = false;
    // A frame that was sent before this subscriber came causes no event any more.
    take(search, frames, out);
    loop {
        match waiter.wait(search.pace.deadline())? {
            Wake::Stop => return Ok(End::Stopped),
            Wake::Event | Wake::Other => {
                if take(search, frames, out) {
                    last_frame = Instant::now();
                    if std::mem::take(&mut told_silence) {
                        search.tell(&Report::Back);
                    }
                }
            }
            Wake::TimedOut => {
                let dead = missed_deadline(search, frames);
                let waited = last_frame.elapsed();
                if !told_silence && waited >= WORTH_TELLING {
                    told_silence = true;
                    search.tell(&Report::Silent { waited, dead });
                }
                if !frames.is_current() {
                    return Ok(End::Replaced);
                }
            }
        }
    }
}

/// Searches the newest frame if there is one.
fn take(search: &mut Search, frames: &FramesIn<Local>, out: &DetectionsOut<Local>) -> bool {
    match frames.newest() {
        Ok(Some(frame)) => {
            search.frame(frame, out);
            true
        }
        Ok(None) => false,
        Err(error) => {
            search.trouble(format!("a frame could not be received ({error:?})"));
            false
        }
    }
}

/// Nobody looks for the dead by himself: a camera that died gives its place back here.
fn missed_deadline(search: &mut Search, frames: &FramesIn<Local>) -> u64 {
    let dead = frames.bus().clean_up_dead();
    search.pace.missed();
    search.summary.deadlines_missed += 1;
    search.summary.dead_cleaned += dead;
    dead
}
