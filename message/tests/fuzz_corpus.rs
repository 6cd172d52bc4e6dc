//! The corpus that fuzzing has collected (`message/fuzz`), run through the checks of its targets.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on says where")]
#![allow(
    unsafe_code,
    reason = "a message is made of raw bytes, as shared memory does, and a seed of a message"
)]

#[path = "../fuzz/checks.rs"]
mod checks;

use std::mem::size_of;
use std::path::{Path, PathBuf};
use std::{fs, slice};

use checks::Verdict;
use iceoryx2::prelude::ZeroCopySend;
use tagbus_message::control::{
    CameraAnswer, CameraAsk, CameraReply, CameraRequest, CameraStatistics, DetectorAnswer, DetectorAsk,
    DetectorChange, DetectorParameters, DetectorReply, DetectorRequest, DetectorState, DetectorStatistics,
    DeviceControl, Outcome, RefinementChoice, Region, SamplingChoice, SearchChoice,
};
use tagbus_message::detection::{DETECTIONS_SCHEMA, DetectionsHeader, TagDetection};
use tagbus_message::frame::{FrameHeader, GREY, NV12, NV21, UYVY, YU12, YUYV};
use tagbus_message::histogram::Histogram;
use tagbus_message::info::{CameraInfo, CameraState};
use tagbus_message::stats::{CameraStats, ClientStats, DetectorStats};
use tagbus_message::text;

/// A corpus stays small enough to be committed: more is left to who fuzzes.
const MAX_FILES: usize = 100;
const MAX_BYTES: u64 = 8192;

fn folder(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target)
}

fn inputs(target: &str) -> Vec<Vec<u8>> {
    let files = fs::read_dir(folder(target)).unwrap_or_else(|error| panic!("corpus of {target}: {error}"));
    files.map(|file| fs::read(file.unwrap().path()).unwrap()).collect()
}

#[test]
fn every_input_of_the_corpus_is_survived_and_each_target_has_one_that_is_accepted() {
    for (target, check) in checks::ALL {
        let verdicts: Vec<_> = inputs(target).iter().map(|bytes| check(bytes)).collect();
        assert!(verdicts.contains(&Verdict::Accepted), "nothing of {target} comes through its check");
        let can_refuse = target != "camera_info";
        assert_eq!(verdicts.contains(&Verdict::Refused), can_refuse, "what {target} refuses");
    }
}

#[test]
fn every_target_has_a_corpus_and_it_is_small() {
    for (target, _) in checks::ALL {
        let sizes: Vec<_> = inputs(target).iter().map(|bytes| bytes.len() as u64).collect();
        assert!(
            (1..=MAX_FILES).contains(&sizes.len()),
            "{target}: {} files, at most {MAX_FILES}",
            sizes.len()
        );
        assert!(
            sizes.iter().all(|&size| size <= MAX_BYTES),
            "{target}: {sizes:?}, at most {MAX_BYTES} bytes each"
        );
    }
}

/// Messages cut short anywhere are what a wrong length makes of them.
#[test]
fn messages_that_are_cut_anywhere_are_survived() {
    for (target, bytes) in seeds() {
        let (_, check) = checks::ALL.into_iter().find(|(name, _)| *name == target).unwrap();
        assert_eq!(check(&bytes), Verdict::Accepted, "{target}");
        for len in 0..bytes.len() {
            check(&bytes[..len]);
        }
    }
}

/// Bytes that a fuzzer would need luck to meet are where it begins: a good message of every kind is in the corpus, of the length that it
/// has now. Where this fails because a message is new or has a new layout, the file has to be made; one that would do is left in the
/// temporary directory.
#[test]
fn the_corpus_of_every_target_begins_with_good_messages() {
    for (number, (target, bytes)) in seeds().into_iter().enumerate() {
        let (_, check) = checks::ALL.into_iter().find(|(name, _)| *name == target).unwrap();
        let seed = folder(target).join(format!("seed-{number:02}"));
        let is_good = |there: &Vec<u8>| there.len() == bytes.len() && check(there) == Verdict::Accepted;
        if fs::read(&seed).is_ok_and(|there| is_good(&there)) {
            continue;
        }
        let made = std::env::temp_dir().join(format!("{target}-seed-{number:02}"));
        fs::write(&made, &bytes).unwrap();
        panic!("{} is no good message: move {} there", seed.display(), made.display());
    }
}

