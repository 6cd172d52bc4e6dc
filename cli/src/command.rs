//! The commands, and what is the same for all of them.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{ArgMatches, Args, Command as ClapCommand, CommandFactory, FromArgMatches, Parser, Subcommand};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::camera::CameraCommand;
use crate::config::{self, File};
use crate::control::ControlCommand;
use crate::detect::DetectCommand;
use crate::family::FamilyCommand;
use crate::outcome::{Failure, Outcome};
use crate::run::RunCommand;
use crate::service::ServiceCommand;
use crate::top::TopCommand;
use crate::watch::WatchCommand;
use crate::{camera, control, detect, family, run, service, top, watch};

/// A perception bus for AprilTags: frames in shared memory, tags a few microseconds after the detector knows them.
#[derive(Parser)]
#[command(name = "tagbus", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 done, 1 nothing found, 2 failed.

Every flag is also a key of the configuration file: --config FILE, else
$XDG_CONFIG_HOME/tagbus/tagbus.toml, else /etc/tagbus/tagbus.toml.
Flags win over the file.")]
struct CommandLine {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

/// Flags that are no keys of the file.
#[derive(Args)]
struct Common {
    /// Configuration file (TOML)
    #[arg(long, value_name = "FILE", global = true)]
    config: Option<PathBuf>,
    /// Show what is in force, as a configuration file, and end
    #[arg(long, global = true)]
    print_config: bool,
    /// End with this parent process, whose number it is; how `tagbus run` starts its processes
    #[arg(long, value_name = "PID", global = true, hide = true)]
    die_with_parent: Option<i32>,
}

#[derive(Subcommand)]
enum Command {
    Run(RunCommand),
    Camera(CameraCommand),
    Service(ServiceCommand),
    Watch(WatchCommand),
    Top(TopCommand),
    #[command(subcommand)]
    Control(ControlCommand),
    Detect(DetectCommand),
    #[command(subcommand)]
    Family(FamilyCommand),
}

/// What a command is run with.
pub(crate) struct Invocation<'a> {
    given: &'a ArgMatches,
    known: Vec<String>,
    file: File,
    print_config: bool,
    parent: Option<i32>,
}

/// Reads the command line and does what it says.
pub(crate) fn execute() -> Result<Outcome, Failure> {
    let given = CommandLine::command().get_matches();
    let line = CommandLine::from_arg_matches(&given)?;
    let known = known_keys(&CommandLine::command());
    let invocation = Invocation {
        given: innermost(&given),
        file: File::find(line.common.config.as_deref(), &known)?,
        known,
        print_config: line.common.print_config,
        parent: line.common.die_with_parent,
    };
    match line.command {
        Command::Run(command) => run::execute(command, &invocation),
        Command::Camera(command) => camera::execute(command, &invocation),
        Command::Service(command) => service::execute(command, &invocation),
        Command::Watch(command) => watch::execute(command, &invocation),
        Command::Top(command) => top::execute(command, &invocation),
        Command::Control(command) => control::execute(command, &invocation),
        Command::Detect(command) => detect::execute(command, &invocation),
        Command::Family(command) => family::execute(command, &invocation),
    }
}

impl Invocation<'_> {
    /// The flags in force; `None` when they were to be printed, which is done then.
    pub(crate) fn in_force<F>(&self, flags: F) -> Result<Option<F>, Failure>
    where
        F: Args + Serialize + DeserializeOwned,
    {
        let flags = config::in_force(flags, self.given, &self.file)?;
        if !self.print_config {
            return Ok(Some(flags));
        }
        let text = config::print(&flags, &self.file)?;
        std::io::stdout().lock().write_all(text.as_bytes())?;
        Ok(None)
    }

    /// The flags that would be in force if the command was started now.
    pub(crate) fn in_force_now<F>(&self, flags: F) -> Result<F, Failure>
    where
        F: Args + Serialize + DeserializeOwned,
    {
        Ok(config::in_force(flags, self.given, &self.file.again(&self.known)?)?)
    }

    /// Where the configuration file lies, if there is one.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.file.path.as_deref()
    }

    /// The process with whose end this one has to end.
    pub(crate) fn parent(&self) -> Option<i32> {
        self.parent
    }
}

/// What was given to the innermost command, `list` in `family list`.
fn innermost(given: &ArgMatches) -> &ArgMatches {
    given.subcommand().map_or(given, |(_, inner)| innermost(inner))
}

/// The flags of all commands: one file serves them all.
fn known_keys(command: &ClapCommand) -> Vec<String> {
    let own = command.get_arguments().filter(|arg| !arg.is_global_set() && !arg.is_hide_set());
    let mut keys: Vec<String> = own.filter_map(|arg| arg.get_long().map(str::to_owned)).collect();
    keys.extend(command.get_subcommands().flat_map(known_keys));
    keys.sort_unstable();
    keys.dedup();
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }

    #[test]
    fn every_flag_is_a_key_and_what_concerns_the_file_itself_is_not() {
        let keys = known_keys(&CommandLine::command());
        for key in ["decimate", "min-margin", "family", "json"] {
            assert!(keys.iter().any(|known| known == key), "{key} is missing in {keys:?}");
        }
        for key in ["config", "print-config", "help", "version"] {
            assert!(keys.iter().all(|known| known != key), "{key} is in {keys:?}");
        }
    }
}
