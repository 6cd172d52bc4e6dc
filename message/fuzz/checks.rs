//! What holds for every message whatever its bytes are: nothing here may panic or overflow, and what a check lets through
//! keeps its promises. Run by the fuzz targets beside, and over their corpus by `message/tests/fuzz_corpus.rs`.

use std::fmt::{Debug, Display};
use std::hint::black_box;
use std::mem::size_of;

use iceoryx2::prelude::ZeroCopySend;
use tagbus_message::control::{
    CameraAsk, CameraReply, CameraRequest, DetectorAsk, DetectorParameters, DetectorReply, DetectorRequest,
    Region,
};
use tagbus_message::detection::{DetectionsHeader, MAX_NAMED_FAMILIES, TagDetection};
use tagbus_message::fourcc::Fourcc;
use tagbus_message::frame::{CaptureKind, ClockKind, FrameHeader, FrameLayout, MAX_SIDE, MIN_SIDE};
use tagbus_message::histogram::Histogram;
use tagbus_message::info::CameraInfo;
use tagbus_message::stats::{CameraStats, ClientStats, DetectorStats, Stats};

/// A target's name and what it does with its bytes.
pub(crate) type Check = (&'static str, fn(&[u8]) -> Verdict);

/// Whether the message was taken for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Accepted,
    Refused,
}

/// One for each type of message.
pub(crate) const ALL: [Check; 8] = [
    ("frame", frame),
    ("detections", detections),
    ("camera_info", camera_info),
    ("detector_request", detector_request),
    ("detector_reply", detector_reply),
    ("camera_request", camera_request),
    ("camera_reply", camera_reply),
    ("stats", stats),
];

/// A frame's header, then the length of the payload beside it.
pub(crate) fn frame(bytes: &[u8]) -> Verdict {
    let (header, rest) = split::<FrameHeader>(bytes);
    let payload_len = split::<u64>(rest).0 as usize;
    print(&header);
    print(&header.format());
    print(&(ClockKind::from_code(header.capture_clock), CaptureKind::from_code(header.capture_kind)));
    let verdict = header.validate(payload_len);
    if let Ok(layout) = verdict {
        luma_is_inside(&header, &layout, payload_len);
    }
    told(verdict)
}

/// Every byte of luma lies in the picture, which lies in the payload. Sums are made in 128 bits, so that they are right.
fn luma_is_inside(header: &FrameHeader, layout: &FrameLayout, payload_len: usize) {
    let sides = MIN_SIDE as usize..=MAX_SIDE as usize;
    assert!(sides.contains(&layout.width) && sides.contains(&layout.height), "{layout:?}");
    let row = (layout.width as u128 - 1) * layout.pixel_step as u128;
    assert!(row < layout.row_stride as u128, "rows overlap: {layout:?}");
    let last = layout.offset as u128 + (layout.height as u128 - 1) * layout.row_stride as u128 + row;
    let picture = u128::from(header.data_offset) + u128::from(header.bytes_used);
    assert!(
        last < picture && picture <= payload_len as u128,
        "{layout:?} leaves {header:?} in {payload_len}"
    );
    assert!(layout.offset >= header.data_offset as usize, "{layout:?}");
    let shapes = Fourcc(header.fourcc).planes(layout.width, layout.height).expect("it was accepted");
    assert_eq!(shapes.len(), usize::from(header.plane_count), "{header:?}");
}

/// The header of a message of detections, then a length that it is told, then the tags that are there.
pub(crate) fn detections(bytes: &[u8]) -> Verdict {
    let (header, rest) = split::<DetectionsHeader>(bytes);
    let (told_len, rest) = split::<u64>(rest);
    let tags: Vec<_> =
        rest.chunks(size_of::<TagDetection>()).map(|tag| split::<TagDetection>(tag).0).collect();
    print(&header);
    print(&header.capture_moment());
    assert!(header.family_names().count() <= MAX_NAMED_FAMILIES);
    header.family_names().for_each(|name| print(&name));
    tags.iter().for_each(look_at_tag);
    if let Ok(count) = header.checked(told_len as usize) {
        assert!(count as u64 <= told_len && count as u64 <= u64::from(header.found));
    }
    let verdict = header.checked(tags.len());
    if let Ok(count) = verdict {
        black_box(&tags[..count]);
    }
    told(verdict)
}

fn look_at_tag(tag: &TagDetection) {
    print(tag);
    print(&tag.family());
    print(&tag.flag_names().collect::<Vec<_>>());
}

/// What a camera says about itself. There is no check: every number is one that it may say, and texts are read or not.
pub(crate) fn camera_info(bytes: &[u8]) -> Verdict {
    let (info, _) = split::<CameraInfo>(bytes);
    print(&info);
    print(&(info.camera_state(), info.camera_state().name(), info.source_text(), info.model_text()));
    print(&(Fourcc(info.fourcc), Fourcc(info.source_fourcc)));
    Verdict::Accepted
}

