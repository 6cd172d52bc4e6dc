//! The flight recorder tells the truth: delays that are put into a pipeline are found at their hops, and hops add up.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use tagbus_camera::{CameraConfig, Pace, SourceOptions};
use tagbus_client::{Client, ConnectOptions, Detections};
use tagbus_family::Family;
use tagbus_message::bus::BusError;
use tagbus_message::domain::Domain;
use tagbus_message::histogram::Histogram;
use tagbus_message::onlooker::{Copies, Onlooker};
use tagbus_message::stats::{CLIENT_HOPS, CameraStats, ClientStats, DETECTOR_HOPS, DetectorStats, Stats};
use tagbus_message::stop::Stop;
use tagbus_service::ServiceConfig;

/// Only a hanging test gets there.
const WATCHDOG: Duration = Duration::from_secs(60);
/// Messages of each run.
const MESSAGES: usize = 100;

/// How long everybody keeps back what it has.
#[derive(Clone, Copy, Default)]
struct Delays {
    before_publishing: Duration,
    in_detection: Duration,
    in_the_client: Duration,
}

/// What everybody counted in one run.
struct Recorded {
    camera: CameraStats,
    detector: DetectorStats,
    client: ClientStats,
}

impl Recorded {
    /// The shortest times of a hop: what other work on the machine does to it is not in them.
    fn shortest(&self) -> Vec<(&'static str, u64)> {
        let named = |names: &[&'static str], hops: &[Histogram]| {
            names.iter().zip(hops).map(|(name, hop)| (*name, hop.min_ns)).collect::<Vec<_>>()
        };
        let mut all = vec![("publish", self.camera.hops[1].min_ns)];
        all.extend(named(&DETECTOR_HOPS, &self.detector.hops));
        all.extend(named(&CLIENT_HOPS, &self.client.hops));
        all
    }
}

/// A picture again and again, a detector and a client, until enough messages came; and what was recorded then.
fn run(delays: Delays) -> Recorded {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("r{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let root = std::env::temp_dir().join(format!("tb-{name}"));
    let picture = std::env::temp_dir().join(format!("tb-{name}.png"));
    image::GrayImage::from_pixel(320, 240, image::Luma([200])).save(&picture).unwrap();
    let domain = Domain::with_root(&name, root).unwrap();
    let stop = Stop::new().unwrap();
    let camera = CameraConfig {
        domain: domain.clone(),
        camera: "cam0".into(),
        source: format!("replay:{}", picture.display()).parse().unwrap(),
        options: SourceOptions {
            pace: Pace::Framerate(30.0),
            delay: delays.before_publishing,
            ..SourceOptions::default()
        },
    };
    let mut service = ServiceConfig::new(domain.clone(), vec![Family::published("tag36h11").unwrap()]);
    service.observer = Some(Box::new(move |_| thread::sleep(delays.in_detection)));
    let (camera_stop, service_stop) = (stop.clone(), stop.clone());
    let camera = thread::spawn(move || tagbus_camera::run(camera, camera_stop).unwrap());
    let service = thread::spawn(move || tagbus_service::run(service, service_stop).unwrap());
    let mut options = ConnectOptions::in_domain(domain.clone()).deadline(WATCHDOG).named("judge");
    options.delay = delays.in_the_client;
    let recorded = receive(&domain, &options);
    stop.trigger();
    camera.join().unwrap();
    service.join().unwrap();
    std::fs::remove_file(picture).unwrap();
    assert_eq!(domain.leftovers().unwrap(), Vec::<String>::new());
    recorded
}

fn receive(domain: &Domain, options: &ConnectOptions) -> Recorded {
    let mut client = Client::connect(options).unwrap();
    for _ in 0..MESSAGES {
        hops_add_up(&client.receive(WATCHDOG).unwrap().expect("a message before the watchdog"));
    }
    let onlooker = Onlooker::start(domain, &Stop::new().unwrap()).unwrap();
    let camera = opened(|| onlooker.camera("cam0"));
    let detector = opened(|| onlooker.detector("cam0", "main"));
    let clients = opened(|| onlooker.clients("cam0", "main"));
    let enough = MESSAGES as u64;
    Recorded {
        camera: until(&mut client, &camera, |stats| stats.frames >= enough),
        detector: until(&mut client, &detector, |stats| stats.messages >= enough),
        client: until(&mut client, &clients, |stats| stats.received >= enough),
    }
}

/// An onlooker does not wait for topics.
fn opened<T>(open: impl Fn() -> Result<T, BusError>) -> T {
    let begun = Instant::now();
    loop {
        match open() {
            Ok(opened) => return opened,
            Err(error) => assert!(begun.elapsed() < WATCHDOG, "{error}"),
        }
    }
}

/// Goes on receiving, which is when a client publishes, until the copy is there.
fn until<T: Stats>(client: &mut Client, copies: &Copies<T>, is_it: impl Fn(&T) -> bool) -> T {
    let begun = Instant::now();
    loop {
        drop(client.receive(WATCHDOG).unwrap());
        while let Some(stats) = copies.next().unwrap() {
            if is_it(&stats) {
                return stats;
            }
        }
        assert!(begun.elapsed() < WATCHDOG, "no copy came");
    }
}

/// The hops of a message follow each other without a gap, so that their sum is the whole way.
fn hops_add_up(detections: &Detections) {
    let header = detections.header();
    let stamps = [
        header.dequeue_ns,
        header.publish_ns,
        header.receive_ns,
        header.detect_start_ns,
        header.detect_end_ns,
        header.send_ns,
        detections.client_ns(),
    ];
    assert!(stamps.is_sorted(), "{stamps:?}");
    let mut hops = [Histogram::default(); 6];
    hops.iter_mut().zip(stamps.windows(2)).for_each(|(hop, ends)| hop.record(ends[0], ends[1]));
    let sum: u64 = hops.iter().map(|hop| hop.sum_ns).sum();
    assert_eq!(sum, stamps[6] - stamps[0]);
}

#[test]
fn delays_are_found_at_their_hops_and_nowhere_else_and_hops_add_up() {
    let (plain, delays) = (run(Delays::default()), [5, 3, 7].map(Duration::from_millis));
    let [before_publishing, in_detection, in_the_client] = delays;
    let delayed = run(Delays { before_publishing, in_detection, in_the_client });
    for ((hop, before), (_, after)) in plain.shortest().into_iter().zip(delayed.shortest()) {
        let expected_ms = match hop {
            "publish" => 5.0,
            "detect" => 3.0,
            "deliver" => 7.0,
            "total" => 15.0,
            _ => 0.0,
        };
        let seen_ms = (after as f64 - before as f64) / 1e6;
        println!("{hop:9} {expected_ms:4.1} ms put in, {seen_ms:6.3} ms found");
        // A sleep takes up to 0.1 ms longer than asked, and three of them are in the total.
        let allowed_ms = if hop == "total" { 0.6 } else { 0.2 };
        assert!((seen_ms - expected_ms).abs() <= allowed_ms, "{hop}: {seen_ms:.3} ms for {expected_ms} ms");
    }
    assert_eq!((delayed.client.name(), delayed.client.missed), ("judge", 0));
    let hops = &delayed.detector.hops;
    // The search's phases are in it, beside what the observer slept.
    let phases_ns: u64 = hops[2..6].iter().map(|hop| hop.sum_ns).sum();
    assert!(phases_ns <= hops[6].sum_ns, "{phases_ns} of {}", hops[6].sum_ns);
}
