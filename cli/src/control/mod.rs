//! `tagbus control`: ask and tell a detector or a camera that runs.

mod camera;
mod detector;
pub(crate) mod setting;

use std::time::Duration;

use clap::{Args, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};
use tagbus_client::ConnectOptions;

use crate::command::Invocation;
use crate::flags::{BusFlags, DetectorName};
use crate::outcome::{Failure, Outcome};
use crate::role;
use setting::Setting;

/// Ask and tell a detector or a camera while it runs
#[derive(Subcommand)]
pub(crate) enum ControlCommand {
    /// A detector: parameters, state, statistics
    #[command(after_help = "Examples:
  tagbus control detector                        all parameters, as NAME=VALUE
  tagbus control detector set decimate=1 ids=1-20,33 refine=tag
  tagbus control detector set family=tag36h11,tag25h9 hamming=default
  tagbus control detector set region=100,50,640x360
  tagbus control detector set region=none ids=all
  tagbus control detector state --camera cam1 --detector near --json
  tagbus control detector reset                  statistics begin anew

Names are those of the flags of `tagbus service`. All of a change is made between
two frames, or nothing of it; messages name its number (`change` of watch --json).
Families are published ones and those that the service was started with, by name.")]
    Detector(DetectorCommand),
    /// A camera: controls of its device, state, statistics
    #[command(after_help = "Examples:
  tagbus control camera                          all controls, as NAME=VALUE
  tagbus control camera set auto_exposure=manual_mode exposure_time_absolute=100
  tagbus control camera state --camera cam1 --json
  tagbus control camera reset                    statistics begin anew

Controls are set between two frames and read back. `tagbus camera --list` shows
their ranges; a camera without a device has none.")]
    Camera(CameraCommand),
}

/// What is asked, and of which detector.
#[derive(Args)]
pub(crate) struct DetectorCommand {
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    flags: DetectorControlFlags,
}

/// What is asked, and of which camera.
#[derive(Args)]
pub(crate) struct CameraCommand {
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    flags: ControlFlags,
}

/// What is asked.
#[derive(Args)]
struct Asked {
    /// What to do
    #[arg(value_enum, default_value_t = Action::Get)]
    action: Action,
    /// With set: other values, as NAME=VALUE
    #[arg(value_name = "NAME=VALUE")]
    settings: Vec<Setting>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Action {
    /// Print what is in force
    Get,
    /// Put other values in force
    Set,
    /// Let statistics begin anew
    Reset,
    /// Print state and statistics
    State,
}

impl Asked {
    /// Refuses values that nothing would be done with, and a change of nothing.
    fn check(&self) -> Result<(), Failure> {
        match (self.action, self.settings.first()) {
            (Action::Set, None) => Err(Failure::new("nothing to set: name at least one NAME=VALUE")),
            (Action::Set, Some(_)) | (_, None) => setting::check_names(&self.settings).map_err(Failure::new),
            (_, Some(setting)) => Err(Failure::new(format!(
                "{setting} has no meaning here: write `set {setting}` to put it in force"
            ))),
        }
    }
}

/// Where, and how it is answered.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct ControlFlags {
    #[command(flatten)]
    #[serde(flatten)]
    bus: BusFlags,
    /// The whole answer as one line of JSON
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    json: bool,
    /// How long to wait for somebody to be there, and for the answer
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0)]
    wait: f64,
}

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct DetectorControlFlags {
    #[command(flatten)]
    #[serde(flatten)]
    common: ControlFlags,
    #[command(flatten)]
    #[serde(flatten)]
    name: DetectorName,
}

impl ControlFlags {
    fn wait(&self) -> Result<Duration, Failure> {
        Duration::try_from_secs_f64(self.wait).map_err(|_| {
            Failure::new(format!("a wait of {} s is not possible: use a number such as 5", self.wait))
        })
    }

    fn options(&self, invocation: &Invocation) -> Result<ConnectOptions, Failure> {
        let stop = role::stop(invocation.parent())?;
        let options = ConnectOptions::in_domain(self.bus.domain()?).camera(&self.bus.camera).stop(stop);
        Ok(options.deadline(self.wait()?))
    }
}

/// Asks, and prints the answer.
pub(crate) fn execute(command: ControlCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    match command {
        ControlCommand::Detector(DetectorCommand { asked, flags }) => {
            asked.check()?;
            match invocation.in_force(flags)? {
                Some(flags) => detector::ask(&asked, &flags, invocation),
                None => Ok(Outcome::Done),
            }
        }
        ControlCommand::Camera(CameraCommand { asked, flags }) => {
            asked.check()?;
            match invocation.in_force(flags)? {
                Some(flags) => camera::ask(&asked, &flags, invocation),
                None => Ok(Outcome::Done),
            }
        }
    }
}
