//! Frames published by hand, searched by a service in a thread, received by clients; each test in its own domain.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use common::{Camera, Ground, HEIGHT, Service, WATCHDOG, WIDTH, ids_of, picture_of, until};
use tagbus_client::{Client, ConnectOptions, Detections, FrameClient};
use tagbus_message::detection::{header_flags, tag_flags};
use tagbus_message::frame::{FrameHeader, GREY, MJPG, YUYV};
use tagbus_message::stop::Stop;
use tagbus_service::{Report, Summary, run};

#[test]
fn tags_travel_from_camera_to_client_with_every_stamp_in_order() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let detections = camera.publish_until_heard(&picture_of(&[7, 42]), &mut client);
    assert_eq!(ids_of(&detections), [7, 42]);
    let tag = &detections.tags()[0];
    assert_eq!(tag.family(), "tag36h11");
    assert_ne!(tag.flags & tag_flags::NO_POSE_NO_INTRINSICS, 0);
    let header = detections.header();
    assert_eq!((header.width, header.height, header.count, header.found), (320, 240, 2, 2));
    assert_eq!(header.family_names().collect::<Vec<_>>(), ["tag36h11"]);
    let stamps = [
        header.capture_ns,
        header.dequeue_ns,
        header.publish_ns,
        header.receive_ns,
        header.detect_start_ns,
        header.detect_end_ns,
        header.send_ns,
        detections.client_ns(),
    ];
    assert!(stamps[0] > 0 && stamps.is_sorted(), "{stamps:?}");
    drop((detections, client, camera));
    assert!(service.end().0.frames_searched > 0);
}

#[test]
fn a_frame_without_tags_gives_an_empty_message() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let detections = camera.publish_until_heard(&vec![128; WIDTH * HEIGHT], &mut client);
    assert!(detections.tags().is_empty());
    assert_eq!(detections.header().found, 0);
    drop((detections, client, camera));
    service.end();
}

#[test]
fn the_detector_reads_the_bytes_of_the_received_sample() {
    let ground = Ground::new();
    let seen = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&seen);
    let mut config = ground.config();
    config.observer = Some(Box::new(move |frame| {
        let luma = frame.view.bytes().as_ptr_range();
        assert!(frame.payload.start <= luma.start && luma.end <= frame.payload.end);
        assert!(frame.view.geometry().offset >= frame.header.data_offset as usize);
        counted.fetch_add(1, Ordering::Relaxed);
    }));
    let service = Service::start(config);
    let (mut camera, mut client) = (ground.camera(), ground.client());
    drop(camera.publish_until_heard(&picture_of(&[1]), &mut client));
    drop((client, camera));
    service.end();
    assert!(seen.load(Ordering::Relaxed) > 0);
}

#[test]
fn luma_is_found_in_packed_colour_behind_slack() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    drop(camera.publish_until_heard(&vec![128; WIDTH * HEIGHT], &mut client));
    let mut payload = vec![99; 48];
    payload.extend(picture_of(&[5]).iter().flat_map(|&luma| [luma, 128]));
    let packed = FrameHeader::packed(YUYV, WIDTH as u32, HEIGHT as u32).unwrap();
    camera.publish_with(&payload, FrameHeader { data_offset: 48, ..packed });
    let last = camera.sequence - 1;
    let detections = until(&mut client, |detections| detections.header().sequence == last);
    assert_eq!(ids_of(&detections), [5]);
    drop((detections, client, camera));
    service.end();
}

#[test]
fn headers_that_lie_are_reported_and_skipped_and_work_goes_on() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[3]);
    drop(camera.publish_until_heard(&picture, &mut client));
    let good = FrameHeader::packed(GREY, WIDTH as u32, HEIGHT as u32).unwrap();
    let mut overlapping = good;
    overlapping.planes[0].stride = 100;
    let mut far = good;
    far.planes[0].offset = u32::MAX;
    let lies = [
        FrameHeader { width: 0, ..good },
        FrameHeader { width: 1, height: 1, ..good },
        FrameHeader { width: 16_385, ..good },
        FrameHeader { height: 100_000, ..good },
        FrameHeader { width: u32::MAX, height: u32::MAX, ..good },
        FrameHeader { data_offset: u32::MAX, ..good },
        FrameHeader { bytes_used: u64::MAX, ..good },
        FrameHeader { fourcc: MJPG.0, ..good },
        FrameHeader { fourcc: 0xdead_beef, ..good },
        FrameHeader { schema: 77, ..good },
        FrameHeader::default(),
        overlapping,
        far,
    ];
    for lie in &lies {
        assert_eq!(ids_of(&after_a_lie(&mut camera, &mut client, &picture, *lie)), [3]);
    }
    drop((client, camera));
    let (summary, reports) = service.end();
    assert!(reports.iter().any(|report| matches!(report, Report::Refused { .. })), "{reports:?}");
    assert!(summary.frames_refused >= lies.len() as u64, "{summary:?}");
}

