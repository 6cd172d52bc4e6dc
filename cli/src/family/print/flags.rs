//! What can be asked of a print.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_family::Family;
use tagbus_family::print::{Grouping, Length, Paper, Size};

use crate::chosen_family::ChosenFamily;
use crate::config::text;
use crate::outcome::Failure;

#[derive(Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct PrintFlags {
    /// Side of the border edge, such as 160mm; units mm, cm, m, in
    #[arg(long, value_name = "LENGTH", conflicts_with = "printed_size")]
    #[serde(default, with = "text::optional")]
    tag_size: Option<Length>,
    /// Side of the whole print
    #[arg(long, value_name = "LENGTH")]
    #[serde(default, with = "text::optional")]
    printed_size: Option<Length>,
    /// a4, letter or width and height such as 300x400mm; bare: the tag and its margin alone, a file or page each. By default a4,
    /// and bare for PNG
    #[arg(long, value_name = "PAGE")]
    #[serde(default, with = "text::optional")]
    page: Option<PageChoice>,
    /// Tags, boards on a page at most; by default as many as fit
    #[arg(long, value_name = "N")]
    pub(super) per_page: Option<usize>,
    /// White around each tag or board, beside what the layout has
    #[arg(long, value_name = "LENGTH", default_value = "0mm")]
    #[serde(with = "text")]
    pub(super) margin: Length,
    /// Boards of so many rows and columns, such as 3x4: ids row after row from the top
    #[arg(long, value_name = "RxC", requires = "spacing")]
    #[serde(default, with = "text::optional")]
    board: Option<BoardShape>,
    /// Between two prints of a board
    #[arg(long, value_name = "LENGTH")]
    #[serde(default, with = "text::optional")]
    spacing: Option<Length>,
    /// Tags within tags, the outermost first: NAME:ID,NAME:ID,...
    #[arg(long, value_name = "LIST", conflicts_with = "board")]
    #[serde(default, with = "text::optional")]
    pub(super) nest: Option<NestList>,
    /// Write where the tags' corners are to this file, .toml or .json
    #[arg(long, value_name = "FILE")]
    pub(super) geometry: Option<PathBuf>,
    /// The file to write
    #[arg(long, value_name = "PATH", required_unless_present = "print_config")]
    pub(super) output: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    pub(super) force: bool,
}

impl PrintFlags {
    pub(super) fn size(&self) -> Result<Size, Failure> {
        match (self.tag_size, self.printed_size) {
            (Some(side), None) => Ok(Size::Tag(side)),
            (None, Some(side)) => Ok(Size::Printed(side)),
            (None, None) => Err(Failure::new("give a size: --tag-size or --printed-size, such as 160mm")),
            (Some(_), Some(_)) => Err(Failure::new("give one size: --tag-size or --printed-size, not both")),
        }
    }

    /// The paper; `None` for bare tags.
    pub(super) fn paper(&self, format: Format) -> Option<Paper> {
        match (&self.page, format) {
            (Some(choice), _) => choice.paper.clone(),
            (None, Format::Png) => None,
            (None, Format::Svg | Format::Pdf) => "a4".parse().ok(),
        }
    }

    pub(super) fn grouping(&self) -> Result<Option<Grouping>, Failure> {
        match (&self.board, self.spacing) {
            (None, None) => Ok(None),
            (Some(BoardShape { rows, columns }), Some(spacing)) => {
                Ok(Some(Grouping { rows: *rows, columns: *columns, spacing }))
            }
            _ => Err(Failure::new("--board RxC and --spacing go together: give both or neither")),
        }
    }
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Svg,
    Pdf,
    Png,
}

impl Format {
    /// The format that is named, else the one that the output's name ends in.
    pub(super) fn of(named: Option<&str>, output: Option<&Path>) -> Result<Self, Failure> {
        let extension = output.and_then(Path::extension).unwrap_or_default().to_string_lossy();
        let name = named.unwrap_or(&extension);
        match name.to_ascii_lowercase().as_str() {
            "svg" => Ok(Self::Svg),
            "pdf" => Ok(Self::Pdf),
            "png" => Ok(Self::Png),
            _ => Err(Failure::new(format!(
                "{name:?} is no format to print in: give --format svg, pdf or png, or an --output that ends in one"
            ))),
        }
    }
}

/// Paper, or none.
#[derive(Clone, Debug)]
struct PageChoice {
    written: String,
    paper: Option<Paper>,
}

impl FromStr for PageChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let paper = match text {
            "bare" => None,
            _ => Some(text.parse::<Paper>().map_err(|error| format!("{error}; or bare"))?),
        };
        Ok(Self { written: text.to_owned(), paper })
    }
}

impl fmt::Display for PageChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.written)
    }
}

/// Rows and columns.
#[derive(Clone, Copy, Debug)]
struct BoardShape {
    rows: usize,
    columns: usize,
}

impl FromStr for BoardShape {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = |text: &str| text.parse::<usize>().ok().filter(|count| (1..=1000).contains(count));
        let counts = text.split_once('x').and_then(|(rows, columns)| Some((count(rows)?, count(columns)?)));
        let (rows, columns) = counts.ok_or_else(|| {
            format!("{text:?} is no board: write rows and columns, 1 to 1000 each, such as 3x4")
        })?;
        Ok(Self { rows, columns })
    }
}

impl fmt::Display for BoardShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

/// Tags within tags.
#[derive(Clone, Debug)]
pub(super) struct NestList(Vec<(ChosenFamily, u32)>);

impl NestList {
    pub(super) fn tags(&self) -> Vec<(&Family, u32)> {
        self.0.iter().map(|(chosen, id)| (chosen.family(), *id)).collect()
    }
}

impl FromStr for NestList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let tag = |text: &str| {
            let form = || format!("{text:?} is no tag to nest: write NAME:ID, such as tagCustom48h12:0");
            let (name, id) = text.rsplit_once(':').ok_or_else(form)?;
            let family = name.trim().parse::<ChosenFamily>().map_err(|error| error.to_string())?;
            Ok((family, id.trim().parse().map_err(|_| form())?))
        };
        text.split(',').map(tag).collect::<Result<_, String>>().map(Self)
    }
}

impl fmt::Display for NestList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tags: Vec<String> = self.0.iter().map(|(family, id)| format!("{family}:{id}")).collect();
        f.write_str(&tags.join(","))
    }
}
