//! `tagbus family`: what the published families are and what their tags look like.

mod check;
mod choose;
mod draw;
mod explain;
mod generate;
mod import;
mod list;
mod print;
mod show;

use clap::{Args, Subcommand};
use serde::{Deserialize, Serialize};

use crate::chosen_family::ChosenFamily;
use crate::command::Invocation;
use crate::outcome::{Failure, Outcome};

/// Tag families: which there are, what they look like
#[derive(Subcommand)]
pub(crate) enum FamilyCommand {
    /// All published families in a table
    #[command(after_help = "Examples:\n  tagbus family list\n  tagbus family list --json")]
    List {
        #[command(flatten)]
        flags: Format,
    },
    /// One family: layout, sizes, shape
    #[command(
        after_help = "Examples:\n  tagbus family show tagStandard41h12\n  tagbus family show 36h11 --json"
    )]
    Show {
        /// The family, such as tag36h11, 36h11, or a file of your own, FILE.toml
        name: ChosenFamily,
        #[command(flatten)]
        flags: Format,
    },
    /// Whether a family is what it says: layout, distances, complexity, false accepts
    #[command(
        after_help = "Examples:\n  tagbus family check tagStandard41h12\n  tagbus family check mine.toml --json\n\nExit code 2 when it is not what it says."
    )]
    Check {
        /// The family, such as tag36h11, 36h11, or a file of your own, FILE.toml
        name: ChosenFamily,
        #[command(flatten)]
        flags: Format,
    },
    /// Which published family suits a number of tags and a shape, and why not the others
    #[command(
        after_help = "Examples:\n  tagbus family choose --ids 100\n  tagbus family choose --ids 20 --shape hole --json"
    )]
    Choose {
        /// How many different tags are needed
        #[arg(long = "count", visible_alias = "ids", value_name = "COUNT")]
        count: usize,
        /// What the print looks like
        #[arg(long, value_enum, default_value_t = choose::Shape::Square)]
        shape: choose::Shape,
        #[command(flatten)]
        flags: Format,
    },
    /// Search the codes of a new family, or those of a published one again
    #[command(after_help = GENERATE_EXAMPLES)]
    Generate {
        #[command(flatten)]
        flags: generate::GenerateFlags,
    },
    /// One tag: drawn in the terminal, its bits, its code
    #[command(
        after_help = "Examples:\n  tagbus family explain tag36h11 7\n  tagbus family explain tagCustom48h12 0 --json"
    )]
    Explain {
        /// The family, such as tag36h11, 36h11, or a file of your own, FILE.toml
        name: ChosenFamily,
        /// The tag's number in the family
        id: u32,
        #[command(flatten)]
        flags: Format,
    },
    Import(import::ImportCommand),
    Print(Box<print::PrintCommand>),
}

const GENERATE_EXAMPLES: &str = "Examples:
  tagbus family generate --layout standard:8 --distance 9 --output mine.toml
  tagbus family generate --layout-file cells.txt --distance 11 --codes 500 --resume mine.state --output mine.toml
  tagbus family generate --published tag36h11
  tagbus family generate --published all

Ctrl-C writes the codes found so far. With --resume the search goes on from there, and after kill -9 from a few seconds before.";

/// How answers are written.
#[derive(Clone, Copy, Debug, Args, Serialize, Deserialize)]
pub(crate) struct Format {
    /// Answer in JSON, one line a family or tag
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    json: bool,
}

/// Does what was asked for.
pub(crate) fn execute(command: FamilyCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    match command {
        FamilyCommand::List { flags } => answer(flags, invocation, list::execute),
        FamilyCommand::Show { name, flags } => {
            answer(flags, invocation, |json| show::execute(name.family(), json))
        }
        FamilyCommand::Check { name, flags } => answer(flags, invocation, |json| check::execute(&name, json)),
        FamilyCommand::Explain { name, id, flags } => {
            answer(flags, invocation, |json| explain::execute(name.family(), id, json))
        }
        FamilyCommand::Import(command) => import::execute(command, invocation),
        FamilyCommand::Choose { count, shape, flags } => {
            answer(flags, invocation, |json| choose::execute(count, shape, json))
        }
        FamilyCommand::Generate { flags } => match invocation.in_force(flags)? {
            Some(flags) => generate::execute(&flags),
            None => Ok(Outcome::Done),
        },
        FamilyCommand::Print(command) => print::execute(*command, invocation),
    }
}

/// Answers as text or in JSON, unless only the flags were to be printed.
fn answer(
    flags: Format,
    invocation: &Invocation,
    tell: impl FnOnce(bool) -> Result<Outcome, Failure>,
) -> Result<Outcome, Failure> {
    match invocation.in_force(flags)? {
        Some(Format { json }) => tell(json),
        None => Ok(Outcome::Done),
    }
}
