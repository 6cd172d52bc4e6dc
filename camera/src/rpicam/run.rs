//! A camera whose frames a program writes: started, read from, started again when it ends or falls silent.

use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use tagbus_message::Local;
use tagbus_message::clock;
use tagbus_message::frame::YU12;
use tagbus_message::info::CameraState;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

use super::program::{Program, Running};
use super::reader::{FrameReader, Progress};
use crate::config::CameraConfig;
use crate::desk::NoControls;
use crate::device::Transfer;
use crate::format::FrameShape;
use crate::loan::Loan;
use crate::outlet::{GREETING_PERIOD, Offer, Outlet};
use crate::publish::Moment;
use crate::run::{CameraError, CameraEvent, Ending, Summary};
use crate::source::{Damage, Filled, OpenError};

/// The size where none is asked for.
const DEFAULT_SIZE: (u32, u32) = (1280, 720);

/// Rows of other widths are padded by the camera's hardware, by an amount that the pipe does not tell.
const WIDTH_STEP: u32 = 64;

/// The first frame takes this long at most: the program starts the sensor and lets exposure settle.
const FIRST_FRAME: Duration = Duration::from_secs(10);

/// Later ones this long, or so many frame times.
const SILENT: Duration = Duration::from_secs(2);
const SILENT_FRAMES: u32 = 20;

/// Pause when no memory is free for a frame, which happens only when processes died that held more than their share.
const NO_MEMORY_PAUSE: Duration = Duration::from_millis(1);

/// Why nothing can be set while it runs.
const FIXED_OPTIONS: &str = "the program that writes the frames takes its options at its start only: start the camera anew with other --control";

/// Pause before the program is started again.
const PAUSE: Duration = Duration::from_millis(500);

/// Publishes what the program writes until `stop` is triggered.
pub(crate) fn publish(
    config: &CameraConfig,
    named: Option<&Path>,
    stop: &Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    let options = &config.options;
    let shape = shape(options.width, options.height).map_err(OpenError::Device)?;
    let program = Program::find(named, options, shape).ok_or_else(|| OpenError::Device(missing(named)))?;
    let frame_time =
        options.pace.framerate().map_or(Duration::ZERO, |rate| Duration::from_secs_f64(1.0 / rate));
    let offer = Offer { largest: shape, stored_format: YU12, model: "rpicam-vid", frame_time };
    let outlet = Outlet::open(config, &offer, stop, report)?;
    PipeCamera { program, shape, frame_time, outlet, damage: Damage::default(), frames: 0 }.work(stop)
}

fn shape(width: Option<u32>, height: Option<u32>) -> Result<FrameShape, String> {
    let (width, height) = (width.unwrap_or(DEFAULT_SIZE.0), height.unwrap_or(DEFAULT_SIZE.1));
    if width % WIDTH_STEP != 0 {
        let below = width / WIDTH_STEP * WIDTH_STEP;
        return Err(format!(
            "rpicam: rows of {width} pixels would come padded by an unknown amount: use a width that is a multiple of {WIDTH_STEP}, \
             such as {} or {}",
            below.max(WIDTH_STEP),
            below + WIDTH_STEP
        ));
    }
    FrameShape::grey(width, height).map_err(|error| format!("rpicam: {error}"))
}

fn missing(named: Option<&Path>) -> String {
    match named {
        Some(path) => format!("rpicam: {}: there is no such program", path.display()),
        None => "rpicam: neither rpicam-vid nor libcamera-vid is installed: `sudo apt install rpicam-apps` (on Raspberry Pi OS)"
            .to_string(),
    }
}

/// Why a program is read from no longer.
enum Over {
    Stopped,
    Broke(String),
}

struct PipeCamera<'a> {
    program: Program,
    shape: FrameShape,
    frame_time: Duration,
    outlet: Outlet<'a>,
    damage: Damage,
    /// Frames since the program was started.
    frames: u64,
}

