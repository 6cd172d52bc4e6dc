//! The one binary `tagbus`: every flag, signal and exit code of the project.
//!
//! ```text
//! command line ─▶ command ─▶ flags over file over defaults ─▶ one module a subcommand ─▶ outcome ─▶ exit code
//!                             (config)                         family, detect, camera,    0 done
//!                                                              service, watch, run,       1 nothing found, 2 failed
//!                                                              top, control
//! ```
#![forbid(unsafe_code)]

mod command;
mod config;
mod flags;
mod new_file;
mod outcome;
mod output;
mod role;
mod tag_json;
mod units;

mod camera;
mod chosen_family;
mod control;
mod detect;
mod family;
mod run;
mod service;
mod top;
mod watch;

fn main() -> std::process::ExitCode {
    outcome::conclude(command::execute())
}
