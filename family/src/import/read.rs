//! From a text of some form to a family with the distance that it really has.

use super::error::{ImportError, Problem};
use super::tokens::Listed;
use super::{c_table, java, opencv};
use crate::family::{Family, FamilyError};
use crate::layout::Layout;

/// The form of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A C file of the AprilTag library: `codedata`, `bit_x`, `bit_y`, `width_at_border`, ... or, of AprilTag 2,
    /// `codes[0] = ...`, `d` and `black_border`.
    C,
    /// A Java class of the tag generator: `super(bits, distance, codes)` with row-major codes and a classic layout, or
    /// `super(layout, distance, codes)` with the layout as letters.
    Java,
    /// A dictionary as OpenCV writes it in YAML or JSON: `nmarkers`, `markersize`, `marker_0`, ...
    OpenCv,
}

impl Format {
    /// The form that a text seems to have.
    ///
    /// # Errors
    /// [`Problem::UnknownFormat`].
    pub fn guess(text: &str) -> Result<Format, ImportError> {
        let has = |words: &[&str]| words.iter().any(|word| text.contains(word));
        if has(&["nmarkers", "marker_0"]) {
            Ok(Format::OpenCv)
        } else if has(&["extends TagFamily", "new long"]) {
            Ok(Format::Java)
        } else if has(&["codedata", "apriltag_family", "uint64_t"]) {
            Ok(Format::C)
        } else {
            Err(Problem::UnknownFormat.at(1))
        }
    }
}

/// A family as it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Imported {
    /// The family. Its distance is the measured one.
    pub family: Family,
    /// The form that the table had.
    pub format: Format,
    /// The distance that the table states; for a dictionary of OpenCV the least that bears its `maxCorrectionBits`.
    pub stated_distance: Option<u32>,
    /// Cells that the table says nothing about, and that no known layout explains. They were taken for black or white
    /// where they continue the border inwards, else for not being part of the tag. Reading tags does not depend on them.
    pub guessed_cells: usize,
}

/// What the reader of a form finds, with codes in the order of [`Layout::bits`].
pub(super) struct Table {
    pub name: Option<String>,
    pub layout: Layout,
    pub codes: Vec<Listed>,
    pub stated_distance: Option<u32>,
    pub guessed_cells: usize,
}

/// Reads a table of the form given, or of the form that it seems to have. The family gets the name that the table has,
/// or else `name`.
///
/// # Errors
/// [`ImportError`], with the line.
pub fn read(text: &str, format: Option<Format>, name: &str) -> Result<Imported, ImportError> {
    let format = format.map_or_else(|| Format::guess(text), Ok)?;
    let table = match format {
        Format::C => c_table::read(text)?,
        Format::Java => java::read(text)?,
        Format::OpenCv => opencv::read(text)?,
    };
    let last_line = text.lines().count().max(1);
    let name = table.name.as_deref().unwrap_or(name);
    let family = family(&table, name, last_line)?;
    Ok(Imported {
        family,
        format,
        stated_distance: table.stated_distance,
        guessed_cells: table.guessed_cells,
    })
}

fn family(table: &Table, name: &str, last_line: usize) -> Result<Family, ImportError> {
    let line = |id: usize| table.codes.get(id).map_or(last_line, |code| code.line);
    let blame = |error| match error {
        FamilyError::SameTag { first, second, .. } => {
            Problem::SameTag { first, first_line: line(first), second }.at(line(second))
        }
        FamilyError::CodeTooWide { id, code, bit_count } => {
            Problem::CodeTooWide { id, code, bit_count }.at(line(id))
        }
        FamilyError::NoCodes | FamilyError::Distance { .. } => {
            Problem::Missing { what: "the list of codes" }.at(last_line)
        }
    };
    let codes: Vec<u64> = table.codes.iter().map(|code| code.value).collect();
    let make = |distance| Family::new(name, table.layout.clone(), codes.clone(), distance).map_err(blame);
    let symmetric = |&code: &u64| table.layout.rotations(code)[1..].contains(&code);
    let family = make(1)?;
    match codes.iter().position(symmetric) {
        Some(id) => Err(Problem::Symmetric { id, code: codes[id] }.at(line(id))),
        None => make(family.minimum_distance().overall()),
    }
}

/// Refuses codes with more bits than there are cells; to be asked before bits are put into another order.
pub(super) fn check_widths(codes: &[Listed], bit_count: u32) -> Result<(), ImportError> {
    match codes.iter().position(|code| bit_count < 64 && code.value >> bit_count != 0) {
        Some(id) => {
            let Listed { value: code, line } = codes[id];
            Err(Problem::CodeTooWide { id, code, bit_count }.at(line))
        }
        None => Ok(()),
    }
}

/// The same with codes whose bits lie row after row.
pub(super) fn from_rows(codes: Vec<Listed>, layout: &Layout) -> Result<Vec<Listed>, ImportError> {
    check_widths(&codes, layout.bit_count())?;
    let ours = |code: Listed| Listed { value: layout.from_row_major(code.value), ..code };
    Ok(codes.into_iter().map(ours).collect())
}