impl PipeCamera<'_> {
    fn work(mut self, stop: &Stop) -> Result<Summary, CameraError> {
        let ended = self.work_on(stop);
        self.outlet.announce(CameraState::Ended);
        self.outlet.summary.ending = ended?;
        Ok(self.outlet.summary)
    }

    fn work_on(&mut self, stop: &Stop) -> Result<Ending, CameraError> {
        let mut ever = false;
        loop {
            let reason = match self.run_once(stop)? {
                Over::Stopped => return Ok(Ending::Stopped),
                Over::Broke(reason) => reason,
            };
            ever |= self.frames > 0;
            if !ever {
                // It has never worked: no camera, or options that it does not know.
                let path = self.program.path().display();
                return Err(OpenError::Device(format!("{path}: no frame came: {reason}")).into());
            }
            self.outlet.announce(CameraState::Waiting);
            self.outlet.tell(CameraEvent::Interrupted { state: CameraState::Waiting, reason });
            if stop.wait(PAUSE) {
                return Ok(Ending::Stopped);
            }
            self.outlet.lost.in_driver += 1;
        }
    }

    /// Starts the program and publishes what it writes.
    fn run_once(&mut self, stop: &Stop) -> Result<Over, CameraError> {
        self.frames = 0;
        let mut running = match self.program.start() {
            Ok(running) => running,
            Err(error) => return Ok(Over::Broke(format!("it cannot be started: {error}"))),
        };
        match self.read(&mut running, stop) {
            Ok(over) => over,
            Err(error) => Ok(Over::Broke(error.to_string())),
        }
    }

    /// The outer error is the pipe's, the inner one the camera's.
    fn read(&mut self, running: &mut Running, stop: &Stop) -> io::Result<Result<Over, CameraError>> {
        let trouble = |error: &dyn std::fmt::Debug| io::Error::other(format!("{error:?}"));
        let set = WaitSet::new().map_err(|error| trouble(&error))?;
        let waiter = Waiter::<Local>::new(&set, stop, None).map_err(|error| trouble(&error))?;
        let readiness = running.readiness()?;
        let _attached = set.attach(&readiness).map_err(|error| trouble(&error))?;
        let mut reader = FrameReader::new(self.shape);
        let mut controls = NoControls(FIXED_OPTIONS);
        let mut loan = None;
        let mut last_frame = Instant::now();
        loop {
            if waiter.wait(GREETING_PERIOD).map_err(|error| trouble(&error))? == Wake::Stop {
                return Ok(Ok(Over::Stopped));
            }
            self.outlet.greet();
            self.outlet.answer(&mut controls);
            let before = self.frames;
            match self.take(running, &mut reader, &mut loan)? {
                Ok(None) => {}
                Ok(Some(reason)) => return Ok(Ok(Over::Broke(reason))),
                Err(error) => return Ok(Err(error)),
            }
            if self.frames > before {
                last_frame = Instant::now();
            }
            if last_frame.elapsed() >= self.patience() {
                let silence = last_frame.elapsed().as_secs_f64();
                return Ok(Ok(Over::Broke(format!("no frame for {silence:.1} s"))));
            }
        }
    }

    fn patience(&self) -> Duration {
        if self.frames == 0 { FIRST_FRAME } else { SILENT.max(self.frame_time * SILENT_FRAMES) }
    }

    /// Publishes what has been written; says why when there will be no more.
    fn take(
        &mut self,
        running: &mut Running,
        reader: &mut FrameReader,
        loan: &mut Option<Loan>,
    ) -> io::Result<Result<Option<String>, CameraError>> {
        loop {
            let Some(mut memory) = loan.take().or_else(|| self.outlet.lendable()) else {
                // The pipe stays readable meanwhile.
                std::thread::sleep(NO_MEMORY_PAUSE);
                return Ok(Ok(None));
            };
            match reader.read(running, memory.picture())? {
                Progress::NeedsMore => {
                    *loan = Some(memory);
                    return Ok(Ok(None));
                }
                Progress::Frame => {
                    if let Err(error) = self.send(memory, running) {
                        return Ok(Err(error));
                    }
                }
                Progress::Ended(bytes) => {
                    if bytes > 0 {
                        self.damage.note(format_args!("the program ended {bytes} bytes into a frame"));
                        self.outlet.note_damage(&self.damage);
                    }
                    return Ok(Ok(Some(running.obituary())));
                }
            }
        }
    }

    fn send(&mut self, loan: Loan, running: &Running) -> Result<(), CameraError> {
        if self.frames == 0 {
            self.outlet.tell(CameraEvent::Opened {
                device: format!("{} (process {})", self.program.path().display(), running.process()),
                format: YU12,
                frame_time: self.frame_time,
                changed: Vec::new(),
                controls: Vec::new(),
                transfer: Transfer::Piped,
            });
            self.outlet.announce(CameraState::Streaming);
        }
        self.frames += 1;
        // The pipe carries no stamps: this is when the frame was complete.
        self.outlet.send(
            loan,
            Filled { shape: self.shape, copies: 1 },
            Moment::dequeued(clock::monotonic_ns()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_that_would_come_padded_is_refused_with_its_neighbours() {
        let error = shape(Some(800), Some(600)).unwrap_err();
        assert!(error.contains("768 or 832"), "{error}");
        assert!(shape(Some(1 << 20), None).is_err());
        assert_eq!(shape(None, None), Ok(FrameShape::grey(1280, 720).unwrap()));
    }
}
