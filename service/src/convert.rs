//! From the detector's words to those of the message.

use tagbus_detector::{Detection, Settings};
use tagbus_family::Family;
use tagbus_message::control::Region;
use tagbus_message::detection::{
    DETECTIONS_SCHEMA, DetectionsHeader, FAMILY_NAME_BYTES, MAX_NAMED_FAMILIES, TagDetection, header_flags,
    tag_flags,
};
use tagbus_message::frame::FrameHeader;
use tagbus_message::text::{self, TextTooLong};

/// A family's name as it stands in a message.
pub(crate) type FamilyName = [u8; FAMILY_NAME_BYTES];

/// The names of all families, in their order.
pub(crate) fn family_names(families: &[Family]) -> Result<Vec<FamilyName>, TextTooLong> {
    let name = |family: &Family| {
        let mut field = [0; FAMILY_NAME_BYTES];
        text::write(&mut field, family.name()).map(|()| field)
    };
    families.iter().map(name).collect()
}

/// The part of the header that does not change from frame to frame.
pub(crate) fn header_template(
    settings: &Settings,
    names: &[FamilyName],
    region: Option<Region>,
) -> DetectionsHeader {
    let mut families = [[0; FAMILY_NAME_BYTES]; MAX_NAMED_FAMILIES];
    for (field, name) in families.iter_mut().zip(names) {
        *field = *name;
    }
    DetectionsHeader {
        schema: DETECTIONS_SCHEMA,
        flags: [(region.is_some(), header_flags::REGION), (!settings.ids.is_empty(), header_flags::IDS)]
            .into_iter()
            .fold(0, |flags, (is_so, flag)| if is_so { flags | flag } else { flags }),
        decimation: settings.decimation.factor() as f32,
        hamming: settings.hamming.map_or(-1, |bits| i32::try_from(bits).unwrap_or(i32::MAX)),
        family_count: names.len() as u32,
        families,
        ..DetectionsHeader::default()
    }
}

/// The header with what is known of the frame.
pub(crate) fn header_of_frame(template: &DetectionsHeader, frame: &FrameHeader) -> DetectionsHeader {
    DetectionsHeader {
        epoch: frame.epoch,
        sequence: frame.sequence,
        capture_ns: frame.capture_ns,
        capture_clock: frame.capture_clock,
        capture_kind: frame.capture_kind,
        dequeue_ns: frame.dequeue_ns,
        publish_ns: frame.publish_ns,
        width: frame.width,
        height: frame.height,
        info_number: frame.info_number,
        ..*template
    }
}

/// One tag, found in a part of the frame that begins at `origin`. There are no poses yet, and the flags say so.
pub(crate) fn tag(detection: &Detection, names: &[FamilyName], origin: [f64; 2]) -> TagDetection {
    TagDetection {
        family_name: names.get(detection.family).copied().unwrap_or_default(),
        id: detection.id,
        hamming: detection.hamming,
        margin: detection.margin,
        relative_margin: detection.relative_margin,
        center: moved(detection.center, origin),
        corners: detection.corners.map(|corner| moved(corner, origin)),
        homography: moved_homography(&detection.homography, origin),
        flags: detection.flags.0 | tag_flags::NO_POSE_NO_INTRINSICS,
        ..TagDetection::default()
    }
}

fn moved([x, y]: [f64; 2], [left, top]: [f64; 2]) -> [f64; 2] {
    [x + left, y + top]
}

/// The matrix that moves by `origin`, times `h`: its last row, and with it its last element, stays.
fn moved_homography(h: &[f64; 9], [left, top]: [f64; 2]) -> [f64; 9] {
    let moved = |row: usize, by: f64| [0, 1, 2].map(|column| h[3 * row + column] + by * h[6 + column]);
    let ([a, b, c], [d, e, f]) = (moved(0, left), moved(1, top));
    [a, b, c, d, e, f, h[6], h[7], h[8]]
}

/// The tags that fit, by their places in `detections`: all in the detector's order, or the `max_tags` best margins.
pub(crate) fn choose(detections: &[Detection], max_tags: usize, chosen: &mut Vec<usize>) {
    chosen.clear();
    chosen.extend(0..detections.len());
    if detections.len() > max_tags {
        let margin = |&place: &usize| detections[place].margin;
        chosen.sort_unstable_by(|a, b| margin(b).total_cmp(&margin(a)).then(a.cmp(b)));
        chosen.truncate(max_tags);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_detector::Flags;

    fn detection(margin: f32) -> Detection {
        Detection {
            family: 0,
            id: 3,
            hamming: 1,
            margin,
            relative_margin: 0.5,
            center: [1.0, 2.0],
            corners: [[0.0; 2]; 4],
            homography: [0.0; 9],
            flags: Flags(Flags::SMALL.0 | Flags::SATURATED.0),
        }
    }

    #[test]
    fn the_best_margins_are_kept_when_not_all_fit() {
        let detections: Vec<_> = [3.0, 9.0, 1.0, 7.0].map(detection).into();
        let mut chosen = Vec::new();
        choose(&detections, 2, &mut chosen);
        assert_eq!(chosen, [1, 3]);
        choose(&detections, 4, &mut chosen);
        assert_eq!(chosen, [0, 1, 2, 3]);
    }

    #[test]
    fn the_detectors_flags_are_those_of_the_message() {
        let expected = [
            (Flags::TOUCHES_EDGE, tag_flags::TOUCHES_EDGE),
            (Flags::SMALL, tag_flags::SMALL),
            (Flags::DIM, tag_flags::DIM),
            (Flags::SATURATED, tag_flags::SATURATED),
        ];
        assert!(expected.iter().all(|(detector, message)| detector.0 == *message));
        let names: Vec<_> = tag(&detection(1.0), &[], [0.0; 2]).flag_names().collect();
        assert_eq!(names, ["small", "saturated", "no_pose_no_intrinsics"]);
    }

    #[test]
    fn a_moved_homography_leads_to_moved_pixels() {
        let h = [30.0, 2.0, 50.0, -1.0, 28.0, 60.0, 0.01, -0.02, 1.0];
        let at = |h: &[f64; 9], [x, y]: [f64; 2]| {
            let [u, v, w] = [0, 3, 6].map(|row| h[row] * x + h[row + 1] * y + h[row + 2]);
            [u / w, v / w]
        };
        let origin = [100.0, 7.0];
        let moved_h = moved_homography(&h, origin);
        for point in [[-1.0, -1.0], [1.0, -1.0], [0.3, 0.9], [0.0, 0.0]] {
            let (seen, expected) = (at(&moved_h, point), moved(at(&h, point), origin));
            assert!((0..2).all(|axis| (seen[axis] - expected[axis]).abs() < 1e-9), "{seen:?} {expected:?}");
        }
        assert_eq!(moved_h[8], 1.0);
    }
}
