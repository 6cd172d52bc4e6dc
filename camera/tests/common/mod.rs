//! A bus of a test's own, a camera on it, and a subscriber.
#![allow(dead_code, reason = "not every file of tests uses all of it")]

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use iceoryx2::prelude::ipc;
use tagbus_camera::{CameraConfig, CameraError, CameraEvent, Source, SourceOptions, Summary};
use tagbus_message::bus::Bus;
use tagbus_message::domain::Domain;
use tagbus_message::frame::FrameHeader;
use tagbus_message::ports::FramesIn;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

/// Long enough for any machine: only a hanging test gets there.
pub(crate) const WATCHDOG: Duration = Duration::from_secs(60);

/// A domain and a folder of the test's own; that the domain was left clean is checked at the end.
pub(crate) struct Ground {
    pub(crate) domain: Domain,
    pub(crate) folder: PathBuf,
}

impl Ground {
    pub(crate) fn new() -> Ground {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("c{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(format!("tagbus-camera-{name}"));
        fs::create_dir_all(&folder).unwrap();
        let root = std::env::temp_dir().join(format!("tb-{name}"));
        Ground { domain: Domain::with_root(&name, root).unwrap(), folder }
    }

    pub(crate) fn file(&self, name: &str, content: &[u8]) -> PathBuf {
        fs::write(self.folder.join(name), content).unwrap();
        self.folder.join(name)
    }

    pub(crate) fn camera(&self, source: Source, options: SourceOptions) -> RunningCamera {
        let config = CameraConfig { domain: self.domain.clone(), camera: "cam0".into(), source, options };
        RunningCamera::start(config)
    }

    pub(crate) fn bus(&self) -> Bus<ipc::Service> {
        Bus::start(&self.domain, "viewer", &Stop::new().unwrap()).unwrap()
    }
}

impl Drop for Ground {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
        if !thread::panicking() {
            assert_eq!(self.domain.leftovers().unwrap(), Vec::<String>::new());
            assert!(!self.domain.root().exists(), "the root is still there");
        }
    }
}

/// A camera in a thread of its own.
pub(crate) struct RunningCamera {
    pub(crate) stop: Stop,
    outcome: Receiver<Result<Summary, CameraError>>,
    pub(crate) events: Receiver<CameraEvent>,
}

impl RunningCamera {
    pub(crate) fn start(config: CameraConfig) -> RunningCamera {
        let stop = Stop::new().unwrap();
        let (tell_outcome, outcome) = channel();
        let (tell_event, events) = channel();
        let camera_stop = stop.clone();
        thread::spawn(move || {
            let mut report = |event| drop(tell_event.send(event));
            drop(tell_outcome.send(tagbus_camera::run_reporting(config, camera_stop, &mut report)));
        });
        RunningCamera { stop, outcome, events }
    }

    pub(crate) fn end(&self) -> Result<Summary, CameraError> {
        self.outcome.recv_timeout(WATCHDOG).expect("the camera ends")
    }

    pub(crate) fn stop(&self) -> Summary {
        self.stop.trigger();
        self.end().unwrap()
    }
}

/// Waits for the next frame; the answer is a copy of its checked header and of its picture.
pub(crate) fn receive(frames: &FramesIn<ipc::Service>) -> (FrameHeader, Vec<u8>) {
    let stop = Stop::new().unwrap();
    let set = WaitSet::new().unwrap();
    let waiter = Waiter::<ipc::Service>::new(&set, &stop, Some(frames.bell())).unwrap();
    loop {
        if let Some(sample) = frames.receive().unwrap() {
            let header = *sample.user_header();
            header.validate(sample.payload().len()).unwrap();
            let picture = &sample.payload()[header.data_offset as usize..];
            assert_eq!(picture.as_ptr().addr() % 64, 0, "aligned for the reader too");
            return (header, picture[..header.bytes_used as usize].to_vec());
        }
        assert_ne!(waiter.wait(WATCHDOG).unwrap(), Wake::TimedOut, "no frame came");
    }
}
