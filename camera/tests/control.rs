//! A running camera that is asked and told.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on says where")]

mod common;

use std::time::{Duration, Instant};

use common::{Ground, WATCHDOG, receive};
use iceoryx2::prelude::ipc;
use tagbus_camera::{Pace, Source, SourceOptions};
use tagbus_message::bus::Patience;
use tagbus_message::control::{CameraAnswer, CameraAsk, CameraRequest, Outcome};
use tagbus_message::control_ports::CameraAsker;
use tagbus_message::info::CameraState;

fn scene(framerate: f64) -> SourceOptions {
    let pace = Pace::from_framerate(framerate).unwrap();
    SourceOptions { width: Some(64), height: Some(48), pace, ..SourceOptions::default() }
}

fn asker(ground: &Ground) -> CameraAsker<ipc::Service> {
    ground.bus().open_camera_control("cam0", Patience::AtMost(WATCHDOG)).unwrap()
}

fn answer_to(asker: &CameraAsker<ipc::Service>, request: &CameraRequest) -> CameraAnswer {
    let pending = asker.ask(request).unwrap();
    let started = Instant::now();
    loop {
        if let Some(reply) = pending.answer().unwrap() {
            return reply.checked().unwrap();
        }
        assert!(started.elapsed() < WATCHDOG, "no answer came");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn ask(asker: &CameraAsker<ipc::Service>, ask: &CameraAsk) -> CameraAnswer {
    answer_to(asker, &CameraRequest::of(ask).unwrap())
}

#[test]
fn a_camera_tells_its_state_and_counts_its_frames_from_the_last_reset_on() {
    let ground = Ground::new();
    let camera = ground.camera(Source::Scene { seed: 1 }, scene(200.0));
    let frames = ground.bus().open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap();
    for _ in 0..10 {
        receive(&frames);
    }
    let asker = asker(&ground);
    let answer = ask(&asker, &CameraAsk::Get);
    assert_eq!((answer.outcome, answer.state), (Outcome::Done, CameraState::Streaming));
    assert!(answer.statistics.frames >= 10, "{answer:?}");
    assert_eq!(answer.statistics.since_ns, answer.statistics.started_ns);
    let reset = ask(&asker, &CameraAsk::ResetStatistics);
    assert!(reset.statistics.frames == 0 && reset.statistics.since_ns > reset.statistics.started_ns);
    let (header, _) = receive(&frames);
    assert_eq!(header.info_number, answer.info_number);
    drop((frames, asker));
    assert!(camera.stop().frames >= 11);
}

#[test]
fn a_source_without_controls_says_so_and_its_information_does_not_change() {
    let ground = Ground::new();
    let camera = ground.camera(Source::Scene { seed: 1 }, scene(100.0));
    let asker = asker(&ground);
    let before = ask(&asker, &CameraAsk::Get);
    let refused = ask(&asker, &CameraAsk::Set(vec![("gain".into(), "5".into())]));
    assert_eq!((refused.outcome, refused.info_number), (Outcome::Refused, before.info_number));
    assert!(refused.text.contains("without a device"), "{}", refused.text);
    assert!(refused.controls.is_empty());
    assert_eq!(refused.statistics.requests_refused, before.statistics.requests_refused + 1);
    drop(asker);
    camera.stop();
}

#[test]
fn a_camera_that_sleeps_long_between_frames_answers_meanwhile() {
    let ground = Ground::new();
    // One frame in ten minutes.
    let camera = ground.camera(Source::Scene { seed: 1 }, scene(1.0 / 600.0));
    let asker = asker(&ground);
    for _ in 0..3 {
        assert_eq!(ask(&asker, &CameraAsk::Get).outcome, Outcome::Done);
    }
    drop(asker);
    assert_eq!(camera.stop().frames, 1);
}

#[test]
fn a_request_of_any_bytes_is_refused_in_words() {
    let ground = Ground::new();
    let camera = ground.camera(Source::Scene { seed: 1 }, scene(200.0));
    let asker = asker(&ground);
    let mut request = CameraRequest::of(&CameraAsk::Set(vec![("gain".into(), "5".into())])).unwrap();
    request.controls[0].name = [0xff; 48];
    let many = CameraRequest { count: u32::MAX, ..request };
    for (lie, expected) in [
        (request, "UTF-8"),
        (many, "at most 16"),
        (CameraRequest { kind: 77, ..request }, "kind 77"),
        (CameraRequest { schema: 2, ..request }, "version 2"),
        (CameraRequest { count: 0, ..request }, "nothing to set"),
    ] {
        let answer = answer_to(&asker, &lie);
        assert_eq!(answer.outcome, Outcome::Refused);
        assert!(answer.text.contains(expected), "{}", answer.text);
    }
    drop(asker);
    camera.stop();
}
