//! `tagbus service`: frames in, detections out.

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_service::{ServiceConfig, run};

use crate::command::Invocation;
use crate::flags::{BusFlags, DetectorFlags, DetectorName, RegionFlag};
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
    pub(crate) part: RegionFlag,
}

/// Detects until somebody ends it.
pub(crate) fn execute(command: ServiceCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let stop = role::stop(invocation.parent())?;
    let settings = flags.detector.settings()?;
    let mut config = ServiceConfig::new(flags.bus.domain()?, flags.detector.families()?);
    config.camera = flags.bus.camera;
    config.detector = flags.name.detector;
    config.settings = settings;
    config.region = flags.part.region;
    let role = format!("detector {} of {}", config.detector, config.camera);
    config.report = Box::new(move |report| complain(format_args!("{role}: {report}")));
    run(config, stop)?;
    Ok(Outcome::Done)
}
