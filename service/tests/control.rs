//! A running detector that is asked and told; each test in its own domain.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

mod common;

use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use common::{Camera, Ground, HEIGHT, Service, WATCHDOG, WIDTH, ids_of, picture_of, until};
use iceoryx2::prelude::ipc;
use tagbus_client::control::{
    ControlError, DetectorAnswer, DetectorChange, DetectorControl, DetectorState, RefinementChoice, Region,
};
use tagbus_client::{Client, ConnectError, ConnectOptions, Detections, DetectionsHeader, header_flags};
use tagbus_family::Family;
use tagbus_message::bus::{Bus, Patience};
use tagbus_message::control::{DetectorAsk, DetectorRequest, Outcome};
use tagbus_message::domain::Domain;
use tagbus_message::stop::Stop;
use tagbus_service::Report;

fn options(domain: &Domain) -> ConnectOptions {
    ConnectOptions::in_domain(domain.clone()).deadline(WATCHDOG)
}

fn control(ground: &Ground) -> DetectorControl {
    DetectorControl::connect(&options(&ground.domain)).unwrap().timeout(WATCHDOG)
}

/// Decimation, corrected bits and families.
type Named = (f32, i32, Vec<String>);

/// What a header says of the parameters.
fn named(header: &DetectionsHeader) -> Named {
    (header.decimation, header.hamming, header.family_names().map(str::to_owned).collect())
}

/// Publishes the picture until a message of this change, or a later one, comes.
fn heard_of_change(camera: &mut Camera, client: &mut Client, picture: &[u8], number: u64) -> Detections {
    loop {
        let heard = camera.publish_until_heard(picture, client);
        if heard.header().control_number >= number {
            return heard;
        }
    }
}

fn regions_change(region: Option<Region>) -> DetectorChange {
    DetectorChange { region: Some(region), ..DetectorChange::default() }
}

#[test]
fn every_change_takes_effect_between_two_frames_and_no_message_mixes_two() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[7, 42]);
    drop(camera.publish_until_heard(&picture, &mut client));
    let over = AtomicBool::new(false);
    let told = Mutex::new(BTreeMap::new());
    let mut seen: Vec<(u64, Named)> = Vec::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut control = control(&ground);
            let first = control.get().unwrap();
            told.lock().unwrap().insert(first.control_number, parameters_of(&first));
            for round in 0_u32..40 {
                let families = ["tag36h11", "tag25h9", "tag16h5"];
                let change = DetectorChange {
                    decimation: Some([1.0, 1.5, 2.0, 3.0][round as usize % 4]),
                    hamming: Some([None, Some(0), Some(1)][round as usize % 3]),
                    families: Some(
                        families[..1 + round as usize % 3].iter().map(|&name| name.to_owned()).collect(),
                    ),
                    threads: Some(1 + round % 2),
                    ..DetectorChange::default()
                };
                let answer = control.set(&change).unwrap();
                assert_eq!(answer.control_number, u64::from(round) + 1);
                told.lock().unwrap().insert(answer.control_number, parameters_of(&answer));
            }
            over.store(true, Ordering::SeqCst);
        });
        while !over.load(Ordering::SeqCst) {
            camera.publish(&picture);
            while let Some(message) = client.receive(Duration::from_millis(2)).unwrap() {
                seen.push((message.header().control_number, named(message.header())));
            }
        }
    });
    let last = heard_of_change(&mut camera, &mut client, &picture, 40);
    seen.push((last.header().control_number, named(last.header())));
    let told = told.into_inner().unwrap();
    assert!(seen.is_sorted_by_key(|(number, _)| *number));
    assert!(seen.iter().any(|(number, _)| (1..40).contains(number)), "no message came between two changes");
    for (number, parameters) in &seen {
        assert_eq!(told.get(number), Some(parameters), "of change {number}");
    }
    drop((last, client, camera));
    let (_, reports) = service.end();
    let changed = |report: &Report| match report {
        Report::Changed { number, .. } => Some(*number),
        _ => None,
    };
    let changes: Vec<u64> = reports.iter().filter_map(changed).collect();
    assert!(changes.len() >= 10 && changes[..10].iter().copied().eq(1..11), "{changes:?}");
}

