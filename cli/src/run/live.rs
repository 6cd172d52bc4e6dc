//! Changes of detectors that need no new process.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use tagbus_client::ConnectOptions;
use tagbus_client::control::{ControlError, DetectorControl};

use super::child::Role;
use super::part::{DetectorPart, Part};
use crate::control::setting::{Setting, change_of, is_known};

/// How long a detector may take to be there and to answer: the others are not looked after meanwhile.
const PATIENCE: Duration = Duration::from_secs(1);

/// Why a change did not happen while the process runs.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum NotDone {
    /// It is not possible at all; what is wrong with it.
    Refused(String),
    /// Only a new process can do it; why.
    NeedsStart(String),
}

/// Makes the detectors of a running process what they are to be; says what was changed.
pub(super) fn change(before: &Part, after: &Part) -> Result<Vec<String>, NotDone> {
    if after.role != Role::Service {
        return Err(NotDone::NeedsStart(format!("a {} reads its settings at its start", after.role)));
    }
    if places(before).ne(places(after)) {
        return Err(NotDone::NeedsStart("other detectors share the process".to_owned()));
    }
    let pairs = before.detectors.iter().zip(&after.detectors);
    pairs.filter(|(before, after)| before != after).map(|(before, after)| change_one(before, after)).collect()
}

/// Where on the bus the detectors of a part are.
fn places(part: &Part) -> impl Iterator<Item = [Option<&String>; 4]> {
    let keys = ["domain", "root", "camera", "detector"];
    part.detectors.iter().map(move |detector| keys.map(|key| detector.values.get(key)))
}

fn change_one(before: &DetectorPart, after: &DetectorPart) -> Result<String, NotDone> {
    let settings = differences(&before.values, &after.values)?;
    let change = change_of(&settings).map_err(|error| NotDone::Refused(error.to_string()))?;
    let place = || -> Result<DetectorControl, String> {
        let domain = after.bus.domain().map_err(|error| error.to_string())?;
        let options = ConnectOptions::in_domain(domain).camera(&after.bus.camera).detector(&after.name);
        DetectorControl::connect(&options.deadline(PATIENCE)).map_err(|error| error.to_string())
    };
    let control = place().map_err(NotDone::NeedsStart)?;
    match control.timeout(PATIENCE).set(&change) {
        Ok(answer) => {
            let settings: Vec<String> = settings.iter().map(Setting::to_string).collect();
            Ok(format!("{} (change {})", settings.join(" "), answer.control_number))
        }
        Err(ControlError::Refused { reason, .. }) => Err(NotDone::Refused(reason)),
        Err(error) => Err(NotDone::NeedsStart(error.to_string())),
    }
}

/// What has to be set so that `before` becomes `after`.
fn differences(
    before: &BTreeMap<String, String>,
    after: &BTreeMap<String, String>,
) -> Result<Vec<Setting>, NotDone> {
    let keys: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
    let differing = keys.into_iter().filter(|key| before.get(*key) != after.get(*key));
    differing
        .map(|key| {
            if !is_known(key) {
                return Err(NotDone::NeedsStart(format!("{key} is read at the start")));
            }
            let value = after.get(key).map_or_else(|| value_of_nothing(key), String::as_str);
            if key == "family" && (value.contains('/') || value.contains(".toml")) {
                return Err(NotDone::NeedsStart("files of families are read at the start".to_owned()));
            }
            Ok(Setting { name: key.clone(), value: value.to_owned() })
        })
        .collect()
}

/// What a flag without a value means to a running detector.
fn value_of_nothing(key: &str) -> &'static str {
    match key {
        "family" => "tag36h11",
        "hamming" => "default",
        "ids" => "all",
        _ => "none",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn what_differs_is_set_and_what_is_gone_goes_back_to_its_default() {
        let before = values(&[("decimate", "2"), ("ids", "1-3"), ("threads", "1")]);
        let after = values(&[("decimate", "1"), ("threads", "1"), ("region", "0,0,64x64")]);
        let settings: Vec<String> =
            differences(&before, &after).unwrap().iter().map(Setting::to_string).collect();
        assert_eq!(settings, ["decimate=1", "ids=all", "region=0,0,64x64"]);
    }

    #[test]
    fn a_family_of_ones_own_and_what_nobody_can_set_need_a_start() {
        for pair in [("family", "tag36h11,my.toml"), ("always", "true")] {
            let needs_start =
                matches!(differences(&values(&[]), &values(&[pair])), Err(NotDone::NeedsStart(_)));
            assert!(needs_start, "{pair:?}");
        }
    }
}
