//! A family as a file: TOML that people can read and the detector takes at run time.
//!
//! ```toml
//! name = "robot32"
//! distance = 9
//! layout = """
//! wwwwwwwwww
//! ...
//! """
//! codes = ["0x1234abcd", "0x5678ef01"]
//!
//! [recipe]            # may be left out; how the codes were searched
//! metric = "ising"
//! least-complexity = 40
//! seed-complexity = 10
//! bit-order = "quadrants"
//! candidates = 4294967296
//! complete = true
//! ```

use crate::complexity::{Metric, Rule};
use crate::family::{Family, FamilyError};
use crate::layout::Layout;
use crate::layout_error::LayoutError;
use crate::recipe::{BitOrder, Recipe, RecipeError};
use crate::search::{TooClose, first_too_close};
use serde::Deserialize;
use std::fmt::{self, Write};

/// Codes a line.
const CODES_A_LINE: usize = 8;

/// A family and, when it is known, how it was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FamilyFile {
    /// The family.
    pub family: Family,
    /// How its codes were searched.
    pub recipe: Option<Recipe>,
    /// Candidates 1 to this number are decided.
    pub decided: Option<u64>,
    /// Whether all candidates are decided, so that no code can be added.
    pub complete: bool,
}

/// The file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Text {
    name: String,
    distance: u32,
    layout: String,
    codes: Vec<String>,
    recipe: Option<RecipeText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct RecipeText {
    metric: String,
    least_complexity: u32,
    seed_complexity: u32,
    bit_order: String,
    candidates: u64,
    complete: bool,
}

impl FamilyFile {
    /// A family of which nothing but its codes is known.
    pub fn of(family: Family) -> FamilyFile {
        FamilyFile { family, recipe: None, decided: None, complete: false }
    }

    /// Reads a file, and proves what it says of its codes: they fit the layout and are as far apart as stated.
    ///
    /// # Errors
    /// [`FileError`], which says what is wrong and where.
    pub fn parse(text: &str) -> Result<FamilyFile, FileError> {
        let text: Text =
            toml::from_str(text).map_err(|error| FileError::Form(error.to_string().trim_end().to_owned()))?;
        let layout = Layout::parse(&text.layout).map_err(FileError::Layout)?;
        let codes = read_codes(&text.codes)?;
        let family = Family::new(&text.name, layout, codes, text.distance).map_err(FileError::Family)?;
        if let Some(found) = first_too_close(family.layout(), family.codes(), text.distance) {
            return Err(FileError::TooClose { found, distance: text.distance });
        }
        let Some(written) = text.recipe else { return Ok(FamilyFile::of(family)) };
        let recipe = written.recipe(&family)?;
        Ok(FamilyFile {
            family,
            recipe: Some(recipe),
            decided: Some(written.candidates),
            complete: written.complete,
        })
    }

    /// The file's text; [`FamilyFile::parse`] reads it back to the same.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> fmt::Result {
        let Self { family, recipe, decided, complete } = self;
        writeln!(
            out,
            "# A tag family of tagbus: {} tags of {} bits.",
            family.codes().len(),
            family.layout().bit_count()
        )?;
        writeln!(out, "name = {}", toml::Value::from(family.name()))?;
        writeln!(out, "# Bits in which any two tags differ at least, however they are turned.")?;
        writeln!(out, "distance = {}", family.distance())?;
        writeln!(out, "# w white, b black, d data, x not part of the tag.\nlayout = \"\"\"")?;
        let letters: Vec<char> = family.layout().text().chars().collect();
        for row in letters.chunks(family.layout().total_width()) {
            writeln!(out, "{}", row.iter().collect::<String>())?;
        }
        writeln!(out, "\"\"\"")?;
        write_codes(out, family)?;
        match recipe {
            Some(recipe) => write_recipe(out, recipe, decided.unwrap_or(0), *complete),
            None => Ok(()),
        }
    }
}

fn write_codes(out: &mut String, family: &Family) -> fmt::Result {
    let digits = family.layout().bit_count().div_ceil(4) as usize;
    writeln!(
        out,
        "# By id, the most significant bit first (`tagbus family explain` shows where it lies).\ncodes = ["
    )?;
    for line in family.codes().chunks(CODES_A_LINE) {
        let codes: Vec<String> = line.iter().map(|code| format!("\"0x{code:0digits$x}\",")).collect();
        writeln!(out, "    {}", codes.join(" "))?;
    }
    writeln!(out, "]")
}

fn write_recipe(out: &mut String, recipe: &Recipe, decided: u64, complete: bool) -> fmt::Result {
    writeln!(out, "\n# How the codes were searched: enough to search them again.\n[recipe]")?;
    writeln!(out, "metric = \"{}\"", recipe.rule().metric)?;
    writeln!(out, "least-complexity = {}", recipe.rule().least)?;
    writeln!(out, "seed-complexity = {}", recipe.seed_complexity())?;
    writeln!(out, "bit-order = \"{}\"", recipe.order().name())?;
    writeln!(
        out,
        "# Candidates looked at, and whether these are all.\ncandidates = {decided}\ncomplete = {complete}"
    )
}

impl RecipeText {
    fn recipe(&self, family: &Family) -> Result<Recipe, FileError> {
        let metric = Metric::named(&self.metric).ok_or_else(|| FileError::Word {
            key: "metric",
            value: self.metric.clone(),
            allowed: Metric::ALL.map(Metric::name).join(", "),
        })?;
        let order = BitOrder::named(&self.bit_order).ok_or_else(|| FileError::Word {
            key: "bit-order",
            value: self.bit_order.clone(),
            allowed: BitOrder::ALL.map(BitOrder::name).join(", "),
        })?;
        let rule = Rule { metric, least: self.least_complexity };
        let recipe = Recipe::new(family.layout().clone(), family.distance(), self.seed_complexity, rule);
        Ok(recipe.map_err(FileError::Recipe)?.with_order(order))
    }
}

