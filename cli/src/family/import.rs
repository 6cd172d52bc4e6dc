//! `tagbus family import`: a table of another program becomes a family file.

use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_family::Family;
use tagbus_family::file::FamilyFile;
use tagbus_family::import::{self, Format, Imported};

use crate::chosen_family::check_name;
use crate::command::Invocation;
use crate::new_file::{self, Existing};
use crate::outcome::{Failure, Outcome, complain};

/// Make a family file of a table of another program
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus family import tag36h9.c --output tag36h9.toml
  tagbus family import Tag25h7.java --output 25h7.toml --force
  tagbus family import dictionary.yml --name mine --output mine.toml
  tagbus detect --family mine.toml photos/

c is a table of the AprilTag library, 2 or 3; java a class of its generator;
opencv a dictionary as cv::aruco::Dictionary::writeDictionary writes it, YAML or JSON.
The distance is measured, and what it does not bear is not corrected.

ArUco's own families need no file: --family DICT_4X4_50, and so on. OpenCV's
dictionaries DICT_APRILTAG_* are turned by half a turn.")]
pub(crate) struct ImportCommand {
    /// The table
    #[arg(value_name = "FILE", required_unless_present = "print_config")]
    table: Option<PathBuf>,
    /// The form of the table; auto: what it looks like
    // Not in the flags below: in the configuration file, `format` is that of the camera's frames.
    #[arg(long, value_name = "auto|c|java|opencv", default_value_t = FormatName(None))]
    format: FormatName,
    #[command(flatten)]
    flags: ImportFlags,
}

#[derive(Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct ImportFlags {
    /// Name of the family, up to 32 bytes; by default the one in the table, else that of the file
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// The family file to write
    #[arg(long, value_name = "FILE.toml", required_unless_present = "print_config")]
    output: Option<PathBuf>,
    /// Replace the output if it exists
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    force: bool,
}

/// Reads the table, and writes the family if there is nothing wrong with it.
pub(super) fn execute(command: ImportCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let (Some(table), Some(output)) = (&command.table, &flags.output) else {
        return Err(Failure::new("give the table to read and --output, the family file to write"));
    };
    let existing = if flags.force { Existing::Replace } else { Existing::Keep };
    new_file::check(output, existing)?;
    let imported = read(table, &command.format, flags.name.as_deref())?;
    warnings(&imported).into_iter().for_each(complain);
    let summary = summary(&imported.family, output);
    let text = FamilyFile::of(imported.family).to_text();
    new_file::write(output, text.as_bytes(), existing)?;
    writeln!(io::stdout().lock(), "{summary}")?;
    Ok(Outcome::Done)
}

fn read(table: &Path, format: &FormatName, name: Option<&str>) -> Result<Imported, Failure> {
    let refused = |reason: String| Failure::new(format!("{}: {reason}", table.display()));
    let bytes = fs::read(table).map_err(|error| refused(error.to_string()))?;
    // Only comments hold letters beyond ASCII, and some of them are of times before UTF-8.
    let text = String::from_utf8_lossy(&bytes);
    let stem = table.file_stem().unwrap_or_default().to_string_lossy();
    let mut imported = import::read(&text, format.0, &stem).map_err(|error| refused(error.to_string()))?;
    if let Some(name) = name {
        imported.family = renamed(&imported.family, name)?;
    }
    check_name(imported.family.name())?;
    Ok(imported)
}

fn renamed(family: &Family, name: &str) -> Result<Family, Failure> {
    Ok(Family::new(name, family.layout().clone(), family.codes().to_vec(), family.distance())?)
}

fn warnings(imported: &Imported) -> Vec<String> {
    let Imported { family, stated_distance, guessed_cells, .. } = imported;
    let mut warnings = Vec::new();
    if let Some(stated) = stated_distance.filter(|stated| *stated > family.distance()) {
        warnings.push(format!(
            "warning: the table claims a distance of {stated}, but its codes are only {} bits apart: at most {} wrong bits are \
             corrected",
            family.distance(),
            family.correctable()
        ));
    }
    if *guessed_cells > 0 {
        warnings.push(format!(
            "warning: the table does not say what {guessed_cells} of the cells are: look at `tagbus family show` and, before \
             printing, correct the letters of the layout in the file"
        ));
    }
    warnings
}

fn summary(family: &Family, output: &Path) -> String {
    format!(
        "{}: {} tags of {} bits, at least {} bits apart, written to {}",
        family.name(),
        family.codes().len(),
        family.layout().bit_count(),
        family.distance(),
        output.display()
    )
}

/// A form by its name; none stands for what the table looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FormatName(Option<Format>);

const FORMATS: [(Option<Format>, &str); 4] =
    [(None, "auto"), (Some(Format::C), "c"), (Some(Format::Java), "java"), (Some(Format::OpenCv), "opencv")];

impl FromStr for FormatName {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        let found = FORMATS.into_iter().find(|(_, known)| *known == name);
        found.map(|(format, _)| Self(format)).ok_or_else(|| UnknownFormat(name.to_owned()))
    }
}

impl fmt::Display for FormatName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = FORMATS.into_iter().find(|(format, _)| *format == self.0).map(|(_, name)| name);
        // Every form has a name.
        f.write_str(name.unwrap_or_default())
    }
}

/// A name of no form.
#[derive(Clone, Debug, PartialEq, Eq)]
struct UnknownFormat(String);

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = FORMATS.map(|(_, name)| name).join(", ");
        write!(f, "unknown form of table {:?}: known are {known}", self.0)
    }
}

impl std::error::Error for UnknownFormat {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_are_read_back_from_their_names() {
        for (format, name) in FORMATS {
            assert_eq!(name.parse(), Ok(FormatName(format)));
            assert_eq!(FormatName(format).to_string(), name);
        }
        assert_eq!("svg".parse::<FormatName>(), Err(UnknownFormat("svg".to_owned())));
    }

    #[test]
    fn claims_that_the_codes_do_not_bear_are_told() {
        let family = Family::published("4x4_1000").unwrap();
        let imported = |stated| Imported {
            family: family.clone(),
            format: Format::OpenCv,
            stated_distance: stated,
            guessed_cells: 0,
        };
        assert_eq!(warnings(&imported(None)), Vec::<String>::new());
        assert_eq!(warnings(&imported(Some(2))), Vec::<String>::new());
        let told = warnings(&imported(Some(3))).concat();
        assert!(
            told.contains(
                "claims a distance of 3, but its codes are only 2 bits apart: at most 0 wrong bits"
            ),
            "{told}"
        );
    }
}
