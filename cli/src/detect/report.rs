//! What is said about a picture.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use serde_json::{Map, Value};
use tagbus_camera::picture::Picture;
use tagbus_detector::Detection;
use tagbus_family::Family;

use super::measure::Measured;
use crate::outcome::Failure;
use crate::output::Reader;
use crate::tag_json::{TagJson, rounded};

/// A searched picture.
pub(super) struct Report<'a> {
    pub(super) path: &'a Path,
    pub(super) picture: &'a Picture,
    pub(super) measured: &'a Measured,
    pub(super) families: &'a [Family],
}

#[derive(Serialize)]
struct PictureJson<'a> {
    image: String,
    width: usize,
    height: usize,
    detect_us: Vec<f64>,
    cpu_us: Vec<f64>,
    stages_us: Map<String, Value>,
    detections: Vec<TagJson<'a>>,
}

impl Report<'_> {
    /// One line for scripts.
    pub(super) fn json(&self) -> Result<String, Failure> {
        let Self { path, picture, measured, families } = self;
        let tag = |detection| TagJson::of_detection(detection, families);
        let stage = |(name, time): (&str, Duration)| (name.to_owned(), microseconds(time).into());
        let json = PictureJson {
            image: path.display().to_string(),
            width: picture.width,
            height: picture.height,
            detect_us: measured.detect.iter().copied().map(microseconds).collect(),
            cpu_us: measured.cpu.iter().copied().map(microseconds).collect(),
            stages_us: measured.named_phases().map(stage).collect(),
            detections: measured.detections.iter().map(tag).collect(),
        };
        Ok(serde_json::to_string(&json)?)
    }

    /// A line for the picture and a line for each tag.
    pub(super) fn text(&self) -> String {
        let count = match self.measured.detections.len() {
            1 => "1 tag".to_owned(),
            count => format!("{count} tags"),
        };
        let head = format!(
            "{}  {}x{}  {:.2} ms  {count}",
            Reader::of_stdout().bold(&self.path.display().to_string()),
            self.picture.width,
            self.picture.height,
            microseconds(self.measured.median()) / 1e3,
        );
        let tags = self.measured.detections.iter().map(|detection| self.tag_line(detection));
        [head].into_iter().chain(tags).collect::<Vec<_>>().join("\n")
    }

    fn tag_line(&self, detection: &Detection) -> String {
        let Detection { id, hamming, margin, center: [x, y], .. } = detection;
        let flags: Vec<&str> = detection.flags.names().collect();
        let line = format!(
            "  {:<16} id {id:<5}  at {x:7.1} {y:7.1}  {hamming} corrected  margin {margin:5.1}  {}",
            self.families[detection.family].name(),
            flags.join(" ")
        );
        line.trim_end().to_owned()
    }
}

fn microseconds(time: Duration) -> f64 {
    rounded(time.as_secs_f64() * 1e6, 1)
}