/// Good messages of every type.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let mut all = Vec::new();
    for format in [GREY, NV12, NV21, YU12, YUYV, UYVY] {
        let header = FrameHeader::packed(format, 33, 17).unwrap();
        all.push(("frame", [bytes_of(&header), header.bytes_used.to_le_bytes().to_vec()].concat()));
    }
    all.push(("detections", detections()));
    all.push(("camera_info", bytes_of(&info())));
    for ask in [DetectorAsk::Get, DetectorAsk::ResetStatistics, DetectorAsk::Set(change())] {
        all.push(("detector_request", bytes_of(&DetectorRequest::of(&ask).unwrap())));
    }
    all.push(("detector_reply", bytes_of(&DetectorReply::of(&detector_answer()))));
    let settings = vec![("gain".to_owned(), "50".to_owned()), ("auto_exposure".into(), "manual".into())];
    for ask in [CameraAsk::Get, CameraAsk::ResetStatistics, CameraAsk::Set(settings)] {
        all.push(("camera_request", bytes_of(&CameraRequest::of(&ask).unwrap())));
    }
    all.push(("camera_reply", bytes_of(&CameraReply::of(&camera_answer()))));
    all.extend(stats().map(|bytes| ("stats", bytes)));
    all
}

/// A byte that says which role, and its message without the zeros at its end.
fn stats() -> [Vec<u8>; 3] {
    let hop = |durations_ns: &[u64]| {
        let mut hop = Histogram::default();
        durations_ns.iter().for_each(|&duration_ns| hop.count(duration_ns));
        hop
    };
    let camera = CameraStats { hops: [hop(&[8_000_000, 9_000_000]), hop(&[30_000])], ..Default::default() };
    let mut detector = DetectorStats::default();
    detector.hops[0] = hop(&[20_000, 25_000]);
    let mut client =
        ClientStats { received: 2, hops: [hop(&[40_000]), hop(&[9_000_000])], ..Default::default() };
    text::write_cut(&mut client.name, "watch");
    let messages = [bytes_of(&camera), bytes_of(&detector), bytes_of(&client)];
    [0, 1, 2].map(|role| {
        let end = messages[role].iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
        [&[role as u8], &messages[role][..end]].concat()
    })
}

fn detections() -> Vec<u8> {
    let (schema, count, found) = (DETECTIONS_SCHEMA, 2, 2);
    let mut header = DetectionsHeader { schema, count, found, family_count: 1, ..Default::default() };
    text::write(&mut header.families[0], "tag36h11").unwrap();
    let mut tag = TagDetection { id: 3, flags: 5, ..Default::default() };
    text::write(&mut tag.family_name, "tag36h11").unwrap();
    [bytes_of(&header), 2_u64.to_le_bytes().to_vec(), bytes_of(&tag), bytes_of(&tag)].concat()
}

fn info() -> CameraInfo {
    let mut info = CameraInfo { state: CameraState::Streaming.code(), fourcc: GREY.0, ..Default::default() };
    text::write(&mut info.source, "scene:").unwrap();
    text::write(&mut info.model, "drawn scene").unwrap();
    info
}

fn change() -> DetectorChange {
    DetectorChange {
        decimation: Some(1.5),
        sampling: Some(SamplingChoice::Darkest),
        search: Some(SearchChoice::Fine),
        threads: Some(4),
        hamming: Some(Some(1)),
        refinement: Some(RefinementChoice::Tag),
        sharpening: Some(0.25),
        min_margin: Some(3.0),
        region: Some(Some(Region { x: 1, y: 2, width: 300, height: 400 })),
        families: Some(vec!["tag36h11".into(), "my-own".into()]),
        ids: Some(vec![(1, 20), (33, 33)]),
    }
}

fn detector_answer() -> DetectorAnswer {
    DetectorAnswer {
        outcome: Outcome::Refused,
        text: "decimation 7.5 is not possible".into(),
        control_number: 9,
        state: DetectorState::Detecting,
        frame_size: Some((640, 480)),
        parameters: DetectorParameters {
            decimation: 2.0,
            sampling: SamplingChoice::Point,
            search: SearchChoice::Quick,
            threads: 1,
            hamming: None,
            refinement: RefinementChoice::Edges,
            sharpening: 1.0,
            min_margin: 0.0,
            region: Some(Region { x: 0, y: 0, width: 320, height: 240 }),
            families: vec!["tag36h11".into()],
            ids: vec![(3, 5)],
        },
        statistics: DetectorStatistics { frames_searched: 5, ..DetectorStatistics::default() },
    }
}

fn camera_answer() -> CameraAnswer {
    let gain =
        |value| DeviceControl { name: "gain".into(), min: 0, max: 99, default: 1, value, inactive: false };
    CameraAnswer {
        outcome: Outcome::Done,
        text: "gain 50".into(),
        info_number: 4,
        state: CameraState::Streaming,
        controls: vec![gain(Some(50)), gain(None)],
        statistics: CameraStatistics { frames: 9, ..CameraStatistics::default() },
    }
}

fn bytes_of<T: ZeroCopySend + Copy>(message: &T) -> Vec<u8> {
    let start = std::ptr::from_ref(message).cast::<u8>();
    // SAFETY: `message` is size_of::<T> bytes long, and the messages of tagbus have no gaps between their fields.
    unsafe { slice::from_raw_parts(start, size_of::<T>()) }.to_vec()
}
