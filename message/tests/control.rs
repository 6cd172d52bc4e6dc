//! Requests and answers between roles in domains of their own.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::prelude::ipc;
use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::control::{CameraAsk, CameraReply, CameraRequest, CameraStatistics, ControlState};
use tagbus_message::control_ports::{AskError, CameraAsker, CameraDesk};
use tagbus_message::domain::Domain;
use tagbus_message::qos;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

/// Long enough for any machine: only a hanging test gets there.
const WATCHDOG: Duration = Duration::from_secs(60);

type Local = ipc::Service;

/// A domain of the test's own; that it was left clean is checked when it is dropped.
struct Ground {
    domain: Domain,
}

impl Ground {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("mc{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let root = std::env::temp_dir().join(format!("tb-{name}"));
        Self { domain: Domain::with_root(&name, root).unwrap() }
    }

    fn bus(&self, role: &str) -> Bus<Local> {
        Bus::start(&self.domain, role, &Stop::new().unwrap()).unwrap()
    }

    fn desk(&self) -> CameraDesk<Local> {
        self.bus("camera cam0").create_camera_control("cam0").unwrap()
    }

    fn asker(&self) -> CameraAsker<Local> {
        self.bus("client").open_camera_control("cam0", Patience::AtMost(WATCHDOG)).unwrap()
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

fn request(kind: u32) -> CameraRequest {
    CameraRequest { kind, ..CameraRequest::of(&CameraAsk::Get).unwrap() }
}

/// A reply that repeats the request's kind.
fn reply_to(request: &CameraRequest) -> CameraReply {
    let nothing =
        ControlState { name: [0; 48], min: 0, max: 0, default: 0, value: 0, has_value: 0, inactive: 0 };
    CameraReply {
        schema: request.schema,
        outcome: request.kind,
        info_number: 0,
        state: 0,
        control_count: 0,
        reserved: 0,
        statistics: CameraStatistics::default(),
        text: [0; 512],
        controls: [nothing; 64],
    }
}

/// Answers everything that waits; says of what kinds it was.
fn answer_all(desk: &CameraDesk<Local>) -> Vec<u32> {
    let mut kinds = Vec::new();
    while let Some(asked) = desk.next().unwrap() {
        let request = asked.request();
        asked.answer(&reply_to(&request));
        kinds.push(request.kind);
    }
    kinds
}

#[test]
fn a_request_wakes_the_server_and_its_answer_comes_back() {
    let ground = Ground::new();
    let (desk, stop) = (ground.desk(), Stop::new().unwrap());
    let asker = ground.asker();
    assert!(asker.is_served() && asker.is_current());
    let set = WaitSet::new().unwrap();
    let waiter = Waiter::<Local>::new(&set, &stop, None).unwrap().with_requests(desk.listener()).unwrap();
    assert_eq!(waiter.wait(Duration::ZERO).unwrap(), Wake::TimedOut);
    let pending = asker.ask(&request(5)).unwrap();
    assert!(pending.answer().unwrap().is_none());
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Other);
    assert!(waiter.take_request() && !waiter.take_request());
    assert_eq!(answer_all(&desk), [5]);
    assert_eq!(pending.answer().unwrap().unwrap().outcome, 5);
}

#[test]
fn requests_that_are_paused_do_not_wake_until_they_are_resumed() {
    let ground = Ground::new();
    let (desk, stop) = (ground.desk(), Stop::new().unwrap());
    let asker = ground.asker();
    let set = WaitSet::new().unwrap();
    let waiter = Waiter::<Local>::new(&set, &stop, None).unwrap().with_requests(desk.listener()).unwrap();
    waiter.pause_requests();
    let _pending = asker.ask(&request(1)).unwrap();
    assert_eq!(waiter.wait(Duration::from_millis(20)).unwrap(), Wake::TimedOut);
    waiter.resume_requests().unwrap();
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Other);
    assert_eq!(answer_all(&desk), [1]);
}

#[test]
fn eight_clients_ask_and_the_ninth_is_refused_in_words_until_one_goes() {
    let ground = Ground::new();
    let desk = ground.desk();
    let mut askers: Vec<_> = (0..qos::MAX_CONTROL_CLIENTS).map(|_| ground.asker()).collect();
    let pending: Vec<_> =
        askers.iter().zip(1..).map(|(asker, kind)| asker.ask(&request(kind)).unwrap()).collect();
    let mut kinds = answer_all(&desk);
    kinds.sort_unstable();
    assert_eq!(kinds, (1..=8).collect::<Vec<_>>());
    for (pending, kind) in pending.iter().zip(1..) {
        assert_eq!(pending.answer().unwrap().unwrap().outcome, kind);
    }
    let bus = ground.bus("ninth");
    let error = bus.open_camera_control("cam0", Patience::AtMost(Duration::from_millis(50))).unwrap_err();
    assert!(matches!(error, BusError::Crowded { .. }), "{error:?}");
    assert!(error.to_string().contains("all places of tagbus/v1/cam0/control"), "{error}");
    drop(pending);
    askers.pop();
    assert!(bus.open_camera_control("cam0", Patience::AtMost(WATCHDOG)).is_ok());
}

