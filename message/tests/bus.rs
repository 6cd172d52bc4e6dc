//! Roles coming and going in domains of their own.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use iceoryx2::prelude::{ipc, ipc_threadsafe};
use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::detection::{DETECTIONS_SCHEMA, DetectionsHeader, TagDetection};
use tagbus_message::domain::Domain;
use tagbus_message::frame::{FrameHeader, GREY};
use tagbus_message::info::{CameraInfo, CameraState};
use tagbus_message::qos;
use tagbus_message::stats::CameraStats;
use tagbus_message::stop::Stop;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

/// Long enough for any machine: only a hanging test gets there.
const WATCHDOG: Duration = Duration::from_secs(60);

/// A domain of the test's own; that it was left clean is checked when it is dropped.
struct Ground {
    domain: Domain,
}

impl Ground {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("m{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let root = std::env::temp_dir().join(format!("tb-{name}"));
        Self { domain: Domain::with_root(&name, root).unwrap() }
    }

    fn bus(&self, role: &str) -> Bus<ipc::Service> {
        Bus::start(&self.domain, role, &Stop::new().unwrap()).unwrap()
    }

    fn assert_clean(&self) {
        assert_eq!(self.domain.leftovers().unwrap(), Vec::<String>::new());
        assert!(!self.domain.root().exists(), "the root is still there");
    }
}

impl Drop for Ground {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.assert_clean();
        }
    }
}

#[test]
fn a_frame_arrives_byte_for_byte_with_its_header() {
    let ground = Ground::new();
    let out = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 4096).unwrap();
    let input = ground.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap();
    for sequence in 0..4 {
        let mut loan = out.publisher().loan_slice(64 * 48).unwrap();
        loan.payload_mut().fill(sequence as u8);
        *loan.user_header_mut() = FrameHeader { sequence, ..FrameHeader::packed(GREY, 64, 48).unwrap() };
        loan.send().unwrap();
    }
    out.notify().unwrap();
    let frame = input.newest().unwrap().unwrap();
    assert_eq!(frame.user_header().sequence, 3);
    assert!(frame.user_header().validate(frame.payload().len()).is_ok());
    assert!(frame.payload().iter().all(|&byte| byte == 3));
}

#[test]
fn memory_is_reserved_at_once_and_takes_room_when_it_is_written() {
    let ground = Ground::new();
    let out = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 1 << 20).unwrap();
    let before = out.touched_bytes().unwrap();
    out.publisher().loan_slice(1 << 20).unwrap().send().unwrap();
    let after = out.touched_bytes().unwrap();
    // The pages in which it begins and ends were there for headers.
    assert!(after >= before + (1 << 20) - (16 << 10), "{before} then {after}");
    assert!(out.reserved().bytes() > 30 << 20 && after < out.reserved().bytes() as u64);
}

#[test]
fn both_variants_of_iceoryx2_talk_to_each_other() {
    let ground = Ground::new();
    let out = ground.bus("detector").create_detections("cam0", "main", 8).unwrap();
    let stop = Stop::new().unwrap();
    let bus = Bus::<ipc_threadsafe::Service>::start(&ground.domain, "client", &stop).unwrap();
    let input = bus.open_detections("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
    drop(bus);
    let loan = out.publisher().loan_slice_uninit(1).unwrap();
    let mut loan = loan.write_from_slice(&[TagDetection { id: 7, ..TagDetection::default() }]);
    *loan.user_header_mut() =
        DetectionsHeader { schema: DETECTIONS_SCHEMA, count: 1, found: 1, ..DetectionsHeader::default() };
    loan.send().unwrap();
    let message = input.newest().unwrap().unwrap();
    assert_eq!(message.user_header().checked(message.payload().len()), Ok(1));
    assert_eq!(message.payload()[0].id, 7);
}

#[test]
fn a_waiting_role_is_woken_by_events_and_by_the_stop_request() {
    let ground = Ground::new();
    let out = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap();
    let stop = Stop::new().unwrap();
    let bus = Bus::<ipc::Service>::start(&ground.domain, "viewer", &stop).unwrap();
    let input = bus.open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap();
    let set = WaitSet::new().unwrap();
    let waiter = Waiter::<ipc::Service>::new(&set, &stop, Some(input.bell())).unwrap();
    assert_eq!(waiter.wait(Duration::from_millis(1)).unwrap(), Wake::TimedOut);
    out.notify().unwrap();
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Event);
    assert_eq!(waiter.wait(Duration::from_millis(1)).unwrap(), Wake::TimedOut);
    let other = stop.clone();
    let trigger = std::thread::spawn(move || other.trigger());
    assert_eq!(waiter.wait(WATCHDOG).unwrap(), Wake::Stop);
    trigger.join().unwrap();
}