/// Publishes a lie and then the truth until the detector has seen both: only the newest frame is looked at.
fn after_a_lie(camera: &mut Camera, client: &mut Client, picture: &[u8], lie: FrameHeader) -> Detections {
    let mut refused_before = None;
    loop {
        camera.publish(picture);
        let last = camera.sequence - 1;
        let detections = until(client, |detections| detections.header().sequence == last);
        let refused = detections.header().refused_total;
        if refused_before.is_some_and(|before| refused > before) {
            return detections;
        }
        refused_before = Some(refused);
        camera.publish_with(picture, lie);
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_service_that_is_started_again_reaches_the_same_client() {
    let ground = Ground::new();
    let first = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[9]);
    let epoch = camera.publish_until_heard(&picture, &mut client).header().detector_epoch;
    first.end();
    let second = Service::start(ground.config());
    let again = loop {
        let detections = camera.publish_until_heard(&picture, &mut client);
        if detections.header().detector_epoch != epoch {
            break detections;
        }
    };
    assert_eq!(ids_of(&again), [9]);
    drop((again, client, camera));
    second.end();
}

#[test]
fn a_camera_that_is_started_again_reaches_the_same_service() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[11]);
    drop(camera.publish_until_heard(&picture, &mut client));
    drop(camera);
    let mut camera = ground.camera();
    let epoch = camera.epoch;
    let detections = loop {
        let detections = camera.publish_until_heard(&picture, &mut client);
        if detections.header().epoch == epoch {
            break detections;
        }
    };
    assert_eq!(ids_of(&detections), [11]);
    drop((detections, client, camera));
    assert_eq!(service.end().0.camera_starts, 2);
}

#[test]
fn a_full_message_keeps_the_best_and_says_so() {
    let ground = Ground::new();
    let mut config = ground.config();
    config.max_tags = 1;
    let service = Service::start(config);
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let detections = camera.publish_until_heard(&picture_of(&[7, 42]), &mut client);
    assert_eq!((detections.header().count, detections.header().found), (1, 2));
    assert_eq!(detections.tags().len(), 1);
    assert_ne!(detections.header().flags & header_flags::MORE_FOUND, 0);
    drop((detections, client, camera));
    service.end();
}

#[test]
fn skipped_frames_are_counted() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[2]);
    drop(camera.publish_until_heard(&picture, &mut client));
    camera.sequence += 5;
    camera.publish(&picture);
    let last = camera.sequence - 1;
    let detections = until(&mut client, |detections| detections.header().sequence == last);
    assert!(detections.header().skipped >= 5);
    drop((detections, client, camera));
    assert!(service.end().0.frames_skipped >= 5);
}

#[test]
fn a_second_detector_of_one_name_is_refused_and_one_of_another_name_is_not() {
    let ground = Ground::new();
    let first = Service::start(ground.config());
    let client = ground.client();
    let second = run(ground.config(), Stop::new().unwrap());
    let error = second.unwrap_err().to_string();
    assert!(error.contains("a detector named main is already running in domain"), "{error}");
    let mut other = ground.config();
    other.detector = "other".to_owned();
    Service::start(other).end();
    drop(client);
    first.end();
}

#[test]
fn a_service_that_waits_for_its_camera_ends_when_asked() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    drop(ground.client());
    assert_eq!(service.end().0, Summary::default());
}

#[test]
fn a_client_without_detector_says_who_is_missing() {
    let ground = Ground::new();
    let options = ConnectOptions::in_domain(ground.domain.clone()).deadline(Duration::from_millis(30));
    let error = Client::connect(&options).map(drop).unwrap_err().to_string();
    assert!(error.contains("detector main of camera cam0"), "{error}");
    assert!(error.contains(ground.domain.name()), "{error}");
}

