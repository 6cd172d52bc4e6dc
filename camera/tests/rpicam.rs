//! The rpicam source with a stand-in for the program: a script that does everything a program can do to its reader.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on says where")]

mod common;

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use common::{Ground, WATCHDOG, receive};
use tagbus_camera::{CameraEvent, Ending, Pace, Source, SourceOptions, Transfer};
use tagbus_message::bus::Patience;
use tagbus_message::frame::{CaptureKind, GREY};
use tagbus_message::info::CameraState;

/// What the stand-in begins with: it writes down what it was told, counts its starts, and can write frames.
const HEAD: &str = r#"#!/bin/sh
folder=$(dirname "$0")
echo "$@" >"$folder/told"
echo start >>"$folder/starts"
starts=$(wc -l <"$folder/starts")
# frame VALUE: 64x16 pixels of luma with this value (three octal digits), and chroma of another.
frame() {
    head -c 1024 /dev/zero | tr '\0' "\\$1"
    head -c 512 /dev/zero | tr '\0' '\377'
}
"#;

/// Written by a process of its own: a script that is open for writing cannot be run, and another test's child could inherit it so.
fn stand_in(ground: &Ground, script: &str) -> PathBuf {
    let path = ground.folder.join("stand-in");
    let mut shell = Command::new("sh");
    shell.args(["-c", r#"printf %s "$1" >"$0" && chmod 755 "$0""#]).arg(&path).arg(format!("{HEAD}{script}"));
    assert!(shell.status().unwrap().success());
    path
}

fn options() -> SourceOptions {
    SourceOptions {
        width: Some(64),
        height: Some(16),
        pace: Pace::Framerate(50.0),
        controls: "shutter=5000".parse().unwrap(),
        ..SourceOptions::default()
    }
}

#[test]
fn a_program_that_stalls_dies_and_breaks_off_is_started_again_and_no_frame_is_torn() {
    let ground = Ground::new();
    let program = stand_in(
        &ground,
        "case $starts in
        1) frame 011; exec sleep 1000 ;;
        2) frame 022; echo 'the sensor is gone' >&2; exit 3 ;;
        3) frame 033; head -c 700 /dev/zero; exit 0 ;;
        *) while frame 044; do sleep 0.02; done ;;
        esac",
    );
    let camera = ground.camera(Source::Rpicam(Some(program)), options());
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    let mut values = Vec::new();
    let mut last_sequence = None;
    while values.last() != Some(&0o44) {
        let (header, picture) = receive(&frames);
        assert!(picture.iter().all(|value| *value == picture[0]), "a frame of two");
        assert_eq!((header.format(), header.copies, picture.len()), (GREY, 1, 1024));
        assert_eq!(header.capture_kind, CaptureKind::Dequeue.code());
        assert!(last_sequence < Some(header.sequence), "numbers go on over a start");
        last_sequence = Some(header.sequence);
        values.push(picture[0]);
    }
    // A subscriber that is late misses the first ones.
    assert!(
        values.is_sorted() && values.iter().all(|value| [0o11, 0o22, 0o33, 0o44].contains(value)),
        "{values:?}"
    );
    let summary = camera.stop();
    assert_eq!((summary.damaged, summary.ending), (1, Ending::Stopped));
    let told = fs::read_to_string(ground.folder.join("told")).unwrap();
    assert!(told.contains("--width 64 --height 16 --framerate 50 --shutter 5000"), "{told}");
    let events: Vec<CameraEvent> = camera.events.try_iter().collect();
    let texts: Vec<String> = events.iter().map(ToString::to_string).collect();
    for words in [
        "waiting: no frame for",
        "exit status: 3); its last words: the sensor is gone",
        "700 bytes into a frame",
    ] {
        assert!(texts.iter().any(|text| text.contains(words)), "{words}: {texts:?}");
    }
    let opened =
        events.iter().filter(|event| matches!(event, CameraEvent::Opened { transfer: Transfer::Piped, .. }));
    assert_eq!(opened.count(), 4, "{texts:?}");
}

#[test]
fn the_state_says_that_the_program_is_waited_for() {
    let ground = Ground::new();
    let program = stand_in(&ground, "frame 011; [ $starts = 1 ] || exec sleep 1000");
    let camera = ground.camera(Source::Rpicam(Some(program)), options());
    let bus = ground.bus();
    let info = bus.open_info("cam0", Patience::AtMost(WATCHDOG)).unwrap();
    let waits =
        |event: &CameraEvent| matches!(event, CameraEvent::Interrupted { state: CameraState::Waiting, .. });
    while !waits(&camera.events.recv_timeout(WATCHDOG).unwrap()) {}
    // A subscriber that came late is told within a second; the second start of the stand-in brings no frame.
    let started = Instant::now();
    while info.newest().unwrap().map(|info| info.camera_state()) != Some(CameraState::Waiting) {
        assert!(started.elapsed() < WATCHDOG, "the state is not said");
        thread::sleep(Duration::from_millis(10));
    }
    camera.stop();
    assert_eq!(info.newest().unwrap().unwrap().camera_state(), CameraState::Ended);
}

#[test]
fn a_program_that_never_works_ends_the_camera_with_its_last_words() {
    let ground = Ground::new();
    let program = stand_in(&ground, "echo 'ERROR: *** no cameras available ***' >&2; exit 255");
    let error = ground.camera(Source::Rpicam(Some(program)), options()).end().unwrap_err().to_string();
    assert!(error.contains("no frame came") && error.contains("no cameras available"), "{error}");
    let missing = Source::Rpicam(Some("/no/such/rpicam-vid".into()));
    let error = ground.camera(missing, options()).end().unwrap_err().to_string();
    assert!(error.contains("/no/such/rpicam-vid: there is no such program"), "{error}");
}
