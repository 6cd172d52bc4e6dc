//! One line of text a frame, for pipes.

use tagbus_client::{Detections, TagDetection};

use super::hops::{Hops, NAMES, short};

/// The line of a message.
pub(super) fn of(detections: &Detections) -> String {
    let header = detections.header();
    let hops = Hops::of(detections);
    let tags: Vec<String> = detections.tags().iter().map(tag).collect();
    format!(
        "frame {}  {}  = {}  dropped {}  {}",
        header.sequence,
        hop_list(&hops),
        short(hops.total_us),
        header.skipped,
        if tags.is_empty() { "no tags".to_owned() } else { tags.join("  ") }
    )
}

fn hop_list(hops: &Hops) -> String {
    let hops: Vec<String> =
        NAMES.iter().zip(hops.us).map(|(name, us)| format!("{name} {}", short(us))).collect();
    hops.join(" + ")
}

fn tag(tag: &TagDetection) -> String {
    let [x, y] = tag.center;
    format!("{}:{} ({x:.1}, {y:.1})", tag.family(), tag.id)
}