#[test]
fn a_client_that_holds_too_much_is_told_and_recovers() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[4]);
    let held = [(); 2].map(|()| camera.publish_until_heard(&picture, &mut client));
    let full = loop {
        camera.publish(&picture);
        match client.receive(Duration::from_millis(20)) {
            Ok(None) => {}
            Ok(Some(_)) => panic!("a third message was lent"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(full.contains("2 messages are held"), "{full}");
    drop(held);
    drop(camera.publish_until_heard(&picture, &mut client));
    assert!(client.latest().is_ok());
    drop((client, camera));
    service.end();
}

#[test]
fn a_viewer_gets_frames_and_skips_those_that_lie() {
    let ground = Ground::new();
    let mut camera = ground.camera();
    let options = ConnectOptions::in_domain(ground.domain.clone()).deadline(WATCHDOG);
    let mut viewer = FrameClient::connect(&options).unwrap();
    let picture = picture_of(&[1]);
    camera.publish_with(&picture, FrameHeader::default());
    camera.publish(&picture);
    let frame = viewer.receive(WATCHDOG).unwrap().unwrap();
    assert_eq!((frame.bytes(), frame.layout().width), (&picture[..], WIDTH));
    assert_eq!(viewer.refused().0, 1);
    drop((frame, viewer, camera));
}

#[test]
fn a_waiting_client_is_woken_by_its_stop_request() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let stop = Stop::new().unwrap();
    let options = ConnectOptions::in_domain(ground.domain.clone()).deadline(WATCHDOG).stop(stop.clone());
    let mut client = Client::connect(&options).unwrap();
    let waiting = std::thread::spawn(move || client.receive(Duration::MAX).map(|message| message.is_none()));
    stop.trigger();
    assert!(waiting.join().unwrap().unwrap());
    service.end();
}

#[test]
fn a_message_may_outlive_its_client_and_nothing_is_left() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let detections = camera.publish_until_heard(&picture_of(&[6]), &mut client);
    drop((client, camera));
    service.end();
    assert_eq!(ids_of(&detections), [6]);
}

#[test]
fn a_topic_that_was_removed_by_force_is_found_again() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[8]);
    drop(camera.publish_until_heard(&picture, &mut client));
    std::fs::remove_dir_all(ground.domain.root().join("services")).unwrap();
    service.end();
    let service = Service::start(ground.config());
    drop(camera);
    let mut camera = ground.camera();
    drop(camera.publish_until_heard(&picture, &mut client));
    drop(camera.publish_until_heard(&picture, &mut ground.client()));
    drop((client, camera));
    service.end();
}

#[test]
fn detection_pauses_while_nobody_subscribes_and_resumes_with_the_next_frame() {
    let ground = Ground::new();
    let (seen, shown) = std::sync::mpsc::channel();
    let mut config = ground.config();
    config.observer = Some(Box::new(move |frame| seen.send(frame.header.sequence).unwrap()));
    let service = Service::start(config);
    let mut camera = ground.camera();
    let mut client = ground.client();
    let picture = picture_of(&[7]);
    camera.publish_until_heard(&picture, &mut client);
    drop(client);
    shown.try_iter().count();
    for _ in 0..20 {
        camera.publish(&picture);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(shown.try_iter().count(), 0, "frames were searched for nobody");
    let mut client = ground.client();
    let sequence = camera.sequence;
    camera.publish(&picture);
    // The topic keeps its last message for those who come late: that comes first.
    let next = until(&mut client, |next| next.header().sequence >= sequence);
    assert_eq!(next.header().sequence, sequence);
    assert_eq!(next.tags().len(), 1);
    drop((next, client));
    let (summary, _) = service.end();
    assert!(summary.frames_unwatched > 0, "{summary:?}");
}

#[test]
fn a_camera_that_is_silent_for_long_is_connected_again_and_its_next_frame_is_searched() {
    let ground = Ground::new();
    let service = Service::start(ground.config());
    let (mut camera, mut client) = (ground.camera(), ground.client());
    let picture = picture_of(&[7]);
    drop(camera.publish_until_heard(&picture, &mut client));
    // Longer than the time after which the connection is made anew.
    std::thread::sleep(Duration::from_secs(4));
    let sequence = camera.sequence;
    while camera.publish_until_heard(&picture, &mut client).header().sequence < sequence {}
    drop(client);
    let (_, reports) = service.end();
    let connected = reports.iter().filter(|report| **report == Report::Connected).count();
    assert_eq!(connected, 1, "users are told of the silence, not of each try: {reports:?}");
    assert!(reports.contains(&Report::Back), "{reports:?}");
}