/// What a detector is asked: what is taken is taken again when it is written anew.
pub(crate) fn detector_request(bytes: &[u8]) -> Verdict {
    let (request, _) = split::<DetectorRequest>(bytes);
    print(&request);
    let verdict = request.checked();
    if let Ok(ask) = &verdict {
        print(ask);
        let again = DetectorRequest::of(ask).expect("it came out of a request, so it fits one");
        assert_eq!(again.checked().as_ref(), Ok(ask));
    }
    if let Ok(DetectorAsk::Set(change)) = &verdict {
        numbers_are_finite([change.decimation, change.sharpening, change.min_margin].into_iter().flatten());
        change.region.flatten().iter().for_each(region_is_read_back);
        ranges_are_in_order(change.ids.as_deref().unwrap_or_default());
    }
    told(verdict)
}

/// What a detector answers, as text, too.
pub(crate) fn detector_reply(bytes: &[u8]) -> Verdict {
    let (reply, _) = split::<DetectorReply>(bytes);
    print(&reply);
    let verdict = reply.checked();
    if let Ok(answer) = &verdict {
        print(answer);
        print(&answer.state.name());
        look_at_parameters(&answer.parameters);
        assert_eq!(DetectorReply::of(answer).checked().as_ref(), Ok(answer));
    }
    told(verdict)
}

fn look_at_parameters(parameters: &DetectorParameters) {
    print(&parameters.named());
    numbers_are_finite([parameters.decimation, parameters.sharpening, parameters.min_margin]);
    parameters.region.iter().for_each(region_is_read_back);
    ranges_are_in_order(&parameters.ids);
}

fn numbers_are_finite(numbers: impl IntoIterator<Item = f32>) {
    numbers.into_iter().for_each(|number| assert!(number.is_finite(), "{number}"));
}

fn region_is_read_back(region: &Region) {
    assert_eq!(region.to_string().parse(), Ok(*region));
}

fn ranges_are_in_order(ranges: &[(u32, u32)]) {
    ranges.iter().for_each(|(first, last)| assert!(first <= last, "{first}-{last}"));
}

/// What a camera is asked: what is taken is taken again when it is written anew.
pub(crate) fn camera_request(bytes: &[u8]) -> Verdict {
    let (request, _) = split::<CameraRequest>(bytes);
    print(&request.kind);
    let verdict = request.checked();
    if let Ok(ask) = &verdict {
        print(ask);
        let again = CameraRequest::of(ask).expect("it came out of a request, so it fits one");
        assert_eq!(again.checked().as_ref(), Ok(ask));
    }
    if let Ok(CameraAsk::Set(settings)) = &verdict {
        assert!(settings.len() <= request.controls.len());
    }
    told(verdict)
}

/// What a camera answers, as text, too.
pub(crate) fn camera_reply(bytes: &[u8]) -> Verdict {
    let (reply, _) = split::<CameraReply>(bytes);
    print(&reply.statistics);
    let verdict = reply.checked();
    if let Ok(answer) = &verdict {
        print(answer);
        print(&answer.state.name());
        assert_eq!(CameraReply::of(answer).checked().as_ref(), Ok(answer));
    }
    told(verdict)
}

/// What a role counts about itself: a byte that says which role, then the message.
pub(crate) fn stats(bytes: &[u8]) -> Verdict {
    let (role, rest) = split::<u8>(bytes);
    match role % 3 {
        0 => look_at_stats(&split::<CameraStats>(rest).0),
        1 => look_at_stats(&split::<DetectorStats>(rest).0),
        _ => {
            let stats = split::<ClientStats>(rest).0;
            print(&stats.name());
            look_at_stats(&stats)
        }
    }
}

fn look_at_stats(stats: &impl Stats) -> Verdict {
    print(stats);
    let verdict = stats.checked();
    if verdict.is_ok() {
        let hops = stats.parts().1;
        hops.iter().zip(hops.iter().rev()).for_each(|(hop, other)| look_at_histogram(hop, other));
    }
    told(verdict)
}

fn look_at_histogram(hop: &Histogram, other: &Histogram) {
    for histogram in [*hop, hop.since(other)] {
        assert!(histogram.is_sound(), "{histogram:?}");
        assert_eq!(histogram.quantile_ns(0.5).is_some(), histogram.count > 0);
        assert_eq!(histogram.count_up_to(u64::MAX), histogram.count);
        print(&(histogram.mean_ns(), histogram.quantile_ns(0.0), histogram.quantile_ns(1.0)));
    }
}

/// Writes the text of a refusal, for texts can panic, too.
fn told<T, E: Display + Debug>(verdict: Result<T, E>) -> Verdict {
    match verdict {
        Ok(_) => Verdict::Accepted,
        Err(error) => {
            assert!(!error.to_string().is_empty(), "{error:?} says nothing");
            Verdict::Refused
        }
    }
}

fn print(value: &impl Debug) {
    black_box(format!("{value:?}"));
}

/// A message out of the first bytes, where those that are missing are zero, and the bytes behind it.
fn split<T: ZeroCopySend + Copy>(bytes: &[u8]) -> (T, &[u8]) {
    let (front, rest) = bytes.split_at(bytes.len().min(size_of::<T>()));
    let mut whole = front.to_vec();
    whole.resize(size_of::<T>(), 0);
    // SAFETY: `whole` is as long as T, and the messages of tagbus are integers, floats and arrays of them: any bytes are one.
    (unsafe { whole.as_ptr().cast::<T>().read_unaligned() }, rest)
}