/// As [`named`], of an answer.
fn parameters_of(answer: &DetectorAnswer) -> Named {
    let parameters = &answer.parameters;
    let hamming = parameters.hamming.map_or(-1, |bits| bits as i32);
    (parameters.decimation, hamming, parameters.families.clone())
}

#[test]
fn a_change_that_is_not_possible_changes_nothing_and_says_why() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let mut control = control(&ground);
    let before = control.get().unwrap();
    let cases = [
        (DetectorChange { decimation: Some(2.5), ..Default::default() }, "decimation 2.5"),
        (DetectorChange { decimation: Some(f32::NAN), ..Default::default() }, "decimation NaN"),
        (DetectorChange { threads: Some(0), ..Default::default() }, "0 threads"),
        (DetectorChange { threads: Some(65), ..Default::default() }, "1 to 64"),
        (DetectorChange { sharpening: Some(-1.0), ..Default::default() }, "sharpening -1"),
        (DetectorChange { families: Some(vec![]), ..Default::default() }, "no tag family"),
        (DetectorChange { families: Some(vec!["tag36h12".into()]), ..Default::default() }, "tag36h11?"),
        (DetectorChange { families: Some(vec!["36h11".into(); 2]), ..Default::default() }, "named twice"),
        (DetectorChange { ids: Some(vec![(0, u32::MAX)]), ..Default::default() }, "4294967296 ids"),
        // The good half of a change is not made either.
        (DetectorChange { decimation: Some(1.0), threads: Some(99), ..Default::default() }, "99 threads"),
    ];
    let count = cases.len() as u64;
    for (change, expected) in cases {
        let error = control.set(&change).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let after = control.get().unwrap();
    assert_eq!((after.control_number, &after.parameters), (0, &before.parameters));
    assert_eq!(after.statistics.requests_refused, count);
    drop(control);
    service.end();
}

#[test]
fn fewer_corrected_bits_than_asked_for_are_said() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let mut control = control(&ground);
    let answer = control.set(&DetectorChange { hamming: Some(Some(9)), ..Default::default() }).unwrap();
    assert!(answer.text.contains("tag36h11 corrects 5 bits, not 9"), "{}", answer.text);
    drop(control);
    service.end();
}

#[test]
fn a_detector_that_waits_for_its_camera_tells_so_and_obeys() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let mut control = control(&ground);
    let waiting = control.get().unwrap();
    assert_eq!((waiting.state, waiting.frame_size), (DetectorState::WaitingForCamera, None));
    control.set(&DetectorChange { min_margin: Some(3.0), ..Default::default() }).unwrap();
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let heard = camera.publish_until_heard(&picture_of(&[1]), &mut client);
    assert_eq!(heard.header().control_number, 1);
    let answer = control.get().unwrap();
    assert_eq!(answer.frame_size, Some((WIDTH as u32, HEIGHT as u32)));
    assert_eq!(answer.parameters.min_margin, 3.0);
    drop((heard, client, camera, control));
    service.end();
}

