//! A camera that streams: requests are filled in the library's thread and read here.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use ::libcamera::camera::ActiveCamera;
use ::libcamera::control::ControlList;
use ::libcamera::control_value::ControlValue;
use ::libcamera::controls;
use ::libcamera::framebuffer::{AsFrameBuffer, FrameMetadataStatus};
use ::libcamera::framebuffer_allocator::{FrameBuffer, FrameBufferAllocator};
use ::libcamera::request::{Request, RequestStatus, ReuseFlag};
use tagbus_message::frame::CaptureKind;

use super::agree::{Agreement, agree};
use super::controls::{Chosen, choose};
use super::library::{Library, model};
use super::plane::LumaPlane;
use crate::config::SourceOptions;
use crate::control::ControlSettings;
use crate::stamps::DriverStamp;

/// More messages than there are requests, so that the library's thread never waits.
const MESSAGES: usize = 64;

/// What the library's thread tells.
enum Told {
    Filled(Request),
    Disconnected,
}

/// What became of a request.
pub(super) enum Taken {
    Nothing,
    Gone,
    Frame(Box<Frame>),
}

/// A frame that can be read until it is given back.
pub(super) struct Frame {
    request: Request,
    /// Why it must not be read.
    pub(super) damage: Option<&'static str>,
    pub(super) stamp: DriverStamp,
    /// Exposure time of this very frame, nanoseconds; 0 when the camera does not say.
    pub(super) exposure_ns: u64,
}

/// A camera that was configured, and streams once it was started. Fields are dropped in this order.
pub(super) struct Session {
    camera: ActiveCamera<'static>,
    told: Receiver<Told>,
    planes: Vec<LumaPlane>,
    waiting: Vec<Request>,
    /// Set with the next request.
    pending: Vec<Chosen>,
    pub(super) agreed: Agreement,
    pub(super) model: String,
    pub(super) id: String,
    /// Nominal time from frame to frame; zero when the camera chooses it.
    pub(super) frame_time: Duration,
    /// Controls that were set, in words.
    pub(super) controls: Vec<String>,
}

impl Session {
    /// Opens the camera of that id, or the first one, and agrees on what the options say.
    pub(super) fn open(
        library: &Library,
        id: Option<&str>,
        options: &SourceOptions,
        settings: &ControlSettings,
    ) -> Result<Session, String> {
        let found = library.find(id)?;
        let (id, model) = (found.id().to_owned(), model(&found));
        let named = |text: String| format!("libcamera:{id}: {model}: {text}");
        let mut camera =
            found.acquire().map_err(|error| named(format!("it cannot be had, is it in use? {error}")))?;
        let mut agreed = agree(&mut camera, options).map_err(&named)?;
        let mut pending = choose(camera.controls(), &settings.0).map_err(&named)?;
        let controls = pending.iter().map(|chosen| chosen.text.clone()).collect();
        let frame_time = rate(&camera, options, &mut pending, &mut agreed.changed);
        let (planes, waiting) =
            requests(&mut camera, &agreed).map_err(|error| named(format!("it has no memory: {error}")))?;
        let (teller, told) = sync_channel(MESSAGES);
        listen(&mut camera, &teller);
        Ok(Session { camera, told, planes, waiting, pending, agreed, model, id, frame_time, controls })
    }

    /// Begins to stream.
    pub(super) fn start(&mut self) -> io::Result<()> {
        let mut first = ControlList::new();
        for chosen in self.pending.drain(..) {
            first.set_raw(chosen.id, chosen.value).map_err(io::Error::other)?;
        }
        self.camera.start(Some(&first))?;
        let queue = |request| self.camera.queue_request(request).map_err(|(_, error)| error);
        self.waiting.drain(..).try_for_each(queue)
    }

    /// Buffers under way.
    pub(super) fn buffers(&self) -> usize {
        self.planes.len()
    }

    /// Waits for a frame.
    pub(super) fn take(&self, patience: Duration) -> Taken {
        match self.told.recv_timeout(patience) {
            Ok(Told::Filled(request)) if request.status() == RequestStatus::Cancelled => Taken::Gone,
            Ok(Told::Filled(request)) => Taken::Frame(Box::new(self.frame(request))),
            Ok(Told::Disconnected) | Err(RecvTimeoutError::Disconnected) => Taken::Gone,
            Err(RecvTimeoutError::Timeout) => Taken::Nothing,
        }
    }

