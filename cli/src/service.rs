//! `tagbus service`: frames in, detections out.

use std::str::FromStr;
use std::thread;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_message::stop::Stop;
use tagbus_service::{ServiceConfig, run};

use crate::command::Invocation;
use crate::config::as_toml;
use crate::flags::{BusFlags, DetectorFlags, DetectorName, ServingFlags};
use crate::outcome::{Failure, Outcome, complain};
use crate::role;

/// Find tags in the frames of a camera and publish them
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus service
  tagbus service --camera cam1 --family tagStandard41h12,tag36h11 --decimate 1
  tagbus service --detector near --decimate 3 --ids 1-20
  tagbus service --region 320,0,640x480

The camera may start later, end, and start again. All parameters can be changed
while it runs: tagbus control detector.")]
pub(crate) struct ServiceCommand {
    #[command(flatten)]
    flags: ServiceFlags,
    /// Another detector in this process, as a configuration file; how `tagbus run` lets detectors share one
    #[arg(long, value_name = "TOML", hide = true)]
    also: Vec<Also>,
}

/// The flags of another detector.
#[derive(Clone, Debug)]
struct Also(ServiceFlags);

impl FromStr for Also {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text).map(Self)
    }
}

/// Everything that a service is told.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct ServiceFlags {
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) bus: BusFlags,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) name: DetectorName,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) detector: DetectorFlags,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) serving: ServingFlags,
}

impl ServiceFlags {
    /// The text from which the same flags are read.
    pub(crate) fn as_toml(&self) -> Result<String, Failure> {
        Ok(as_toml(self)?)
    }

    fn config(self) -> Result<ServiceConfig, Failure> {
        let mut config = ServiceConfig::new(self.bus.domain()?, self.detector.families()?);
        config.settings = self.detector.settings()?;
        config.camera = self.bus.camera;
        config.detector = self.name.detector;
        config.region = self.serving.region;
        config.always = self.serving.always;
        let role = format!("detector {} of {}", config.detector, config.camera);
        config.report = Box::new(move |report| complain(format_args!("{role}: {report}")));
        Ok(config)
    }
}

/// Detects until somebody ends it.
pub(crate) fn execute(command: ServiceCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let stop = role::stop(invocation.parent())?;
    let mut configs = vec![flags.config()?];
    for Also(flags) in command.also {
        configs.push(flags.config()?);
    }
    detect_all(configs, &stop)
}

/// A thread for each detector. The end of one is the end of all: whoever looks after the process starts all of them again.
fn detect_all(configs: Vec<ServiceConfig>, stop: &Stop) -> Result<Outcome, Failure> {
    thread::scope(|scope| {
        let start = |config: ServiceConfig| {
            let (end, stop) = (EndOfAll(stop.clone()), stop.clone());
            let name = format!("{} of {}", config.detector, config.camera);
            thread::Builder::new().name(name).spawn_scoped(scope, move || {
                let _end = end;
                run(config, stop)
            })
        };
        let threads = configs.into_iter().map(start).collect::<Result<Vec<_>, _>>()?;
        for thread in threads {
            match thread.join() {
                Ok(result) => drop(result?),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        Ok(Outcome::Done)
    })
}

/// Ends all detectors when one ends, even by a panic.
struct EndOfAll(Stop);

impl Drop for EndOfAll {
    fn drop(&mut self) {
        self.0.trigger();
    }
}