#[test]
fn only_the_tags_of_a_region_are_found_and_they_lie_where_they_lie_in_the_frame() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client, mut control) = (ground.camera(), ground.client(), control(&ground));
    let picture = picture_of(&[7, 42]);
    for (decimation, refinement) in [1.0, 1.5, 2.0, 3.0]
        .into_iter()
        .flat_map(|factor| [RefinementChoice::Edges, RefinementChoice::Tag].map(|how| (factor, how)))
    {
        let whole = DetectorChange {
            decimation: Some(decimation),
            refinement: Some(refinement),
            ..regions_change(None)
        };
        let number = control.set(&whole).unwrap().control_number;
        let all = heard_of_change(&mut camera, &mut client, &picture, number);
        assert_eq!((ids_of(&all), all.header().flags & header_flags::REGION), (vec![7, 42], 0));
        let expected = *all.tags().iter().find(|tag| tag.id == 42).unwrap();
        drop(all);
        let region = Region { x: 121, y: 31, width: 1000, height: 103 };
        let number = control.set(&regions_change(Some(region))).unwrap().control_number;
        let part = heard_of_change(&mut camera, &mut client, &picture, number);
        assert_eq!(ids_of(&part), [42], "decimation {decimation}");
        assert_ne!(part.header().flags & header_flags::REGION, 0);
        let tag = part.tags()[0];
        // The same pixels are read from the same grid: only the last bits of the numbers differ.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
        assert!(tag.center.iter().zip(expected.center).all(|(&a, b)| near(a, b)), "{tag:?} {expected:?}");
        let corners = tag.corners.iter().flatten().zip(expected.corners.iter().flatten());
        assert!(corners.into_iter().all(|(&a, &b)| near(a, b)), "{tag:?} {expected:?}");
        assert!(tag.homography.iter().zip(expected.homography).all(|(&a, b)| near(a, b)));
    }
    let outside = Region { x: 320, y: 0, width: 10, height: 10 };
    let error = control.set(&regions_change(Some(outside))).unwrap_err().to_string();
    assert!(error.contains("320,0,10x10") && error.contains("320x240"), "{error}");
    drop((client, camera, control));
    service.end();
}

#[test]
fn a_region_that_no_frame_has_holds_nothing_and_the_next_frame_is_searched_none_the_less() {
    let ground = Ground::new();
    let mut config = ground.config();
    config.region = Some(Region { x: 5000, y: 0, width: 10, height: 10 });
    let service = Service::start(config);
    let (mut camera, mut client, mut control) = (ground.camera(), ground.client(), control(&ground));
    let picture = picture_of(&[7]);
    assert!(camera.publish_until_heard(&picture, &mut client).tags().is_empty());
    let number = control.set(&regions_change(None)).unwrap().control_number;
    assert_eq!(ids_of(&heard_of_change(&mut camera, &mut client, &picture, number)), [7]);
    drop((client, camera, control));
    service.end();
}

#[test]
fn only_the_ids_that_were_asked_for_are_reported_and_families_of_the_start_come_back_by_name() {
    let ground = Ground::new();
    let mut config = ground.config();
    let own = Family::published("tag36h11").unwrap();
    config.families = vec![own, Family::published("tag16h5").unwrap()];
    let service = Service::start(config);
    let (mut camera, mut client, mut control) = (ground.camera(), ground.client(), control(&ground));
    let picture = picture_of(&[7, 42]);
    let ids = DetectorChange { ids: Some(vec![(40, 50), (100, 100)]), ..Default::default() };
    let answer = control.set(&ids).unwrap();
    assert_eq!(answer.parameters.ids, [(40, 50), (100, 100)]);
    let heard = heard_of_change(&mut camera, &mut client, &picture, answer.control_number);
    assert_eq!(ids_of(&heard), [42]);
    assert_ne!(heard.header().flags & header_flags::IDS, 0);
    drop(heard);
    let mut only = |name: &str| {
        let change =
            DetectorChange { families: Some(vec![name.to_owned()]), ids: Some(vec![]), ..Default::default() };
        let number = control.set(&change).unwrap().control_number;
        let heard = heard_of_change(&mut camera, &mut client, &picture, number);
        (ids_of(&heard), named(heard.header()).2)
    };
    assert_eq!(only("tag25h9"), (vec![], vec!["tag25h9".to_owned()]));
    assert_eq!(only("tag36h11"), (vec![7, 42], vec!["tag36h11".to_owned()]));
    drop((client, camera, control));
    service.end();
}

