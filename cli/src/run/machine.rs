//! A whole machine as its configuration file describes it.
//!
//! ```toml
//! domain = "robot"                # keys outside of all tables hold for every camera and detector
//! family = "tag36h11"
//!
//! [cameras.front]
//! source = "v4l:/dev/video0"
//! [cameras.front.detectors.near]  # without such a table a camera has one detector, main
//! decimate = 1
//! process = "vision"              # detectors that name the same process share it, a thread each
//!
//! [cameras.rear]
//! source = "rpicam"
//! ```

use std::collections::BTreeMap;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_detector::{Detector, SettingsError};
use tagbus_family::Family;
use toml::{Table, Value};

use super::RunFlags;
use super::child::Role;
use super::part::Part;
use crate::camera::{CameraFlags, SourceFlags};
use crate::chosen_family::FamilyList;
use crate::config::overlay;
use crate::flags::{BusFlags, DetectorFlags, DetectorName, ServingFlags};
use crate::outcome::Failure;
use crate::service::ServiceFlags;

/// The detector of a camera that names none.
const ONLY_DETECTOR: &str = "main";

/// The keys of a detector's table.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct DetectorTable {
    #[command(flatten)]
    #[serde(flatten)]
    detector: DetectorFlags,
    #[command(flatten)]
    #[serde(flatten)]
    serving: ServingFlags,
    /// Detectors that name the same one share it
    #[arg(long)]
    process: Option<String>,
}

/// The processes of a machine. Those who listen come first: less is missed.
pub(super) fn parts(flags: &RunFlags, cameras: &Table) -> Result<Vec<Part>, Failure> {
    let mut services: BTreeMap<String, Vec<ServiceFlags>> = BTreeMap::new();
    let mut parts = Vec::new();
    for (name, keys) in cameras {
        let place = format!("cameras.{name}");
        let mut keys = table(&place, keys)?.clone();
        let detectors = keys.remove("detectors").unwrap_or_else(only_detector);
        let source: SourceFlags = overlay(&flags.source, &keys, &place)?;
        let bus = BusFlags { camera: name.clone(), ..flags.bus.clone() };
        for (detector, keys) in table(&format!("{place}.detectors"), &detectors)? {
            let place = format!("{place}.detectors.{detector}");
            let found = detector_of(flags, &source, table(&place, keys)?, &place)?;
            let name = DetectorName { detector: detector.clone() };
            let process = match found.process {
                Some(process) => format!("service {process}"),
                None => format!("detector {detector} of {}", bus.camera),
            };
            let service =
                ServiceFlags { bus: bus.clone(), name, detector: found.detector, serving: found.serving };
            services.entry(process).or_default().push(service);
        }
        parts.push(Part::named(format!("camera {name}"), Role::Camera, &CameraFlags::new(bus, source))?);
    }
    let services = services.into_iter().map(|(name, detectors)| Part::service(name, &detectors));
    let mut all = services.collect::<Result<Vec<_>, _>>()?;
    all.extend(parts);
    match all.is_empty() {
        true => Err(Failure::new("the table cameras names no camera: write [cameras.NAME] and its source")),
        false => Ok(all),
    }
}

fn only_detector() -> Value {
    Value::Table(Table::from_iter([(ONLY_DETECTOR.to_owned(), Value::Table(Table::new()))]))
}

fn detector_of(
    flags: &RunFlags,
    source: &SourceFlags,
    keys: &Table,
    place: &str,
) -> Result<DetectorTable, Failure> {
    let base =
        DetectorTable { detector: flags.detector.clone(), serving: flags.serving.clone(), process: None };
    let mut found = overlay(&base, keys, place)?;
    if found.detector.family.is_none() && source.is_scene() {
        found.detector.family = Some(FamilyList::of_scene()?);
    }
    check(&found.detector).map_err(|error| Failure::new(format!("[{place}]: {error}")))?;
    Ok(found)
}

/// Refuses settings that no detector would start with.
fn check(flags: &DetectorFlags) -> Result<(), SettingsError> {
    // Any family: the smallest is ready soonest.
    let families: Vec<Family> = Family::published("tag16h5").into_iter().collect();
    Detector::new(&families, &flags.settings()?).map(drop)
}

fn table<'a>(place: &str, value: &'a Value) -> Result<&'a Table, Failure> {
    value.as_table().ok_or_else(|| Failure::new(format!("{place} = {value} is no table: write [{place}]")))
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    fn parts_of(text: &str) -> Result<Vec<Part>, String> {
        let given = RunFlags::augment_args(Command::new("tagbus")).get_matches_from([""]);
        let flags = RunFlags::from_arg_matches(&given).unwrap();
        let keys: Table = text.parse().unwrap();
        parts(&flags, keys["cameras"].as_table().unwrap()).map_err(|failure| failure.to_string())
    }

    #[test]
    fn every_camera_and_every_detector_is_a_process_unless_they_share_one() {
        let parts = parts_of(
            "[cameras.front]\nsource = \"scene:2\"\n[cameras.front.detectors.near]\ndecimate = 1\nprocess = \"vision\"\n\
             [cameras.front.detectors.far]\nfamily = \"tag25h9\"\n[cameras.rear.detectors.main]\nprocess = \"vision\"\n\
             [cameras.blind.detectors]\n[cameras.plain]\n",
        )
        .unwrap();
        let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "detector far of front",
                "detector main of plain",
                "service vision",
                "camera blind",
                "camera front",
                "camera plain",
                "camera rear"
            ]
        );
        let vision = &parts[2];
        let places = vision.detectors.iter().map(|part| (part.bus.camera.as_str(), part.name.as_str()));
        assert_eq!(places.collect::<Vec<_>>(), [("front", "near"), ("rear", "main")]);
        assert!(vision.arguments.contains(&"--decimate=1.0".to_owned()), "{:?}", vision.arguments);
        assert!(vision.arguments.last().unwrap().starts_with("--also="), "{:?}", vision.arguments);
        assert_eq!(parts[0].detectors[0].values["family"], "tag25h9");
        assert!(parts[4].arguments.contains(&"--source=scene:2".to_owned()), "{:?}", parts[4].arguments);
    }

    #[test]
    fn unknown_keys_and_values_of_another_kind_are_named_with_their_place() {
        for (text, words) in [
            ("[cameras.a]\nsorce = \"scene\"", ["[cameras.a]", "sorce", "source"]),
            ("[cameras.a.detectors.b]\ndecimat = 2", ["[cameras.a.detectors.b]", "decimat", "decimate"]),
            ("[cameras.a]\nwidth = \"wide\"", ["[cameras.a]", "width", "wide"]),
            ("[cameras]\na = 3", ["cameras.a", "3", "[cameras.a]"]),
            ("[cameras]", ["cameras", "[cameras.NAME]", "source"]),
        ] {
            let error = parts_of(text).unwrap_err();
            assert!(words.iter().all(|word| error.contains(word)), "{text}: {error}");
        }
    }
}
