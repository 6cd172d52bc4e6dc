//! What the tests share: a bus of their own, a service in a thread, a camera that publishes what it is told.
#![allow(dead_code, reason = "not every test uses everything")]

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use iceoryx2::prelude::ipc;
use tagbus_client::{Client, ConnectOptions, Detections};
use tagbus_family::{Family, Paint};
use tagbus_message::bus::Bus;
use tagbus_message::domain::Domain;
use tagbus_message::frame::{CaptureKind, FrameHeader, GREY};
use tagbus_message::ports::FramesOut;
use tagbus_message::stop::Stop;
use tagbus_message::{clock, qos};
use tagbus_service::{Report, ServiceConfig, ServiceError, Summary, run};

/// Long enough for any machine: only a hanging test gets there.
pub(crate) const WATCHDOG: Duration = Duration::from_secs(60);
pub(crate) const WIDTH: usize = 320;
pub(crate) const HEIGHT: usize = 240;

/// A domain of the test's own; that it was left clean is checked when it is dropped.
pub(crate) struct Ground {
    pub(crate) domain: Domain,
}

impl Ground {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("s{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let root = std::env::temp_dir().join(format!("tb-{name}"));
        Self { domain: Domain::with_root(&name, root).unwrap() }
    }

    pub(crate) fn config(&self) -> ServiceConfig {
        ServiceConfig::new(self.domain.clone(), vec![Family::published("tag36h11").unwrap()])
    }

    pub(crate) fn client(&self) -> Client {
        Client::connect(&ConnectOptions::in_domain(self.domain.clone()).deadline(WATCHDOG)).unwrap()
    }

    pub(crate) fn camera(&self) -> Camera {
        let bus = Bus::<ipc::Service>::start(&self.domain, "camera cam0", &Stop::new().unwrap()).unwrap();
        let out = bus.create_frames("cam0", &qos::FRAMES, 2 * WIDTH * HEIGHT + 64).unwrap();
        Camera { out, epoch: clock::monotonic_ns(), sequence: 0 }
    }
}

impl Drop for Ground {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert_eq!(self.domain.leftovers().unwrap(), Vec::<String>::new());
            assert!(!self.domain.root().exists(), "the root is still there");
        }
    }
}

/// A service in a thread, and what it reported.
pub(crate) struct Service {
    stop: Stop,
    thread: JoinHandle<Result<Summary, ServiceError>>,
    reports: Arc<Mutex<Vec<Report>>>,
}

impl Service {
    pub(crate) fn start(mut config: ServiceConfig) -> Self {
        let reports = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&reports);
        config.report = Box::new(move |report| kept.lock().unwrap().push(report.clone()));
        let stop = Stop::new().unwrap();
        let own = stop.clone();
        Self { stop, thread: std::thread::spawn(move || run(config, own)), reports }
    }

    pub(crate) fn end(self) -> (Summary, Vec<Report>) {
        self.stop.trigger();
        let summary = self.thread.join().unwrap().unwrap();
        (summary, Arc::into_inner(self.reports).unwrap().into_inner().unwrap())
    }
}

/// A camera that publishes what it is told.
pub(crate) struct Camera {
    out: FramesOut<ipc::Service>,
    pub(crate) epoch: u64,
    pub(crate) sequence: u64,
}

impl Camera {
    pub(crate) fn publish(&mut self, picture: &[u8]) {
        self.publish_with(picture, FrameHeader::packed(GREY, WIDTH as u32, HEIGHT as u32).unwrap());
    }

    pub(crate) fn publish_with(&mut self, payload: &[u8], header: FrameHeader) {
        let loan = self.out.publisher().loan_slice_uninit(payload.len()).unwrap();
        let mut loan = loan.write_from_slice(payload);
        *loan.user_header_mut() = FrameHeader {
            epoch: self.epoch,
            sequence: self.sequence,
            capture_ns: clock::monotonic_ns(),
            capture_kind: CaptureKind::Dequeue.code(),
            dequeue_ns: clock::monotonic_ns(),
            publish_ns: clock::monotonic_ns(),
            frame_time_ns: 33_000_000,
            ..header
        };
        self.sequence += 1;
        loan.send().unwrap();
        self.out.notify().unwrap();
    }

    /// Publishes a picture again and again until the client hears of it: a detector may still be connecting.
    pub(crate) fn publish_until_heard(&mut self, picture: &[u8], client: &mut Client) -> Detections {
        for _ in 0..WATCHDOG.as_millis() / 20 {
            self.publish(picture);
            if let Some(detections) = client.receive(Duration::from_millis(20)).unwrap() {
                return detections;
            }
        }
        panic!("no detections came");
    }
}

/// An upright tag, 8 pixels a cell, on a bright grey.
pub(crate) fn picture_of(ids: &[u32]) -> Vec<u8> {
    const CELL: usize = 8;
    let family = Family::published("tag36h11").unwrap();
    let mut picture = vec![200; WIDTH * HEIGHT];
    for (place, &id) in ids.iter().enumerate() {
        let grid = family.grid(id).unwrap();
        let left = 20 + place * 110;
        for (y, row) in picture.chunks_exact_mut(WIDTH).skip(40).take(grid.width() * CELL).enumerate() {
            for x in 0..grid.width() * CELL {
                row[left + x] = match grid.get(x / CELL, y / CELL) {
                    Paint::Black => 20,
                    Paint::White | Paint::Clear => 230,
                };
            }
        }
    }
    picture
}

pub(crate) fn ids_of(detections: &Detections) -> Vec<u32> {
    let mut ids: Vec<_> = detections.tags().iter().map(|tag| tag.id).collect();
    ids.sort_unstable();
    ids
}

pub(crate) fn until(client: &mut Client, wanted: impl Fn(&Detections) -> bool) -> Detections {
    loop {
        let detections = client.receive(WATCHDOG).unwrap().expect("the message came before the watchdog");
        if wanted(&detections) {
            return detections;
        }
    }
}
