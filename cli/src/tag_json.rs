//! One detected tag in JSON, the same for pictures and for live frames.

use serde::Serialize;
use tagbus_client::TagDetection;
use tagbus_detector::Detection;
use tagbus_family::Family;

/// A tag as scripts read it.
#[derive(Debug, Serialize)]
pub(crate) struct TagJson<'a> {
    family: &'a str,
    id: u32,
    hamming: u32,
    margin: f64,
    center: [f64; 2],
    corners: [[f64; 2]; 4],
    homography: [f64; 9],
    flags: Vec<&'static str>,
}

impl<'a> TagJson<'a> {
    /// A tag of a detector that searches for `families`.
    pub(crate) fn of_detection(detection: &Detection, families: &'a [Family]) -> Self {
        Self {
            family: families[detection.family].name(),
            id: detection.id,
            hamming: detection.hamming,
            margin: rounded(detection.margin.into(), 2),
            center: detection.center.map(pixels),
            corners: detection.corners.map(|corner| corner.map(pixels)),
            homography: detection.homography,
            flags: detection.flags.names().collect(),
        }
    }

    /// A tag of a message.
    pub(crate) fn of_message(tag: &'a TagDetection) -> Self {
        Self {
            family: tag.family(),
            id: tag.id,
            hamming: tag.hamming,
            margin: rounded(tag.margin.into(), 2),
            center: tag.center.map(pixels),
            corners: tag.corners.map(|corner| corner.map(pixels)),
            homography: tag.homography,
            flags: tag.flag_names().collect(),
        }
    }
}

/// A ten-thousandth of a pixel is far below what any detector can tell.
fn pixels(value: f64) -> f64 {
    rounded(value, 4)
}

/// `value` with so many decimals.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_numbers_print_short() {
        assert_eq!(rounded(1.0 / 3.0, 4).to_string(), "0.3333");
        assert_eq!(rounded(-12.345_67, 2).to_string(), "-12.35");
    }

    #[test]
    fn a_tag_of_a_picture_has_the_keys_of_the_contract() {
        let families = [Family::published("tag36h11").unwrap()];
        let detection = Detection {
            family: 0,
            id: 7,
            hamming: 1,
            margin: 61.234,
            relative_margin: 0.9,
            center: [1.000_04, 2.0],
            corners: [[0.5; 2]; 4],
            homography: [1.0 / 3.0; 9],
            flags: tagbus_detector::Flags::TOUCHES_EDGE,
        };
        let json = serde_json::to_string(&TagJson::of_detection(&detection, &families)).unwrap();
        let start =
            r#"{"family":"tag36h11","id":7,"hamming":1,"margin":61.23,"center":[1.0,2.0],"corners":[[0.5,"#;
        assert!(json.starts_with(start), "{json}");
        assert!(
            json.contains("0.3333333333333333,") && json.ends_with(r#""flags":["touches_edge"]}"#),
            "{json}"
        );
    }
}
