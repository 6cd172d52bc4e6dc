//! Flags that several commands share, typed once: on the command line and in the file they are texts, behind this not.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use tagbus_detector::{
    Decimation, Level, Refinement, Sampling, Search, Settings, SettingsError, UnknownLevel,
};
use tagbus_family::{Family, UnknownFamily};
use tagbus_message::control::Region;
use tagbus_message::domain::{DEFAULT_DOMAIN, Domain, DomainError};

use crate::chosen_family::{FamilyList, capped};
use crate::config::text;
use crate::outcome::complain;

/// Where on which bus.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Bus")]
pub(crate) struct BusFlags {
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) place: PlaceFlags,
    /// Name of the camera, unique on the bus
    #[arg(long, value_name = "NAME", default_value = "cam0")]
    pub(crate) camera: String,
}

impl BusFlags {
    /// The domain that is meant.
    pub(crate) fn domain(&self) -> Result<Domain, DomainError> {
        self.place.domain()
    }
}

/// Which bus.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Bus")]
pub(crate) struct PlaceFlags {
    /// The bus: every role that names the same one, under the same user, talks to every other
    #[arg(long, value_name = "NAME", default_value = DEFAULT_DOMAIN)]
    pub(crate) domain: String,
    /// Directory for the bus's sockets and small files, absolute; by default below /run or the temporary directory
    #[arg(long, value_name = "DIR")]
    pub(crate) root: Option<PathBuf>,
}

impl PlaceFlags {
    /// The domain that is meant.
    pub(crate) fn domain(&self) -> Result<Domain, DomainError> {
        match &self.root {
            Some(root) => Domain::with_root(&self.domain, root),
            None => Domain::new(&self.domain),
        }
    }
}

/// Which detector of a camera.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Bus")]
pub(crate) struct DetectorName {
    /// Name of the detector, unique at its camera
    #[arg(long, value_name = "NAME", default_value = "main")]
    pub(crate) detector: String,
}

/// What the detector looks for, and how.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Detector")]
pub(crate) struct DetectorFlags {
    /// Tag families to look for, separated by commas: names (see `tagbus family list`) or files of your own families, FILE.toml;
    /// by default tag36h11, and with the built-in scene of `tagbus run` what it shows
    #[arg(long, value_name = "LIST")]
    #[serde(default, with = "text::optional")]
    pub(crate) family: Option<FamilyList>,
    /// How much smaller the frame is made for finding quads: 1, 1.5, 2, 3, ...; saves time, loses small tags
    #[arg(long, value_name = "FACTOR", default_value_t = Settings::default().decimation.factor())]
    pub(crate) decimate: f64,
    /// What whole-number decimation makes of the pixels that become one: point, one of them; mean; darkest: finds small tags with a
    /// black border that stand alone
    #[arg(long, value_name = "point|mean|darkest", default_value_t = Named(Settings::default().sampling))]
    #[serde(with = "text")]
    pub(crate) sampling: Named<Sampling>,
    /// How hard quads are looked for: quick; fine: also beside something brighter, 2 to 3 times the time; thorough: also in noise
    #[arg(long, value_name = "quick|fine|thorough", default_value_t = Named(Settings::default().search))]
    #[serde(with = "text")]
    pub(crate) search: Named<Search>,
    /// Threads that work on a frame, 1 to 64; more than one save time on large or busy frames
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().threads)]
    pub(crate) threads: usize,
    /// Wrong bits to correct at most; by default 0 to 2, as the family bears (see `tagbus family list`)
    #[arg(long, value_name = "BITS")]
    pub(crate) hamming: Option<u32>,
    /// How corners are refined at full resolution: none; edges as they are seen; tag: the whole tag as printed, most exact, 0.1 ms a tag
    #[arg(long, value_name = "none|edges|tag", default_value_t = Named(Settings::default().refinement))]
    #[serde(with = "text")]
    pub(crate) refine: Named<Refinement>,
    /// Sharpening of the sampled cells, 0 for none to 10
    #[arg(long, value_name = "STRENGTH", default_value_t = f64::from(Settings::default().sharpening))]
    pub(crate) sharpening: f64,
    /// Report only these ids, such as 1-20,33
    #[arg(long, value_name = "LIST")]
    #[serde(default, with = "text::optional")]
    pub(crate) ids: Option<IdList>,
    /// Drop tags whose decision margin is below this, in grey levels
    #[arg(long, value_name = "LEVELS", default_value_t = f64::from(Settings::default().min_margin))]
    pub(crate) min_margin: f64,
}

impl DetectorFlags {
    /// The families to look for; says on the standard error where fewer bits are corrected than was asked for.
    pub(crate) fn families(&self) -> Result<Vec<Family>, UnknownFamily> {
        let families = match &self.family {
            Some(list) => list.families(),
            None => vec![Family::published("tag36h11")?],
        };
        let asked = self.hamming.unwrap_or(0);
        families.iter().filter_map(|family| capped(family, asked)).for_each(complain);
        Ok(families)
    }

    /// What the detector is told.
    pub(crate) fn settings(&self) -> Result<Settings, SettingsError> {
        Ok(Settings {
            decimation: Decimation::from_factor(self.decimate)?,
            sampling: self.sampling.0,
            search: self.search.0,
            hamming: self.hamming,
            refinement: self.refine.0,
            sharpening: self.sharpening as f32,
            min_margin: self.min_margin as f32,
            ids: self.ids.as_ref().map(IdList::ids).unwrap_or_default(),
            threads: self.threads,
        })
    }
}