fn read_codes(codes: &[String]) -> Result<Vec<u64>, FileError> {
    let read = |(id, text): (usize, &String)| {
        let digits = text.strip_prefix("0x").unwrap_or(text);
        // The sign that from_str_radix would take is no digit.
        let code = u64::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'));
        code.ok_or_else(|| FileError::Code { id, text: text.clone() })
    };
    codes.iter().enumerate().map(read).collect()
}

/// Why a text is no family.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileError {
    /// No TOML, a key that is missing or not known, or a value of the wrong kind; the text names the line.
    Form(String),
    /// The layout is none.
    Layout(LayoutError),
    /// A code is no hexadecimal number of at most 64 bits.
    Code {
        /// Its place in the list.
        id: usize,
        /// What stands there.
        text: String,
    },
    /// Codes and layout make no family.
    Family(FamilyError),
    /// Two codes are closer than the distance that the file states.
    TooClose {
        /// Which.
        found: TooClose,
        /// What the file states.
        distance: u32,
    },
    /// A word that is none of those allowed.
    Word {
        /// The key.
        key: &'static str,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// The recipe is impossible.
    Recipe(RecipeError),
}

impl fmt::Display for FileError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileError::Form(message) => out.write_str(message),
            FileError::Layout(error) => write!(out, "layout: {error}"),
            FileError::Code { id, text } => {
                write!(
                    out,
                    "codes: id {id} is {text:?}, but a code is a hexadecimal number of at most 64 bits such as \"0x1a2b\""
                )
            }
            FileError::Family(error) => write!(out, "codes: {error}"),
            FileError::TooClose { found: TooClose { first, second, bits }, distance } if first == second => {
                write!(
                    out,
                    "codes: id {first} differs from itself turned in {bits} bits, but the distance is {distance}: \
                 drop it or state a distance of {bits}"
                )
            }
            FileError::TooClose { found: TooClose { first, second, bits }, distance } => write!(
                out,
                "codes: ids {first} and {second} differ in {bits} bits when turned to each other, but the distance is {distance}: \
                 drop one of them or state a distance of {bits}"
            ),
            FileError::Word { key, value, allowed } => {
                write!(out, "recipe: {key} is {value:?}, but must be one of {allowed}")
            }
            FileError::Recipe(error) => write!(out, "recipe: {error}"),
        }
    }
}

impl std::error::Error for FileError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::FAMILIES;

    fn small() -> FamilyFile {
        let family = Family::published("tag16h5").unwrap();
        let recipe = FAMILIES[0].recipe().unwrap();
        FamilyFile { family, recipe: Some(recipe), decided: Some(65_536), complete: true }
    }

    #[test]
    fn files_are_read_back_to_the_same() {
        for published in FAMILIES.iter().filter(|family| family.count < 3000) {
            let family = Family::published(published.name).unwrap();
            let whole = FamilyFile {
                recipe: Some(published.recipe().unwrap()),
                decided: Some(1 << 40),
                complete: false,
                ..FamilyFile::of(family.clone())
            };
            for file in [whole, FamilyFile::of(family)] {
                assert_eq!(FamilyFile::parse(&file.to_text()), Ok(file), "{}", published.name);
            }
        }
    }

    #[test]
    fn names_of_any_letters_are_read_back() {
        let layout = Layout::classic(8).unwrap();
        let file = FamilyFile::of(Family::new("a \"b\"\\\n#ü", layout, vec![0x27c8], 5).unwrap());
        assert_eq!(FamilyFile::parse(&file.to_text()), Ok(file));
    }

    /// What the message says when `from` is replaced by `to` in the small family's file.
    fn refused(from: &str, to: &str) -> String {
        let text = small().to_text();
        assert!(text.contains(from), "{from} is not in {text}");
        FamilyFile::parse(&text.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let second = format!("{:#06x}", small().family.codes()[1]);
        let cases = [
            ("distance =", "distances =", "unknown field `distances`"),
            ("name = \"tag16h5\"\n", "", "missing field `name`"),
            ("distance = 5", "distance = \"five\"", "line 4"),
            ("wwwwwwww\n", "wwwwwwwd\n", "(7, 0)"),
            ("wwwwwwww\n", "wwwwwww\n", "63"),
            ("wbbbbbbw\n", "wbbqbbbw\n", "'q'"),
            (second.as_str(), "0x1ffff", "code 1 is 0x1ffff"),
            (second.as_str(), "0xx", "id 1 is \"0xx\""),
            (second.as_str(), "+12", "id 1 is \"+12\""),
            ("distance = 5", "distance = 6", "differ"),
            ("distance = 5", "distance = 17", "17"),
            ("data-rectangles", "area", "metric is \"area\", but must be one of ising"),
            ("\"rows\"", "\"columns\"", "bit-order is \"columns\""),
        ];
        for (from, to, expected) in cases {
            let message = refused(from, to);
            assert!(message.contains(expected), "{from:?} -> {to:?}: {message}");
        }
    }

    #[test]
    fn codes_that_are_too_close_are_named() {
        let codes = small().family.codes().to_vec();
        let [first, second] = [codes[0], codes[1]].map(|code| format!("{code:#06x}"));
        assert!(refused(&second, &first).contains("code 1"));
        let near = format!("{:#06x}", small().family.layout().rotate90(codes[0]) ^ 1);
        let message = refused(&second, &near);
        assert!(message.contains("ids 0 and 1 differ in 1 bits"), "{message}");
        let own = refused(&first, "0xffff");
        assert!(own.contains("id 0 differs from itself turned in 0 bits"), "{own}");
    }
}
