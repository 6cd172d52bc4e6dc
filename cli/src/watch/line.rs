//! One line of text a frame, for pipes.

use tagbus_client::{Detections, TagDetection};

use super::hops::{Hops, NAMES};
use super::late::Late;
use crate::units::time;

/// The line of a message.
pub(super) fn of(detections: &Detections, late: Option<Late>) -> String {
    let header = detections.header();
    let hops = Hops::of(detections);
    let tags: Vec<String> = in_order(detections.tags()).into_iter().map(tag).collect();
    format!(
        "frame {}  {}  = {}  dropped {}  {}{}",
        header.sequence,
        hop_list(&hops),
        time(hops.total_us),
        header.skipped,
        if tags.is_empty() { "no tags".to_owned() } else { tags.join("  ") },
        late.map_or_else(String::new, |late| format!("  {late}"))
    )
}

fn hop_list(hops: &Hops) -> String {
    let hops: Vec<String> =
        NAMES.iter().zip(hops.us).map(|(name, us)| format!("{name} {}", time(us))).collect();
    hops.join(" + ")
}

/// By family and id: in the message the surest comes first, which changes from frame to frame.
pub(super) fn in_order(tags: &[TagDetection]) -> Vec<&TagDetection> {
    let mut sorted: Vec<&TagDetection> = tags.iter().collect();
    sorted.sort_by_key(|tag| (tag.family().to_owned(), tag.id));
    sorted
}

fn tag(tag: &TagDetection) -> String {
    let [x, y] = tag.center;
    format!("{}:{} ({x:.1}, {y:.1})", tag.family(), tag.id)
}
