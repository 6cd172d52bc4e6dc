//! A family as users name it: a published one by its name, one of their own by its file.

use std::fmt;
use std::io;
use std::path::Path;
use std::str::FromStr;

use tagbus_family::file::{FamilyFile, FileError};
use tagbus_family::{Family, UnknownFamily};
use tagbus_message::detection::FAMILY_NAME_BYTES;

use crate::outcome::Failure;

/// A family and the text that named it.
#[derive(Clone, Debug)]
pub(crate) struct ChosenFamily {
    /// A published name, or the path of a file.
    written: String,
    pub(crate) file: FamilyFile,
}

impl ChosenFamily {
    /// A published family.
    pub(crate) fn published(name: &str) -> Result<Self, UnknownFamily> {
        let family = Family::published(name)?;
        Ok(Self { written: family.name().to_owned(), file: FamilyFile::of(family) })
    }

    pub(crate) fn family(&self) -> &Family {
        &self.file.family
    }
}

/// Says which number of corrected bits is in force when it is less than what was `asked` for, and why.
pub(crate) fn capped(family: &Family, asked: u32) -> Option<String> {
    let (name, distance, most) = (family.name(), family.distance(), family.correctable());
    (asked > most).then(|| {
        format!(
            "{name}: {asked} corrected bits were asked for, {most} are in force: its tags differ in {distance} bits, so with more \
             the nearest tag need not be the right one"
        )
    })
}

/// Refuses a name for a new family that no message could carry.
pub(crate) fn check_name(name: &str) -> Result<(), Failure> {
    match name.len() {
        1..=FAMILY_NAME_BYTES => Ok(()),
        length => Err(Failure::new(format!(
            "the family's name {name:?} has {length} bytes, but 1 to {FAMILY_NAME_BYTES} fit into a message; give another with --name"
        ))),
    }
}

/// Whether a text means a file: no published name ends like that or holds a slash.
fn is_path(text: &str) -> bool {
    text.ends_with(".toml") || text.contains('/')
}

impl FromStr for ChosenFamily {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        if !is_path(text) {
            return Self::published(text).map_err(ChoiceError::Unknown);
        }
        let content = std::fs::read_to_string(Path::new(text))
            .map_err(|error| ChoiceError::Read { path: text.to_owned(), error })?;
        let file = FamilyFile::parse(&content)
            .map_err(|error| ChoiceError::File { path: text.to_owned(), error: Box::new(error) })?;
        Ok(Self { written: text.to_owned(), file })
    }
}

impl fmt::Display for ChosenFamily {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.written)
    }
}

/// Families separated by commas, each of another name.
#[derive(Clone, Debug)]
pub(crate) struct FamilyList(Vec<ChosenFamily>);

impl FamilyList {
    /// The families that the built-in scene shows, each once.
    pub(crate) fn of_scene() -> Result<Self, UnknownFamily> {
        let shown = tagbus_scene::SceneConfig::default().families;
        // A nested entry names the outer family first: "outer/inner".
        let mut names: Vec<&str> = shown.iter().flat_map(|entry| entry.split('/')).collect();
        names.sort_unstable();
        names.dedup();
        names.into_iter().map(ChosenFamily::published).collect::<Result<_, _>>().map(Self)
    }

    pub(crate) fn families(&self) -> Vec<Family> {
        self.0.iter().map(|chosen| chosen.family().clone()).collect()
    }

    /// Detections name their family, so two of one name could not be told apart.
    fn check_names(&self) -> Result<(), ChoiceError> {
        let mut names: Vec<&str> = self.0.iter().map(|chosen| chosen.family().name()).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(ChoiceError::SameName(pair[0].to_owned())),
            None => Ok(()),
        }
    }
}

impl FromStr for FamilyList {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let list = Self(text.split(',').map(|name| name.trim().parse()).collect::<Result<_, _>>()?);
        list.check_names()?;
        Ok(list)
    }
}

impl fmt::Display for FamilyList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let written: Vec<&str> = self.0.iter().map(|chosen| chosen.written.as_str()).collect();
        f.write_str(&written.join(","))
    }
}

/// Why a text names no family, or a list no families.
#[derive(Debug)]
#[non_exhaustive]
pub(crate) enum ChoiceError {
    /// No published family has this name.
    Unknown(UnknownFamily),
    /// The file cannot be read.
    Read {
        /// Its path.
        path: String,
        /// Why.
        error: io::Error,
    },
    /// The file holds no family.
    File {
        /// Its path.
        path: String,
        /// Why.
        error: Box<FileError>,
    },
    /// Two families of the list have this name.
    SameName(String),
}

impl fmt::Display for ChoiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(error) => {
                write!(f, "{error}; a family of your own is named by its file, FILE.toml")
            }
            Self::Read { path, error } => write!(f, "cannot read the family {path}: {error}"),
            Self::File { path, error } => write!(f, "{path} holds no family: {error}"),
            Self::SameName(name) => {
                write!(
                    f,
                    "two families are named {name}: detections could not be told apart; rename one (`name` in its file)"
                )
            }
        }
    }
}

impl std::error::Error for ChoiceError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_are_found_by_any_of_their_names() {
        let list: FamilyList = "36h11, TAGSTANDARD41H12".parse().unwrap();
        assert_eq!(list.to_string(), "tag36h11,tagStandard41h12");
    }

    #[test]
    fn a_family_twice_is_refused() {
        let error = "36h11,tag36h11".parse::<FamilyList>().unwrap_err();
        assert!(error.to_string().contains("two families are named tag36h11"), "{error}");
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = "36h11,none/such.toml".parse::<FamilyList>().unwrap_err();
        assert!(error.to_string().contains("none/such.toml"), "{error}");
    }
}
