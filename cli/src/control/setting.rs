//! `NAME=VALUE` on the command line.

use std::fmt;
use std::str::FromStr;

use tagbus_client::control::{DetectorChange, RefinementChoice, Region, SamplingChoice, SearchChoice};
use tagbus_family::nearest_name;

use crate::flags::IdList;

/// Names of a detector's parameters: those of the flags of `tagbus service`.
const NAMES: [&str; 11] = [
    "family",
    "decimate",
    "sampling",
    "search",
    "threads",
    "hamming",
    "refine",
    "sharpening",
    "ids",
    "min-margin",
    "region",
];

/// Whether a running detector can be told this.
pub(crate) fn is_known(name: &str) -> bool {
    NAMES.contains(&name)
}

/// One value that is to be put in force.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Setting {
    pub(crate) name: String,
    pub(crate) value: String,
}

impl FromStr for Setting {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        match text.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Self { name: name.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err(SettingError(format!("\"{text}\" sets nothing: write NAME=VALUE"))),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.value)
    }
}

/// What is wrong with a setting, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SettingError(String);

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SettingError {}

/// Refuses a name that is there twice: which value is meant?
pub(crate) fn check_names(settings: &[Setting]) -> Result<(), String> {
    let mut names: Vec<&str> = settings.iter().map(|setting| setting.name.as_str()).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("{} is set twice: which value is meant?", pair[0])),
        None => Ok(()),
    }
}

/// The change that all settings together are.
pub(crate) fn change_of(settings: &[Setting]) -> Result<DetectorChange, SettingError> {
    let mut change = DetectorChange::default();
    for setting in settings {
        put(setting, &mut change).map_err(SettingError)?;
    }
    Ok(change)
}

fn put(setting: &Setting, change: &mut DetectorChange) -> Result<(), String> {
    let Setting { name, value } = setting;
    match name.as_str() {
        "family" => change.families = Some(families(value)?),
        "decimate" => change.decimation = Some(number(setting, "1, 1.5 or a whole number")?),
        "sampling" => {
            change.sampling = Some(chosen(setting, SamplingChoice::named(value), SamplingChoice::NAMES)?);
        }
        "search" => change.search = Some(chosen(setting, SearchChoice::named(value), SearchChoice::NAMES)?),
        "threads" => change.threads = Some(number(setting, "1 to 64")?),
        "hamming" => {
            let bits = || number(setting, "a number of bits, or default");
            change.hamming = Some(if value == "default" { None } else { Some(bits()?) });
        }
        "refine" => {
            let choice = RefinementChoice::named(value);
            change.refinement = Some(chosen(setting, choice, RefinementChoice::NAMES)?);
        }
        "sharpening" => change.sharpening = Some(number(setting, "0 to 10")?),
        "ids" => change.ids = Some(ids(value)?),
        "min-margin" => change.min_margin = Some(number(setting, "grey levels, such as 5")?),
        "region" => change.region = Some(region(value)?),
        other => return Err(unknown(other)),
    }
    Ok(())
}

fn unknown(name: &str) -> String {
    let nearest = nearest_name(name, &NAMES).unwrap_or(NAMES[0]);
    format!("a detector has no parameter {name}, did you mean {nearest}? known are {}", NAMES.join(", "))
}

fn number<T: FromStr>(setting: &Setting, allowed: &str) -> Result<T, String> {
    setting.value.parse().map_err(|_| format!("{setting} is not possible: use {allowed}"))
}

fn chosen<C>(setting: &Setting, choice: Option<C>, names: [(C, &'static str); 3]) -> Result<C, String> {
    choice.ok_or_else(|| {
        let names: Vec<&str> = names.into_iter().map(|(_, name)| name).collect();
        format!("{setting} is not possible: use {}", names.join(", "))
    })
}

/// A running service cannot be given a file: it knows families by their names.
fn families(value: &str) -> Result<Vec<String>, String> {
    let names: Vec<String> = value.split(',').map(|name| name.trim().to_owned()).collect();
    match names.iter().find(|name| name.ends_with(".toml") || name.contains('/')) {
        Some(path) => Err(format!(
            "{path}: a running service takes no files: start it with --family {path}, then it knows that family by its name"
        )),
        None => Ok(names),
    }
}

fn ids(value: &str) -> Result<Vec<(u32, u32)>, String> {
    if value == "all" {
        return Ok(Vec::new());
    }
    let list: IdList = value.parse().map_err(|error| format!("{error}, or all"))?;
    Ok(list.ranges().to_vec())
}

fn region(value: &str) -> Result<Option<Region>, String> {
    if value == "none" {
        return Ok(None);
    }
    value.parse().map(Some).map_err(|error| format!("{error}, or none"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_client::control::DetectorParameters;

    fn change(texts: &[&str]) -> Result<DetectorChange, SettingError> {
        let settings: Vec<Setting> = texts.iter().map(|text| text.parse().unwrap()).collect();
        change_of(&settings)
    }

    #[test]
    fn what_is_printed_of_parameters_puts_them_in_force_again() {
        let parameters = DetectorParameters {
            decimation: 1.5,
            sampling: SamplingChoice::Darkest,
            search: SearchChoice::Thorough,
            threads: 3,
            hamming: Some(1),
            refinement: RefinementChoice::None,
            sharpening: 0.25,
            min_margin: 2.5,
            region: Some(Region { x: 1, y: 2, width: 30, height: 40 }),
            families: vec!["tag36h11".into(), "mine".into()],
            ids: vec![(1, 20), (33, 33)],
        };
        let none = DetectorParameters { hamming: None, region: None, ids: vec![], ..parameters.clone() };
        for parameters in [parameters, none] {
            let texts = parameters.named().map(|(name, value)| format!("{name}={value}"));
            assert!(texts.iter().zip(NAMES).all(|(text, name)| text.starts_with(name)));
            let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
            let expected = DetectorChange {
                decimation: Some(parameters.decimation),
                sampling: Some(parameters.sampling),
                search: Some(parameters.search),
                threads: Some(parameters.threads),
                hamming: Some(parameters.hamming),
                refinement: Some(parameters.refinement),
                sharpening: Some(parameters.sharpening),
                min_margin: Some(parameters.min_margin),
                region: Some(parameters.region),
                families: Some(parameters.families),
                ids: Some(parameters.ids),
            };
            assert_eq!(change(&texts).unwrap(), expected);
        }
    }

    #[test]
    fn settings_that_mean_nothing_are_refused_with_what_does() {
        for (text, expected) in [
            ("decimat=2", "did you mean decimate?"),
            ("decimate=two", "decimate=two is not possible"),
            ("threads=-1", "1 to 64"),
            ("search=fast", "quick, fine, thorough"),
            ("refine=tags", "none, edges, tag"),
            ("hamming=few", "or default"),
            ("ids=1-", "1-20,33, or all"),
            ("region=5x5", "X,Y,WIDTHxHEIGHT"),
            ("family=mine.toml", "takes no files"),
        ] {
            let error = change(&[text]).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        for text in ["", "decimate", "=2", "decimate="] {
            assert!(text.parse::<Setting>().unwrap_err().to_string().contains("NAME=VALUE"));
        }
        let twice = ["ids=1", "ids=2"].map(|text| text.parse().unwrap());
        assert!(check_names(&twice).unwrap_err().contains("ids is set twice"));
    }
}
