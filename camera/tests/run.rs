//! Cameras on a bus of their own, seen by a subscriber.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on says where")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{Ground, WATCHDOG, receive};
use tagbus_camera::{CameraError, CameraEvent, Ending, Pace, Repeat, Source, SourceOptions};
use tagbus_message::bus::{BusError, Patience};
use tagbus_message::frame::{CaptureKind, FrameHeader, NV12};
use tagbus_message::info::CameraState;
use tagbus_scene::{Scene, SceneConfig};

fn pgm(folder: &Ground, name: &str, value: u8, width: usize, height: usize) -> PathBuf {
    let pixels = vec![value; width * height];
    folder.file(name, &[format!("P5\n{width} {height}\n255\n").as_bytes(), &pixels].concat())
}

fn paced(framerate: f64, repeat: Repeat) -> SourceOptions {
    SourceOptions { pace: Pace::from_framerate(framerate).unwrap(), repeat, ..SourceOptions::default() }
}

#[test]
fn frames_of_the_scene_arrive_as_it_renders_them_with_rising_numbers_and_stamps() {
    let ground = Ground::new();
    let options = SourceOptions { width: Some(160), height: Some(120), ..paced(200.0, Repeat::Loop) };
    let camera = ground.camera(Source::Scene { seed: 3 }, options);
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    let config = SceneConfig { width: 160, height: 120, framerate: 200.0, seed: 3, ..SceneConfig::default() };
    let scene = Scene::new(config).unwrap();
    let mut expected = vec![0; 160 * 120];
    let mut last: Option<FrameHeader> = None;
    for _ in 0..20 {
        let (header, picture) = receive(&frames);
        scene.render(header.sequence, &mut expected);
        assert!(picture == expected, "frame {} is not the scene's", header.sequence);
        assert_eq!((header.copies, header.capture_kind), (0, CaptureKind::Dequeue.code()));
        assert!(header.capture_ns == header.dequeue_ns && header.dequeue_ns <= header.publish_ns);
        assert_eq!(header.frame_time_ns, 5_000_000);
        if let Some(last) = last {
            assert!(header.sequence > last.sequence && header.epoch == last.epoch);
            assert!(header.publish_ns > last.publish_ns);
        }
        last = Some(header);
    }
    let summary = camera.stop();
    assert!(summary.frames >= 20 && summary.ending == Ending::Stopped, "{summary:?}");
}

#[test]
fn a_single_pass_over_a_folder_ends_by_itself_and_says_so() {
    let ground = Ground::new();
    pgm(&ground, "10.pgm", 10, 16, 16);
    pgm(&ground, "2.pgm", 2, 40, 8);
    ground.file("5.pgm", b"P5\n16 16\n255\ncut");
    let bus = ground.bus();
    let camera = ground.camera(Source::Replay(ground.folder.clone()), paced(1.0, Repeat::Once));
    let info = bus.open_info("cam0", Patience::AtMost(WATCHDOG)).unwrap();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    // One frame a second: whoever comes late has the first from the history, and the second is still to come.
    let summary = camera.end().unwrap();
    assert_eq!((summary.frames, summary.damaged, summary.ending), (2, 1, Ending::SourceEnded));
    let (header, picture) = receive(&frames);
    let (header, picture) = if header.sequence == 0 { receive(&frames) } else { (header, picture) };
    assert_eq!((header.sequence, header.lost_damaged, header.copies), (2, 1, 1));
    assert_eq!((header.width, header.height, picture), (16, 16, vec![10; 256]));
    let info = info.newest().unwrap().unwrap();
    assert_eq!((info.camera_state(), info.epoch), (CameraState::Ended, header.epoch));
    assert_eq!((info.width, info.height, info.model_text()), (40, 8, "folder of pictures"));
    assert!(camera.events.try_iter().any(|event| matches!(event, CameraEvent::Skipped { count: 1, .. })));
}

#[test]
fn a_raw_file_in_a_loop_arrives_byte_for_byte_in_its_own_format() {
    let ground = Ground::new();
    let content: Vec<u8> = (0..3 * 384).map(|index| (index % 251) as u8).collect();
    let path = ground.file("frames.nv12", &content);
    let options =
        SourceOptions { width: Some(16), height: Some(16), format: Some(NV12), ..paced(200.0, Repeat::Loop) };
    let camera = ground.camera(Source::Replay(path), options);
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    for _ in 0..7 {
        let (header, picture) = receive(&frames);
        assert_eq!((header.format(), header.plane_count, header.copies), (NV12, 2, 0));
        let start = (header.sequence % 3) as usize * 384;
        assert!(picture == content[start..][..384], "frame {}", header.sequence);
    }
    camera.stop();
}

