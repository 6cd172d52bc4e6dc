//! The service from start to end: one thread, one wait set.

use std::time::{Duration, Instant};

use tagbus_message::Local;
use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::control::DetectorState;
use tagbus_message::domain::Domain;
use tagbus_message::ports::{DetectionsOut, FramesIn};
use tagbus_message::qos;
use tagbus_message::stats::STATS_PERIOD;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitError, WaitSet, Waiter, Wake};

use crate::config::ServiceConfig;
use crate::desk::Desk;
use crate::recorder::Tape;
use crate::report::{Report, ServiceError, Summary};
use crate::search::Search;

/// A silence that a user is told of; shorter ones are a hiccup.
const WORTH_TELLING: Duration = Duration::from_secs(1);

/// How often is looked whether those who come still find the detections topic.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// A connection from which nothing has come for so long is made anew. That costs milliseconds, and one that was never completed, which
/// was seen once on a starved machine, would stay silent for ever.
const OPEN_AGAIN_AFTER: Duration = Duration::from_secs(3);

/// Pause between two looks for a camera that is not there: shorter at first than later.
const SHORTEST_PAUSE: Duration = Duration::from_millis(10);
const LONGEST_PAUSE: Duration = Duration::from_millis(100);

/// Where on the bus the service is.
struct Place {
    domain: Domain,
    camera: String,
    detector: String,
    max_tags: usize,
}

/// What is done between frames.
struct Besides<'a> {
    desk: Desk<'a>,
    tape: Tape<'a>,
}

impl Besides<'_> {
    /// How long a frame may be waited for before there is something to do.
    fn patience(&self, left: Duration) -> Duration {
        self.desk.patience(left).min(STATS_PERIOD)
    }

    fn look(&mut self, waiter: &Waiter<Local>, search: &mut Search) -> Result<(), WaitError> {
        self.desk.look(waiter, search)?;
        self.tape.look(search);
        Ok(())
    }
}

/// Why receiving ended.
enum End {
    /// The service was asked to stop.
    Stopped,
    /// The frames topic was removed by force, or nothing has come from it for long: it has to be opened again.
    Replaced,
    /// The detections topic was: everything has to be made again.
    Removed,
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
    loop {
        match serve(&mut search, &place, &stop) {
            Ok(End::Removed) => search.tell(&Report::Removed),
            Ok(End::Stopped | End::Replaced) | Err(ServiceError::Bus(BusError::Stopped)) => {
                return Ok(search.summary);
            }
            Err(error) => return Err(error),
        }
    }
}

/// The detections topic first, so that clients find it while the camera is waited for.
fn serve(search: &mut Search, place: &Place, stop: &Stop) -> Result<End, ServiceError> {
    let role = format!("detector {} of {}", place.detector, place.camera);
    let bus = Bus::<Local>::start(&place.domain, &role, stop)?;
    let out = bus.create_detections(&place.camera, &place.detector, place.max_tags)?;
    let requests = bus.create_detector_control(&place.camera, &place.detector)?;
    let tape = Tape::new(&bus, &place.camera, &place.detector, &out).map_err(BusError::from)?;
    let touched = out.touched_bytes().unwrap_or(0);
    search.tell(&Report::Ready { reserved: out.reserved(), touched });
    let set = WaitSet::new()?;
    let mut besides = Besides { desk: Desk::new(&requests, search), tape };
    let mut silence = Silence::new();
    loop {
        search.state = DetectorState::WaitingForCamera;
        let waiter = Waiter::new(&set, stop, None)?.with_requests(requests.listener())?;
        let Some(frames) = wait_for_camera(search, &bus, place, &waiter, &mut besides)? else {
            return Ok(End::Stopped);
        };
        drop(waiter);
        if !silence.is_told {
            search.tell(&Report::Connected);
        }
        search.state = DetectorState::Detecting;
        let waiter = Waiter::new(&set, stop, Some(frames.bell()))?.with_requests(requests.listener())?;
        match receive(search, &frames, &out, &waiter, &mut besides, &mut silence)? {
            End::Replaced if out.is_in_place() => {}
            End::Replaced => return Ok(End::Removed),
            end => return Ok(end),
        }
    }
}

