//! A camera whose frames come from a device: opened, streamed from, waited for when it goes, opened again.
//!
//! ```text
//! open, agree ─▶ onto the bus ─▶ begin ─▶ streaming ──── stop ────▶ ended
//!                                  ▲          │ gone, silent, broken
//!                                  └─ open ◀─ lost / waiting
//! ```

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tagbus_message::Local;
use tagbus_message::info::CameraState;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

use super::agree::{Agreement, Content, NoAgreement, agree};
use super::controls::{self, Applied, OfDevice};
use super::identity::Identity;
use super::kernel::{About, Port};
use super::refusal::{self, ASKING};
use super::stream::{Broken, Stream};
use super::transfer::Transfer;
use crate::config::CameraConfig;
use crate::control::ControlSettings;
use crate::desk::NoControls;
use crate::outlet::{GREETING_PERIOD, Offer, Outlet};
use crate::run::{CameraError, CameraEvent, Ending, Summary};
use crate::source::{Damage, OpenError};

/// A device that brings no frame for so many frame times has stopped delivering.
const SILENT_FRAMES: u32 = 20;

/// ... and for this time at least: exposures can be long, and a busy machine late.
const SILENT: Duration = Duration::from_secs(2);

/// How often a device that went is looked for.
const LOOKING_PERIOD: Duration = Duration::from_millis(250);

/// A pause after a call that brought nothing, so that a device that claims to be ready all the time costs no processor.
const FRUITLESS: Duration = Duration::from_millis(1);

/// Publishes frames of the device at `path` until `stop` is triggered.
pub(crate) fn publish(
    config: &CameraConfig,
    path: &Path,
    stop: &Stop,
    report: &mut dyn FnMut(CameraEvent),
) -> Result<Summary, CameraError> {
    let identity = Identity::of(path);
    let device = Opened::at(path, config, &config.options.controls).map_err(OpenError::Device)?;
    let offer = Offer {
        largest: device.said.agreed.layout.shape,
        stored_format: device.said.agreed.driver.fourcc,
        model: &device.said.about.card,
        frame_time: device.said.agreed.frame_time,
    };
    let outlet = Outlet::open(config, &offer, stop, report)?;
    let camera = DeviceCamera {
        config,
        controls: config.options.controls.clone(),
        identity,
        outlet,
        damage: Damage::default(),
        frame_time: offer.frame_time,
    };
    camera.work(device, stop)
}

/// A device that is open, with what was agreed.
struct Opened {
    port: Port,
    said: Said,
}

/// What there is to say of an open device.
struct Said {
    path: PathBuf,
    about: About,
    agreed: Agreement,
    controls: Vec<Applied>,
}

impl Opened {
    /// Opens the device and asks for what the configuration says; an error says why not and what helps.
    fn at(path: &Path, config: &CameraConfig, controls: &ControlSettings) -> Result<Opened, String> {
        let failed = |doing: &str, error: &io::Error| refusal::call(path, doing, error);
        let mut port = Port::open(path).map_err(|error| failed("opening it", &error))?;
        let about = port.about().map_err(|error| failed(ASKING, &error))?;
        if let Some(reason) = refusal::unsuitable(path, &about) {
            return Err(reason);
        }
        let agreed = agree(&port, &config.options).map_err(|none| match none {
            NoAgreement::Call(doing, error) => failed(doing, &error),
            NoAgreement::Unfit(reason) => format!("{}: {}: {reason}", path.display(), about.card),
        })?;
        // After the format, with which some devices set their controls anew.
        let controls = controls::apply(&port, controls)
            .map_err(|reason| format!("{}: {}: {reason}", path.display(), about.card))?;
        Ok(Opened { port, said: Said { path: path.into(), about, agreed, controls } })
    }
}

struct DeviceCamera<'a> {
    config: &'a CameraConfig,
    /// Set whenever the device is opened: those of the configuration, and those that were set since.
    controls: ControlSettings,
    identity: Identity,
    outlet: Outlet<'a>,
    damage: Damage,
    frame_time: Duration,
}