#[test]
fn a_video_arrives_as_its_decoded_luma_though_frames_of_it_are_cut() {
    let Some(data) = std::env::var_os("TAGBUS_TEST_DATA") else {
        eprintln!("SKIPPED: TAGBUS_TEST_DATA is not set");
        return;
    };
    let ground = Ground::new();
    let video = fs::read(Path::new(&data).join("real/raw/libvpl__cars_320x240.mjpeg")).unwrap();
    let second = 3 + video[3..].windows(3).position(|bytes| bytes == [0xFF, 0xD8, 0xFF]).unwrap();
    let first = tagbus_camera::picture::load_grey(ground.file("first.jpg", &video[..second])).unwrap();
    // Whole, cut, whole: again and again.
    let path = ground.file("cut.mjpeg", &[&video[..second], &video[..second / 2], &video[..second]].concat());
    let camera = ground.camera(Source::Replay(path), paced(100.0, Repeat::Loop));
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 2, Patience::AtMost(WATCHDOG)).unwrap();
    for _ in 0..6 {
        let (header, picture) = receive(&frames);
        assert!(picture == first.luma, "frame {}", header.sequence);
        assert_eq!(
            u64::from(header.lost_damaged),
            u64::from(header.sequence % 3 == 2),
            "frame {}",
            header.sequence
        );
    }
    camera.stop();
}

#[test]
fn a_stop_wakes_a_camera_that_waits_for_a_frame_due_in_eleven_days() {
    let ground = Ground::new();
    let path = pgm(&ground, "one.pgm", 1, 8, 8);
    let camera = ground.camera(Source::Replay(path), paced(1e-6, Repeat::Loop));
    let started = camera.events.recv_timeout(WATCHDOG).unwrap();
    assert!(matches!(started, CameraEvent::Started { .. }), "{started}");
    // The first frame is due at once, so that the camera sleeps when a subscriber has it.
    let bus = ground.bus();
    let info = bus.open_info("cam0", Patience::AtMost(WATCHDOG)).unwrap();
    drop(info);
    assert!(camera.stop().frames <= 1);
}

#[test]
fn as_fast_as_possible_publishes_a_whole_pass_at_once() {
    let ground = Ground::new();
    let path = ground.file("frames", &[7; 64 * 500]);
    let options = SourceOptions {
        width: Some(8),
        height: Some(8),
        format: Some(tagbus_message::frame::GREY),
        pace: Pace::AsFastAsPossible,
        repeat: Repeat::Once,
        ..SourceOptions::default()
    };
    let summary = ground.camera(Source::Replay(path), options).end().unwrap();
    assert_eq!((summary.frames, summary.ending), (500, Ending::SourceEnded));
}

#[test]
fn a_second_camera_of_the_same_name_is_refused_and_the_first_goes_on() {
    let ground = Ground::new();
    let path = pgm(&ground, "one.pgm", 1, 8, 8);
    let first = ground.camera(Source::Replay(path.clone()), paced(100.0, Repeat::Loop));
    assert!(matches!(first.events.recv_timeout(WATCHDOG).unwrap(), CameraEvent::Started { .. }));
    let refused = ground.camera(Source::Replay(path), paced(100.0, Repeat::Loop)).end().unwrap_err();
    assert!(matches!(refused, CameraError::Bus(BusError::Taken { .. })), "{refused}");
    assert!(refused.to_string().contains("cam0"), "{refused}");
    let bus = ground.bus();
    let frames = bus.open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap();
    let (before, _) = receive(&frames);
    let (after, _) = receive(&frames);
    assert!(after.sequence > before.sequence);
    first.stop();
}

#[test]
fn a_source_that_cannot_be_opened_never_comes_onto_the_bus() {
    let ground = Ground::new();
    let refused =
        ground.camera(Source::Replay("/no/such/path".into()), SourceOptions::default()).end().unwrap_err();
    assert!(matches!(refused, CameraError::Open(_)), "{refused}");
    assert!(!ground.domain.root().exists());
}