#[test]
fn a_second_server_of_one_name_is_refused_in_words() {
    let ground = Ground::new();
    let _desk = ground.desk();
    let error = ground.bus("camera cam0").create_camera_control("cam0").unwrap_err();
    assert!(error.to_string().contains("a camera named cam0 is already running"), "{error}");
}

#[test]
fn a_request_that_was_given_up_is_not_handled_and_a_newer_one_takes_its_place() {
    let ground = Ground::new();
    let (desk, asker) = (ground.desk(), ground.asker());
    for kind in 1..100 {
        drop(asker.ask(&request(kind)).unwrap());
    }
    let pending = asker.ask(&request(100)).unwrap();
    assert_eq!(answer_all(&desk), [100]);
    assert!(pending.answer().unwrap().is_some());
    drop(pending);
    drop(asker.ask(&request(101)).unwrap());
    assert_eq!(answer_all(&desk), [0; 0]);
}

#[test]
fn a_client_that_never_takes_its_answers_stops_nobody() {
    let ground = Ground::new();
    let (desk, stuck, other) = (ground.desk(), ground.asker(), ground.asker());
    let _never_read = stuck.ask(&request(1)).unwrap();
    for kind in 2..50 {
        let pending = other.ask(&request(kind)).unwrap();
        assert!(answer_all(&desk).contains(&kind));
        assert_eq!(pending.answer().unwrap().unwrap().outcome, kind);
    }
}

#[test]
fn in_a_flood_of_requests_each_client_has_its_turn() {
    let ground = Ground::new();
    let desk = ground.desk();
    let calm = ground.asker();
    let (over, started) = (AtomicBool::new(false), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for keeps in [true, false] {
            let (ground, over, started) = (&ground, &over, &started);
            scope.spawn(move || {
                let asker = ground.asker();
                started.fetch_add(1, Ordering::SeqCst);
                while !over.load(Ordering::Relaxed) {
                    let Ok(pending) = asker.ask(&request(7)) else { continue };
                    while keeps && pending.answer().unwrap().is_none() && !over.load(Ordering::Relaxed) {}
                }
            });
        }
        let began = Instant::now();
        while started.load(Ordering::SeqCst) < 2 && began.elapsed() < WATCHDOG {
            std::thread::yield_now();
        }
        for kind in 100..120 {
            let pending = calm.ask(&request(kind)).unwrap();
            // A turn of everybody, and one that was in work.
            let answered = (0..3).any(|_| {
                take_round(&desk);
                pending.answer().unwrap().is_some_and(|reply| reply.outcome == kind)
            });
            assert!(answered, "request {kind} had no turn");
        }
        over.store(true, Ordering::Relaxed);
    });
}

/// As many requests as there can be clients.
fn take_round(desk: &CameraDesk<Local>) {
    for _ in 0..qos::MAX_CONTROL_CLIENTS {
        let Some(asked) = desk.next().unwrap() else { return };
        let request = asked.request();
        asked.answer(&reply_to(&request));
    }
}

#[test]
fn a_topic_that_is_not_there_is_said_at_once_where_nobody_wants_to_wait() {
    let ground = Ground::new();
    let error = ground.bus("client").open_camera_control("cam0", Patience::IfThere).unwrap_err();
    assert!(matches!(error, BusError::Absent { .. }), "{error}");
}

#[test]
fn a_server_that_is_started_again_answers_the_same_client() {
    let ground = Ground::new();
    let desk = ground.desk();
    let asker = ground.asker();
    drop(desk);
    assert!(!asker.is_served());
    assert_eq!(asker.ask(&request(2)).unwrap_err(), AskError::Nobody);
    let desk = ground.desk();
    assert!(asker.is_served() && asker.is_current());
    let pending = asker.ask(&request(3)).unwrap();
    assert_eq!(answer_all(&desk), [3]);
    assert!(pending.answer().unwrap().is_some());
}

#[test]
fn another_layout_of_a_running_control_topic_is_told_with_both_sides() {
    let ground = Ground::new();
    let stranger = ground.bus("detector of another make");
    let name = "tagbus/v1/cam0/detectors/main/control".try_into().unwrap();
    let _running = stranger.node().service_builder(&name).request_response::<u64, u32>().create().unwrap();
    let error = ground.bus("asking").open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG));
    let text = error.unwrap_err().to_string();
    assert!(
        text.contains("here: tagbus.DetectorRequest.v1 of 1096 bytes with tagbus.DetectorReply.v1"),
        "{text}"
    );
    assert!(text.contains("there: u64 of 8 bytes with u32 of 4 bytes"), "{text}");
}