impl DeviceCamera<'_> {
    fn work(mut self, device: Opened, stop: &Stop) -> Result<Summary, CameraError> {
        let path = device.said.path.clone();
        // A device that cannot even begin is an error; one that did is waited for.
        let first = self.begin(device).map_err(|error| {
            CameraError::Open(OpenError::Device(refusal::call(&path, "starting it", &error)))
        });
        let ended = first.and_then(|stream| self.stream_on(stream, stop));
        self.outlet.announce(CameraState::Ended);
        self.outlet.summary.ending = ended?;
        Ok(self.outlet.summary)
    }

    /// Streams, and whenever the device breaks off waits for it and streams again.
    fn stream_on(&mut self, first: Stream, stop: &Stop) -> Result<Ending, CameraError> {
        let mut stream = first;
        loop {
            let broken = self.stream(&mut stream, stop);
            self.outlet.summary.repins += stream.repins();
            let error = match broken {
                Ok(ending) => return Ok(ending),
                Err(Broken::Camera(error)) => return Err(error),
                Err(Broken::Device(error)) => error,
            };
            // Closed before it is looked for: a device that is held open keeps its number.
            drop(stream);
            match self.wait_for_it(&error, stop) {
                Some(again) => stream = again,
                None => return Ok(Ending::Stopped),
            }
        }
    }

    /// Begins to stream: into lent memory where the driver takes it and the frames are pixels, through its own elsewhere.
    fn begin(&mut self, device: Opened) -> io::Result<Stream> {
        let reason = match (device.said.agreed.content, device.port.takes_our_memory()?) {
            (Content::Jpeg, _) => "frames have to be decoded".to_string(),
            (Content::Packed(_), _) => "values have to be brought to 8 bits of luma".to_string(),
            (_, false) => {
                format!("the driver {} takes no memory of ours (no USERPTR)", device.said.about.driver)
            }
            (_, true) => return self.begin_lent(device),
        };
        self.begin_mapped(device, reason)
    }

    fn begin_lent(&mut self, device: Opened) -> io::Result<Stream> {
        let Opened { port, said } = device;
        let error = match Stream::lend(port, &said.agreed, &mut self.outlet) {
            Ok((stream, transfer)) => return Ok(self.begun(said, transfer, stream)),
            Err(error) => error,
        };
        // The queue is in a state that nobody knows: the device is opened anew.
        let device = Opened::at(&said.path, self.config, &self.controls).map_err(io::Error::other)?;
        let reason = format!("the driver {} refuses our memory: {error}", said.about.driver);
        self.begin_mapped(device, reason)
    }

    fn begin_mapped(&mut self, device: Opened, reason: String) -> io::Result<Stream> {
        let Opened { port, said } = device;
        let (stream, transfer) = Stream::map(port, &said.agreed, reason)?;
        Ok(self.begun(said, transfer, stream))
    }

    fn begun(&mut self, said: Said, transfer: Transfer, stream: Stream) -> Stream {
        let Said { path, about, agreed, controls } = said;
        let exposure = controls::exposure(stream.port());
        // Devices that choose it themselves do not say what they chose.
        self.outlet.info.exposure_ns = if exposure.is_automatic { 0 } else { exposure.time_ns };
        self.outlet.info.auto_exposure = exposure.is_automatic.into();
        self.outlet.tell(CameraEvent::Opened {
            device: format!("{} ({}, driver {})", path.display(), about.card, about.driver),
            format: agreed.driver.fourcc,
            frame_time: agreed.frame_time,
            changed: agreed.changed,
            controls: controls.iter().map(Applied::text).collect(),
            transfer,
        });
        self.outlet.announce(CameraState::Streaming);
        stream
    }

    /// Publishes what the device delivers until it breaks off or a stop is asked for.
    fn stream(&mut self, stream: &mut Stream, stop: &Stop) -> Result<Ending, Broken> {
        let trouble = |error: &dyn std::fmt::Display| io::Error::other(error.to_string());
        let set = WaitSet::new().map_err(|error| trouble(&error))?;
        let waiter = Waiter::<Local>::new(&set, stop, None).map_err(|error| trouble(&error))?;
        let readiness = stream.port().readiness()?;
        let _attached = set.attach(&readiness).map_err(|error| trouble(&error))?;
        let patience = SILENT.max(self.frame_time * SILENT_FRAMES);
        let mut last_frame = Instant::now();
        loop {
            match waiter.wait(GREETING_PERIOD).map_err(|error| trouble(&error))? {
                Wake::Stop => return Ok(Ending::Stopped),
                Wake::TimedOut => {}
                Wake::Event | Wake::Other => {
                    match stream.publish_filled(&mut self.outlet, &mut self.damage)? {
                        0 if stop.wait(FRUITLESS) => return Ok(Ending::Stopped),
                        0 => {}
                        _ => last_frame = Instant::now(),
                    }
                }
            }
            self.outlet.greet();
            self.outlet.answer(&mut OfDevice { port: stream.port(), kept: &mut self.controls });
            if last_frame.elapsed() >= patience {
                let silence = format!("no frame for {:.1} s", last_frame.elapsed().as_secs_f64());
                return Err(io::Error::new(io::ErrorKind::TimedOut, silence).into());
            }
        }
    }

    /// Looks for the device until it streams again; `None` when a stop is asked for.
    fn wait_for_it(&mut self, error: &io::Error, stop: &Stop) -> Option<Stream> {
        let gone = Instant::now();
        let mut reason = format!("the device broke off: {error}");
        let mut told = None;
        loop {
            let node = self.identity.node();
            let state = if node.is_some() { CameraState::Waiting } else { CameraState::Lost };
            if told.as_ref() != Some(&(state, reason.clone())) {
                told = Some((state, reason.clone()));
                self.outlet.announce(state);
                self.outlet.tell(CameraEvent::Interrupted { state, reason: reason.clone() });
            }
            if stop.wait(LOOKING_PERIOD) {
                return None;
            }
            self.outlet.greet();
            self.outlet.answer(&mut NoControls("the device is not there at present"));
            match node.map(|node| self.open_again(&node)) {
                Some(Ok(stream)) => {
                    self.count_missed(gone.elapsed());
                    return Some(stream);
                }
                Some(Err(why)) => reason = why,
                None => {}
            }
        }
    }

    fn open_again(&mut self, node: &Path) -> Result<Stream, String> {
        let device = Opened::at(node, self.config, &self.controls)?;
        let (seen, expected) = (device.said.agreed.layout.shape, self.outlet.largest());
        if seen.bytes() > expected.bytes() {
            return Err(format!(
                "{}: it came back with frames of {seen}, and memory was made for {expected}: start the camera anew",
                node.display()
            ));
        }
        self.begin(device).map_err(|error| refusal::call(node, "starting it", &error))
    }

    /// Frames that there would have been.
    fn count_missed(&mut self, gone: Duration) {
        let frame_time_ns = self.frame_time.as_nanos().max(1);
        let missed = if self.frame_time.is_zero() { 1 } else { gone.as_nanos() / frame_time_ns };
        self.outlet.lost.in_driver += u64::try_from(missed).unwrap_or(0).max(1);
    }
}