/// Which part of each frame.
#[derive(Clone, Debug, clap::Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Detector")]
pub(crate) struct ServingFlags {
    /// Search only this part of each frame, in its pixels, such as 100,50,640x360; by default the whole frame
    #[arg(long, value_name = "X,Y,WIDTHxHEIGHT")]
    #[serde(default, with = "text::optional")]
    pub(crate) region: Option<Region>,
    /// Detect even when nobody subscribes; by default detection pauses until somebody does
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    pub(crate) always: bool,
}

/// Ids and ranges of ids, separated by commas, as they were written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct IdList(Vec<(u32, u32)>);

/// The longest list that is taken: more than any family has.
const MOST_IDS: u64 = 1 << 20;

impl IdList {
    /// The single ids.
    pub(crate) fn ids(&self) -> Vec<u32> {
        self.0.iter().flat_map(|&(first, last)| first..=last).collect()
    }

    /// As they were written: first and last id of each.
    pub(crate) fn ranges(&self) -> &[(u32, u32)] {
        &self.0
    }
}

impl FromStr for IdList {
    type Err = IdListError;

    fn from_str(text: &str) -> Result<Self, IdListError> {
        let ranges = text.split(',').map(parse_range).collect::<Option<Vec<_>>>();
        let ranges = ranges.ok_or_else(|| IdListError::Text(text.to_owned()))?;
        let count: u64 = ranges.iter().map(|&(first, last)| u64::from(last - first) + 1).sum();
        if count > MOST_IDS { Err(IdListError::TooMany(count)) } else { Ok(Self(ranges)) }
    }
}

/// `7` or `1-20`.
fn parse_range(text: &str) -> Option<(u32, u32)> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let range = (first.trim().parse().ok()?, last.trim().parse().ok()?);
    (range.0 <= range.1).then_some(range)
}

impl fmt::Display for IdList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (first, last)) in self.0.iter().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            match first == last {
                true => write!(f, "{comma}{first}")?,
                false => write!(f, "{comma}{first}-{last}")?,
            }
        }
        Ok(())
    }
}

/// A text that is no list of ids.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum IdListError {
    /// Not made of numbers and ranges.
    Text(String),
    /// More ids than any family has.
    TooMany(u64),
}

impl fmt::Display for IdListError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(f, "\"{text}\" is no list of ids: write it as 1-20,33"),
            Self::TooMany(count) => write!(f, "{count} ids, but at most {MOST_IDS} are taken"),
        }
    }
}

impl std::error::Error for IdListError {}

/// A setting that is one of a few, each with a name.
pub(crate) trait Choice: Copy + PartialEq + 'static {
    /// What is chosen.
    const WHAT: &'static str;
    /// What there is to choose from.
    const CHOICES: [(Self, &'static str); 3];
}

impl Choice for Refinement {
    const WHAT: &'static str = "refinement";
    const CHOICES: [(Self, &'static str); 3] = Self::NAMES;
}

impl Choice for Sampling {
    const WHAT: &'static str = "sampling";
    const CHOICES: [(Self, &'static str); 3] = Self::NAMES;
}

impl Choice for Search {
    const WHAT: &'static str = "search";
    const CHOICES: [(Self, &'static str); 3] = Self::NAMES;
}

/// A choice by its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Named<C>(pub(crate) C);

impl<C: Choice> FromStr for Named<C> {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let found = C::CHOICES.into_iter().find(|(_, known)| *known == name);
        let known = || C::CHOICES.map(|(_, name)| name).join(", ");
        found.map(|(choice, _)| Self(choice)).ok_or_else(|| UnknownName {
            what: C::WHAT,
            name: name.to_owned(),
            known: known(),
        })
    }
}

impl<C: Choice> fmt::Display for Named<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = C::CHOICES.into_iter().find(|(choice, _)| *choice == self.0).map(|(_, name)| name);
        // Every choice has a name.
        f.write_str(name.unwrap_or_default())
    }
}

/// A name of nothing that can be chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct UnknownName {
    what: &'static str,
    name: String,
    known: String,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown {} \"{}\": known are {}", self.what, self.name, self.known)
    }
}

impl std::error::Error for UnknownName {}

/// The instructions that the detector may use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelName(pub(crate) Level);

impl FromStr for LevelName {
    type Err = UnknownLevel;

    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        Level::named(name).map(Self)
    }
}

impl fmt::Display for LevelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_ids_are_read_back_from_what_they_print() {
        let list: IdList = " 1-3, 33,7 - 8".parse().unwrap();
        assert_eq!(list.to_string(), "1-3,33,7-8");
        assert_eq!(list.to_string().parse(), Ok(list.clone()));
        assert_eq!(list.ids(), [1, 2, 3, 33, 7, 8]);
    }

    #[test]
    fn texts_that_are_no_ids_are_refused() {
        for text in ["", "1-", "-3", "3-1", "a", "1,,2", "4294967296"] {
            assert_eq!(text.parse::<IdList>(), Err(IdListError::Text(text.to_owned())));
        }
        assert_eq!("0-4294967295".parse::<IdList>(), Err(IdListError::TooMany(1 << 32)));
    }
}
