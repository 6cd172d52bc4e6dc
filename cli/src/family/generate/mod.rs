//! `tagbus family generate`: searches the codes of a family.

mod progress;
mod published;
mod saved;
mod wish;
mod work;

use std::fmt::Display;
use std::io::{self, Write};
use std::num::NonZero;
use std::path::PathBuf;
use std::thread;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_family::file::FamilyFile;
use tagbus_family::search::{Ending, Level, Limits, Search, State};
use tagbus_family::{Family, Recipe};

use crate::chosen_family::check_name;
use crate::new_file::{self, Existing};
use crate::outcome::{Failure, Outcome};
use wish::Share;
use work::Work;

/// What is searched, and how.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct GenerateFlags {
    /// The cells: classic:N, standard:N, circle:N, or N x N letters row after row: w white, b black, d data, x not part of the tag
    #[arg(long, value_name = "LAYOUT")]
    layout: Option<String>,
    /// A file with the letters of the layout
    #[arg(long, value_name = "FILE", conflicts_with = "layout")]
    layout_file: Option<PathBuf>,
    /// Bits in which any two tags differ at least, however they are turned: 2 k + 1 to correct k wrong bits
    #[arg(long, value_name = "BITS")]
    distance: Option<u32>,
    /// The same as --distance
    #[arg(long, value_name = "BITS", conflicts_with = "distance")]
    hamming: Option<u32>,
    /// How complexity is measured: ising, rectangles, components, or data-rectangles (square data inside the border, 2 to 8 cells wide)
    #[arg(long, value_name = "METRIC", default_value = "ising")]
    metric: String,
    /// The least complexity that a tag may have; by default what the published families ask for, or as strict
    #[arg(long, value_name = "COMPLEXITY")]
    threshold: Option<u32>,
    /// A number that chooses the order of candidates: another number, another family
    #[arg(long, value_name = "NUMBER", default_value_t = 10)]
    seed_complexity: u32,
    /// End with so many codes
    #[arg(long, value_name = "COUNT")]
    codes: Option<usize>,
    /// End after so many candidates; by default all are searched, which takes days from 45 bits on
    #[arg(long, value_name = "COUNT")]
    candidates: Option<u64>,
    /// Threads; by default as many as there are processors. The codes do not depend on it
    #[arg(long, value_name = "COUNT")]
    threads: Option<NonZero<usize>>,
    /// Instructions to use, by default the best: portable, popcnt, avx2, avx512. The codes do not depend on it
    #[arg(long, value_name = "LEVEL")]
    level: Option<String>,
    /// Keep the state of the search in this file every few seconds, and go on from it when it is there
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Name of the family; by default that of the file
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// The family file to write
    #[arg(long, value_name = "FILE.toml")]
    output: Option<PathBuf>,
    /// Replace the output file if it exists
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    force: bool,
    /// Search a published family again and compare it, instead of a layout: its name, or all
    #[arg(long, value_name = "NAME|all", conflicts_with_all = ["layout", "layout_file", "distance", "hamming", "threshold"])]
    published: Option<String>,
    /// With --published: go on where the published search was stopped
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    complete: bool,
}

/// Searches, writes the family and tells about it.
pub(super) fn execute(flags: &GenerateFlags) -> Result<Outcome, Failure> {
    if let Some(name) = &flags.published {
        return published::execute(flags, name);
    }
    let output = flags
        .output
        .as_ref()
        .ok_or_else(|| Failure::new("say with --output FILE.toml where the family goes"))?;
    let existing = if flags.force { Existing::Replace } else { Existing::Keep };
    new_file::check(output, existing)?;
    let name = flags.name.clone().unwrap_or_else(|| name_of(output));
    check_name(&name)?;
    let recipe = wish::recipe(flags)?;
    tell(wish::describe(&recipe));
    let (state, ending) = search(flags, &recipe, flags.codes)?;
    if state.found.is_empty() {
        return Err(nothing_found(&recipe, &state));
    }
    let file = family_file(name, &recipe, &state, ending)?;
    new_file::write(output, file.to_text().as_bytes(), existing)?;
    tell(told(&file, ending, flags));
    tell(format!("wrote {}; use it: tagbus detect --family {0} PICTURE", output.display()));
    Ok(Outcome::Done)
}

/// A line on the standard output. Whoever read it may have gone, which is no reason to lose a search.
fn tell(line: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{line}");
}

/// Does the search as the flags say, up to a number of codes.
fn search(flags: &GenerateFlags, recipe: &Recipe, codes: Option<usize>) -> Result<(State, Ending), Failure> {
    let limits = Limits { codes, candidates: flags.candidates };
    let search = Search::new(recipe.clone())
        .with_limits(limits)
        .with_threads(threads(flags))
        .with_level(level(flags)?);
    let mut state = match &flags.resume {
        Some(path) => saved::load(path, recipe)?.unwrap_or_default(),
        None => State::default(),
    };
    let ending = Work::new(recipe, flags.resume.as_deref(), codes)?.run(&search, &mut state)?;
    Ok((state, ending))
}

fn threads(flags: &GenerateFlags) -> usize {
    flags.threads.or_else(|| thread::available_parallelism().ok()).map_or(1, NonZero::get)
}

fn level(flags: &GenerateFlags) -> Result<Level, Failure> {
    Ok(match &flags.level {
        Some(name) => Level::named(name)?,
        None => Level::best(),
    })
}

fn name_of(output: &std::path::Path) -> String {
    output.file_stem().map_or_else(|| "family".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

fn family_file(name: String, recipe: &Recipe, state: &State, ending: Ending) -> Result<FamilyFile, Failure> {
    let family = Family::new(&name, recipe.layout().clone(), recipe.codes(&state.found), recipe.distance())?;
    let complete = ending == Ending::Complete;
    Ok(FamilyFile { family, recipe: Some(recipe.clone()), decided: Some(state.decided), complete })
}

/// What came of it, and how to go on when that is possible.
fn told(file: &FamilyFile, ending: Ending, flags: &GenerateFlags) -> String {
    let (count, decided) = (file.family.codes().len(), file.decided.unwrap_or(0));
    let how = match ending {
        Ending::Complete => "no tag can be added".to_owned(),
        Ending::Limited => format!("the limit was reached after {decided} candidates"),
        Ending::Stopped => format!("stopped after {decided} candidates that are decided for good"),
    };
    let more = match (&flags.resume, ending) {
        (_, Ending::Complete) => String::new(),
        (Some(path), _) => {
            format!("; the same command with another --output goes on from {}", path.display())
        }
        (None, _) => "; with --resume FILE a search can go on where it was stopped".to_owned(),
    };
    format!("{count} tags: {how}{more}")
}

/// Why there is no code: the rule that refuses most is named.
fn nothing_found(recipe: &Recipe, state: &State) -> Failure {
    let Share { complex, own_distance } = Share::of(recipe);
    Failure::new(format!(
        "no code was found among {} candidates: of random codes {:.2} % are complex enough ({} of at least {}: --threshold) and {:.2} % are \
         {} bits away from their own rotations (--distance)",
        state.decided,
        complex * 100.0,
        recipe.rule().metric,
        recipe.rule().least,
        own_distance * 100.0,
        recipe.distance()
    ))
}