#[test]
fn statistics_begin_anew_and_counters_of_messages_go_on() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client, mut control) = (ground.camera(), ground.client(), control(&ground));
    let picture = picture_of(&[7, 42]);
    for _ in 0..5 {
        drop(camera.publish_until_heard(&picture, &mut client));
    }
    let before = control.get().unwrap().statistics;
    assert!(before.frames_searched >= 5 && before.tags_found >= 10 && before.search_ns > 0, "{before:?}");
    assert_eq!((before.camera_starts, before.since_ns), (1, before.started_ns));
    let after = control.reset_statistics().unwrap().statistics;
    assert_eq!((after.frames_searched, after.tags_found, after.camera_starts), (0, 0, 0));
    assert!(after.since_ns > before.since_ns && after.started_ns == before.started_ns);
    let message = camera.publish_until_heard(&picture, &mut client);
    assert!(message.header().message_number >= 5);
    drop((message, client, camera, control));
    service.end();
}

#[test]
fn a_detector_that_does_not_run_is_named_after_the_deadline() {
    let ground = Ground::new();
    let options = ConnectOptions::in_domain(ground.domain.clone()).deadline(Duration::from_millis(30));
    let error = DetectorControl::connect(&options).map(drop).unwrap_err();
    assert!(matches!(error, ConnectError::Absent { .. }), "{error}");
    assert!(error.to_string().contains("detector main of camera cam0"), "{error}");
    // Also when others who ask hold the topic.
    let service = Service::start(ground.config());
    let other = control(&ground);
    service.end();
    let error = DetectorControl::connect(&options).map(drop).unwrap_err();
    assert!(matches!(error, ConnectError::Absent { .. }), "{error}");
    drop(other);
}

#[test]
fn a_detector_that_ended_is_named_and_one_that_is_started_again_answers_the_same_connection() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let mut control = control(&ground);
    control.set(&DetectorChange { min_margin: Some(1.0), ..Default::default() }).unwrap();
    service.end();
    let error = control.get().unwrap_err();
    assert!(matches!(error, ControlError::Gone { .. }), "{error}");
    let service = Service::start(ground.config());
    let answer = loop {
        match control.get() {
            Err(ControlError::Gone { .. }) => std::thread::sleep(Duration::from_millis(1)),
            answer => break answer.unwrap(),
        }
    };
    assert_eq!(answer.control_number, 0);
    drop(control);
    service.end();
}

#[test]
fn eight_clients_are_answered_and_the_ninth_is_told_that_there_is_no_room() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let mut clients: Vec<_> = (0..8).map(|_| control(&ground)).collect();
    for client in &mut clients {
        client.get().unwrap();
    }
    let error = DetectorControl::connect(&options(&ground.domain)).map(drop).unwrap_err().to_string();
    assert!(error.contains("all places of") && error.contains("control"), "{error}");
    clients.pop();
    control(&ground).get().unwrap();
    drop(clients);
    service.end();
}

#[test]
fn requests_of_any_bytes_are_refused_or_obeyed_and_never_believed() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let bus = Bus::<ipc::Service>::start(&ground.domain, "liar", &Stop::new().unwrap()).unwrap();
    let asker = bus.open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
    let good = DetectorRequest::of(&DetectorAsk::Get).unwrap();
    let mut set = DetectorRequest::of(&DetectorAsk::Set(DetectorChange::default())).unwrap();
    set.mask = u32::MAX;
    let mut families = DetectorRequest { mask: 1 << 9, ..set };
    families.parameters.family_count = u32::MAX;
    let mut bytes = DetectorRequest { mask: 1 << 9, ..set };
    (bytes.parameters.family_count, bytes.parameters.families) = (16, [[0xff; 32]; 16]);
    let mut ids = DetectorRequest { mask: 1 << 10, ..set };
    (ids.parameters.id_count, ids.parameters.ids) = (64, [[9, 1]; 64]);
    let mut number = DetectorRequest { mask: 1, ..set };
    number.parameters.decimation = f32::from_bits(0x7fc0_dead);
    let schema = DetectorRequest { schema: 9, ..good };
    let kind = DetectorRequest { kind: 0xdead_beef, ..good };
    for lie in [DetectorRequest::default(), schema, kind, set, families, bytes, ids, number] {
        let pending = asker.ask(&lie).unwrap();
        let answer = loop {
            match pending.answer().unwrap() {
                Some(reply) => break reply.checked().unwrap(),
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        };
        assert_eq!((answer.outcome, answer.control_number), (Outcome::Refused, 0), "{lie:?}");
        assert!(!answer.text.is_empty());
    }
    drop((asker, bus));
    service.end();
}

