//! One line of JSON a frame, for scripts.

use serde::Serialize;
use tagbus_client::Detections;

use super::late::Late;
use crate::outcome::Failure;
use crate::tag_json::TagJson;

#[derive(Serialize)]
struct MessageJson<'a> {
    camera: &'a str,
    detector: &'a str,
    camera_epoch: u64,
    detector_epoch: u64,
    frame: u64,
    capture_kind: &'static str,
    capture_ns: u64,
    dequeue_ns: u64,
    publish_ns: u64,
    receive_ns: u64,
    detect_start_ns: u64,
    detect_end_ns: u64,
    send_ns: u64,
    client_ns: u64,
    frames_dropped: u32,
    change: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    late_by_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    late_hop: Option<&'static str>,
    detections: Vec<TagJson<'a>>,
}

/// The line of a message.
pub(super) fn line(
    camera: &str,
    detector: &str,
    detections: &Detections,
    late: Option<Late>,
) -> Result<String, Failure> {
    let header = detections.header();
    let message = MessageJson {
        camera,
        detector,
        camera_epoch: header.epoch,
        detector_epoch: header.detector_epoch,
        frame: header.sequence,
        capture_kind: header.capture_moment().name(),
        capture_ns: header.capture_ns,
        dequeue_ns: header.dequeue_ns,
        publish_ns: header.publish_ns,
        receive_ns: header.receive_ns,
        detect_start_ns: header.detect_start_ns,
        detect_end_ns: header.detect_end_ns,
        send_ns: header.send_ns,
        client_ns: detections.client_ns(),
        frames_dropped: header.skipped,
        change: header.control_number,
        late_by_ms: late.map(|late| late.by_us / 1e3),
        late_hop: late.map(|late| late.hop),
        detections: detections.tags().iter().map(TagJson::of_message).collect(),
    };
    Ok(serde_json::to_string(&message)?)
}