#[test]
fn a_second_camera_of_one_name_is_refused_in_words() {
    let ground = Ground::new();
    let _first = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap();
    let error = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap_err();
    assert!(matches!(error, BusError::Taken { .. }));
    let text = error.to_string();
    assert!(text.contains("a camera named cam0 is already running in domain"), "{text}");
    assert!(ground.bus("camera cam1").create_frames("cam1", &qos::FRAMES, 64).is_ok());
}

#[test]
fn a_topic_that_never_comes_is_an_error_after_the_deadline_only() {
    let ground = Ground::new();
    let patience = Patience::AtMost(Duration::from_millis(50));
    let error = ground.bus("viewer").open_frames("cam0", 1, patience).unwrap_err();
    assert!(matches!(&error, BusError::Absent { waited, .. } if *waited >= Duration::from_millis(50)));
    assert!(error.to_string().contains("tagbus/v1/cam0/frames"));
}

#[test]
fn a_topic_that_comes_late_is_found() {
    let ground = Ground::new();
    std::thread::scope(|scope| {
        let late =
            scope.spawn(|| ground.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).map(drop));
        std::thread::sleep(Duration::from_millis(30));
        let _camera = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap();
        late.join().unwrap().unwrap();
    });
}

#[test]
fn a_role_that_waits_for_a_topic_stops_when_asked() {
    let ground = Ground::new();
    let stop = Stop::new().unwrap();
    let bus = Bus::<ipc::Service>::start(&ground.domain, "viewer", &stop).unwrap();
    stop.trigger();
    assert!(matches!(bus.open_frames("cam0", 1, Patience::Endless), Err(BusError::Stopped)));
}

#[test]
fn other_settings_of_a_running_topic_are_told_with_both_sides() {
    let ground = Ground::new();
    let few = qos::TopicQos { subscribers: 2, ..qos::FRAMES };
    let _running = ground.bus("camera cam0").create_frames("cam0", &few, 64).unwrap();
    let error = ground.bus("another").create_frames("cam0", &qos::FRAMES, 64).unwrap_err().to_string();
    assert!(error.contains("here: 6 subscribers") && error.contains("there: 2 subscribers"), "{error}");
    assert!(error.contains("camera cam0 (process"), "{error}");
}

#[test]
fn another_layout_of_a_running_topic_is_told_with_both_sides() {
    let ground = Ground::new();
    let stranger = ground.bus("camera of another make");
    let name = "tagbus/v1/cam0/frames".try_into().unwrap();
    let builder = stranger.node().service_builder(&name).publish_subscribe::<[u8]>().user_header::<u64>();
    let _running = builder.create().unwrap();
    let error = ground.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, BusError::Different { .. }), "{text}");
    assert!(text.contains("here: u8 of 1 bytes with tagbus.FrameHeader.v1 of"), "{text}");
    assert!(text.contains("there: u8 of 1 bytes with u64 of 8 bytes"), "{text}");
}

#[test]
fn a_topic_of_another_version_is_told_with_both_versions() {
    let ground = Ground::new();
    let future = ground.bus("camera of the future");
    let name = "tagbus/v2/cam0/frames".try_into().unwrap();
    let _running = future.node().service_builder(&name).publish_subscribe::<[u8]>().create().unwrap();
    let patience = Patience::AtMost(Duration::from_millis(50));
    let viewer = ground.bus("viewer");
    let error = viewer.open_frames("cam0", 1, patience).unwrap_err().to_string();
    assert!(error.contains("tagbus/v1/cam0/frames") && error.contains("tagbus/v2/cam0/frames"), "{error}");
    let error = viewer.open_frames("cam1", 1, patience).unwrap_err();
    assert!(matches!(error, BusError::Absent { .. }), "{error}");
}