    fn frame(&self, request: Request) -> Frame {
        let about = request.metadata();
        let sensor_ns =
            about.get::<controls::SensorTimestamp>().ok().and_then(|stamp| u64::try_from(stamp.0).ok());
        let exposure_us =
            about.get::<controls::ExposureTime>().ok().and_then(|time| u64::try_from(time.0).ok());
        let buffer = request.buffer::<FrameBuffer>(&self.agreed.stream);
        let said = buffer.and_then(|buffer| {
            buffer.metadata().map(|said| (said.status(), said.sequence(), said.timestamp()))
        });
        let (status, sequence, buffer_ns) =
            said.unwrap_or((FrameMetadataStatus::Error, request.sequence(), 0));
        let damage = match status {
            FrameMetadataStatus::Success => None,
            FrameMetadataStatus::Startup => Some("the camera calls it a frame of its start"),
            FrameMetadataStatus::Error | FrameMetadataStatus::Cancelled => {
                Some("the camera calls it damaged")
            }
        };
        let kind = if sensor_ns.is_some() { CaptureKind::StartOfExposure } else { CaptureKind::Unknown };
        let stamp_ns = sensor_ns.unwrap_or(buffer_ns);
        let stamp = DriverStamp { sequence, stamp_ns, monotonic: stamp_ns > 0, kind };
        Frame { damage, stamp, exposure_ns: exposure_us.unwrap_or(0) * 1000, request }
    }

    /// Copies a frame's luma.
    pub(super) fn copy(&self, frame: &Frame, to: &mut [u8]) -> io::Result<()> {
        let Agreement { luma, stride, shape, .. } = &self.agreed;
        let plane = usize::try_from(frame.request.cookie()).ok().and_then(|number| self.planes.get(number));
        let plane = plane.ok_or_else(|| io::Error::other("a buffer that is not ours"))?;
        plane.copy(*luma, *stride, shape.width() as usize, to)
    }

    /// Has the camera fill the frame's memory again, with controls that were set since.
    pub(super) fn give_back(&mut self, frame: Frame) -> io::Result<()> {
        let mut request = frame.request;
        request.reuse(ReuseFlag::REUSE_BUFFERS);
        for chosen in self.pending.drain(..) {
            request.controls_mut().set_raw(chosen.id, chosen.value).map_err(io::Error::other)?;
        }
        self.camera.queue_request(request).map_err(|(_, error)| error)
    }

    /// Every control that can be set.
    pub(super) fn list_controls(&self) -> Vec<crate::control::ControlInfo> {
        super::controls::list(self.camera.controls())
    }

    /// Sets controls with the next frame that is asked for.
    pub(super) fn set(&mut self, settings: &ControlSettings) -> Result<String, String> {
        let chosen = choose(self.camera.controls(), &settings.0)?;
        let text = chosen.iter().map(|chosen| chosen.text.as_str()).collect::<Vec<_>>().join(", ");
        self.pending.extend(chosen);
        Ok(text)
    }
}

/// Has the camera keep a rate, where it can.
fn rate(
    camera: &ActiveCamera<'_>,
    options: &SourceOptions,
    pending: &mut Vec<Chosen>,
    changed: &mut Vec<String>,
) -> Duration {
    let Some(rate) = options.pace.framerate() else { return Duration::ZERO };
    let id = controls::ControlId::FrameDurationLimits.id();
    if camera.controls().find(id).is_err() {
        changed.push(format!("the rate of the camera's choice instead of {rate} frames/s"));
        return Duration::ZERO;
    }
    let microseconds = (1e6 / rate).round() as i64;
    let value = ControlValue::from([microseconds, microseconds]);
    pending.push(Chosen { id, value, text: format!("{rate} frames/s") });
    Duration::from_micros(microseconds.unsigned_abs())
}

/// A request for each buffer, and their memory mapped; a request's cookie is the number of its plane.
fn requests(
    camera: &mut ActiveCamera<'static>,
    agreed: &Agreement,
) -> io::Result<(Vec<LumaPlane>, Vec<Request>)> {
    let buffers = FrameBufferAllocator::new(camera).alloc(&agreed.stream)?;
    let (mut planes, mut requests) = (Vec::new(), Vec::new());
    for (number, buffer) in buffers.into_iter().enumerate() {
        planes.push(LumaPlane::of(&buffer)?);
        let mut request = camera
            .create_request(Some(number as u64))
            .ok_or_else(|| io::Error::other("it takes no request"))?;
        request.add_buffer(&agreed.stream, buffer)?;
        requests.push(request);
    }
    Ok((planes, requests))
}

fn listen(camera: &mut ActiveCamera<'static>, teller: &SyncSender<Told>) {
    // Both fail only when nobody listens any more.
    let filled = teller.clone();
    camera.on_request_completed(move |request| drop(filled.try_send(Told::Filled(request))));
    let gone = teller.clone();
    camera.on_disconnected(move || drop(gone.try_send(Told::Disconnected)));
}