#[test]
fn a_flood_of_changes_and_of_clients_that_take_no_answer_does_not_stop_frames() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[7]);
    drop(camera.publish_until_heard(&picture, &mut client));
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for flood in 0..3 {
            let (ground, over) = (&ground, &over);
            scope.spawn(move || {
                let bus = Bus::<ipc::Service>::start(&ground.domain, "flood", &Stop::new().unwrap()).unwrap();
                let asker = bus.open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
                let change = DetectorChange { threads: Some(1 + flood), ..Default::default() };
                let request = DetectorRequest::of(&DetectorAsk::Set(change)).unwrap();
                let mut kept = None;
                while !over.load(Ordering::Relaxed) {
                    // One keeps its request open and never takes the answer, one gives it up at once.
                    if let Ok(pending) = asker.ask(&request) {
                        kept = (flood == 0).then_some(pending);
                    }
                    std::thread::sleep(Duration::from_micros(50));
                }
                drop(kept);
            });
        }
        for _ in 0..50 {
            camera.publish(&picture);
            let last = camera.sequence - 1;
            drop(until(&mut client, |detections| detections.header().sequence == last));
        }
        // A calm client has its turn among them.
        control(&ground).get().unwrap();
        over.store(true, Ordering::Relaxed);
    });
    drop((client, camera));
    service.end();
}

/// Set for the process that dies in the next test; names its domain and root.
const VICTIM: &str = "TAGBUS_TEST_VICTIM";

#[test]
fn a_client_that_dies_with_an_open_request_leaves_the_detector_and_its_place_to_others() {
    if let Ok(place) = std::env::var(VICTIM) {
        die_with_an_open_request(&place);
    }
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[7]);
    let place = format!("{}:{}", ground.domain.name(), ground.domain.root().display());
    for _ in 0..9 {
        let test = "a_client_that_dies_with_an_open_request_leaves_the_detector_and_its_place_to_others";
        let mut victim = Command::new(std::env::current_exe().unwrap());
        victim.args(["--exact", test]).env(VICTIM, &place).stdout(Stdio::null()).stderr(Stdio::null());
        assert!(!victim.status().unwrap().success());
        drop(camera.publish_until_heard(&picture, &mut client));
    }
    let mut control = control(&ground);
    let number = control.set(&DetectorChange { decimation: Some(1.0), ..Default::default() });
    let number = number.unwrap().control_number;
    assert_eq!(heard_of_change(&mut camera, &mut client, &picture, number).header().decimation, 1.0);
    drop((client, camera, control));
    service.end();
}

/// Sends a change and is gone before it can be answered.
fn die_with_an_open_request(place: &str) -> ! {
    let (name, root) = place.split_once(':').unwrap();
    let domain = Domain::with_root(name, root).unwrap();
    let bus = Bus::<ipc::Service>::start(&domain, "victim", &Stop::new().unwrap()).unwrap();
    let asker = bus.open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
    let change = DetectorChange { min_margin: Some(1.0), ..Default::default() };
    let _pending = asker.ask(&DetectorRequest::of(&DetectorAsk::Set(change)).unwrap()).unwrap();
    std::process::abort();
}