#[test]
fn programs_of_another_iceoryx2_in_the_same_domain_are_told_with_both_versions() {
    let ground = Ground::new();
    let other = ground.domain.prefix().replacen("tb010_", "tb011_", 1);
    let trace = std::path::Path::new("/dev/shm").join(format!("{other}1_2.data"));
    std::fs::write(&trace, "x").unwrap();
    let patience = Patience::AtMost(Duration::from_millis(50));
    let error = ground.bus("viewer").open_frames("cam0", 1, patience).unwrap_err().to_string();
    std::fs::remove_file(trace).unwrap();
    assert!(error.contains("iceoryx2 0.11") && error.contains("is of 0.10"), "{error}");
}

#[test]
fn a_late_subscriber_gets_the_last_information() {
    let ground = Ground::new();
    let out = ground.bus("camera cam0").create_info("cam0").unwrap();
    out.publish(&CameraInfo { state: CameraState::Streaming.code(), ..CameraInfo::default() }).unwrap();
    let input = ground.bus("viewer").open_info("cam0", Patience::AtMost(WATCHDOG)).unwrap();
    out.greet_late_subscribers();
    assert_eq!(input.newest().unwrap().unwrap().camera_state(), CameraState::Streaming);
}

#[test]
fn cleaning_an_inhabited_domain_takes_nothing_away() {
    let ground = Ground::new();
    let out = ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap();
    ground.domain.clean_up_if_unused().unwrap();
    let input = ground.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap();
    out.publisher().loan_slice(1).unwrap().send().unwrap();
    assert!(input.newest().unwrap().is_some());
}

#[test]
fn what_the_dead_left_half_made_is_mended() {
    let ground = Ground::new();
    let witness = ground.bus("witness");
    drop(ground.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64).unwrap());
    // The description of a topic whose creator was killed before it was complete.
    let camera = ground.bus("camera cam0");
    let out = camera.create_frames("cam0", &qos::FRAMES, 64).unwrap();
    let descriptions = descriptions_of(&ground.domain);
    drop((out, camera));
    for description in &descriptions {
        std::fs::write(description, "").unwrap();
    }
    assert!(witness.create_frames("cam0", &qos::FRAMES, 64).is_ok());
}

#[test]
fn what_the_dead_left_half_made_of_a_topic_of_the_recorder_is_mended_by_the_next_who_makes_it() {
    let ground = Ground::new();
    let witness = ground.bus("witness");
    let camera = ground.bus("camera cam0");
    let mut out = camera.camera_stats("cam0").unwrap();
    out.publish(&CameraStats::default()).unwrap();
    let description = descriptions_of(&ground.domain).pop().unwrap();
    let text = std::fs::read(&description).unwrap();
    drop((out, camera));
    // Its creator was killed between the description and what it describes: iceoryx2 waits for that as long as there is patience.
    std::fs::write(&description, text).unwrap();
    std::fs::set_permissions(&description, std::fs::Permissions::from_mode(0o400)).unwrap();
    let mut out = witness.camera_stats("cam0").unwrap();
    out.publish(&CameraStats::default()).unwrap();
}

fn descriptions_of(domain: &Domain) -> Vec<PathBuf> {
    let services = std::fs::read_dir(domain.root().join("services")).unwrap();
    services.map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn roles_that_come_and_go_at_once_never_break_the_domain() {
    let ground = Ground::new();
    std::thread::scope(|scope| {
        for thread in 0..3 {
            let ground = &ground;
            scope.spawn(move || {
                for round in 0..6 {
                    let camera = format!("cam{thread}-{round}");
                    let out = ground.bus("camera").create_frames(&camera, &qos::FRAMES, 64).unwrap();
                    let input = ground.bus("viewer").open_frames(&camera, 1, Patience::AtMost(WATCHDOG));
                    out.publisher().loan_slice(1).unwrap().send().unwrap();
                    assert!(input.unwrap().newest().unwrap().is_some());
                }
            });
        }
    });
}

#[test]
fn another_root_of_a_running_domain_is_refused_and_one_of_a_dead_domain_is_not() {
    let ground = Ground::new();
    let other_root = std::env::temp_dir().join(format!("tb-other-{}", ground.domain.name()));
    let other = Domain::with_root(ground.domain.name(), &other_root).unwrap();
    let bus = ground.bus("camera");
    let error = Bus::<ipc::Service>::start(&other, "viewer", bus.stop()).unwrap_err().to_string();
    assert!(error.contains(other_root.to_str().unwrap()), "{error}");
    drop(bus);
    drop(Bus::<ipc::Service>::start(&other, "viewer", &Stop::new().unwrap()).unwrap());
}