/// Looks for the frames topic until it is there, and answers requests meanwhile; `None` when a stop was asked for.
fn wait_for_camera(
    search: &mut Search,
    bus: &Bus<Local>,
    place: &Place,
    waiter: &Waiter<Local>,
    besides: &mut Besides,
) -> Result<Option<FramesIn<Local>>, ServiceError> {
    let mut pause = SHORTEST_PAUSE;
    loop {
        match bus.open_frames(&place.camera, qos::DETECTOR_FRAME_BUFFER, Patience::IfThere) {
            Ok(frames) => return Ok(Some(frames)),
            Err(BusError::Absent { .. }) => {}
            // It need not stay so, and those who are served already are served on.
            Err(error @ BusError::NoRoom { .. }) => search.trouble(error.to_string()),
            Err(error) => return Err(error.into()),
        }
        let looked = Instant::now();
        while looked.elapsed() < pause {
            if waiter.wait(besides.patience(pause.saturating_sub(looked.elapsed())))? == Wake::Stop {
                return Ok(None);
            }
            besides.look(waiter, search)?;
        }
        pause = (pause * 2).min(LONGEST_PAUSE);
    }
}

fn receive(
    search: &mut Search,
    frames: &FramesIn<Local>,
    out: &DetectionsOut<Local>,
    waiter: &Waiter<Local>,
    besides: &mut Besides,
    silence: &mut Silence,
) -> Result<End, ServiceError> {
    let opened = Instant::now();
    let mut looked = Instant::now();
    // A frame that was sent before this subscriber came causes no event any more.
    take(search, frames, out);
    loop {
        let left = search.pace.deadline().saturating_sub(silence.looked.elapsed());
        let wake = waiter.wait(besides.patience(left))?;
        match wake {
            Wake::Stop => return Ok(End::Stopped),
            // A frame whose event was lost is found when the wait times out.
            Wake::Event | Wake::Other | Wake::TimedOut if take(search, frames, out) => silence.ends(search),
            Wake::Event | Wake::Other | Wake::TimedOut => {}
        }
        besides.look(waiter, search)?;
        if looked.elapsed() >= LOOK_EVERY {
            looked = Instant::now();
            if !out.is_in_place() {
                return Ok(End::Removed);
            }
        }
        if silence.looked.elapsed() >= search.pace.deadline() {
            silence.goes_on(search, frames);
            let is_stuck = silence.last_frame.elapsed().min(opened.elapsed()) >= OPEN_AGAIN_AFTER;
            if is_stuck || !frames.is_current() {
                return Ok(End::Replaced);
            }
        }
    }
}

/// The time without frames.
struct Silence {
    last_frame: Instant,
    /// When the last frame came, or the dead were last looked for.
    looked: Instant,
    is_told: bool,
}

impl Silence {
    fn new() -> Self {
        Self { last_frame: Instant::now(), looked: Instant::now(), is_told: false }
    }

    fn ends(&mut self, search: &mut Search) {
        (self.last_frame, self.looked) = (Instant::now(), Instant::now());
        if std::mem::take(&mut self.is_told) {
            search.tell(&Report::Back);
        }
    }

    fn goes_on(&mut self, search: &mut Search, frames: &FramesIn<Local>) {
        let dead = missed_deadline(search, frames);
        self.looked = Instant::now();
        search.state = DetectorState::Silent;
        let waited = self.last_frame.elapsed();
        if !self.is_told && waited >= WORTH_TELLING {
            self.is_told = true;
            search.tell(&Report::Silent { waited, dead });
        }
    }
}

/// Searches the newest frame if there is one.
fn take(search: &mut Search, frames: &FramesIn<Local>, out: &DetectionsOut<Local>) -> bool {
    search.receives();
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
