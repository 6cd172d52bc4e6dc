//! `tagbus run`: camera, service and watch at once, each its own process.

mod child;
mod supervise;

use std::time::Duration;

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::camera::{CameraFlags, SourceFlags};
use crate::chosen_family::FamilyList;
use crate::command::Invocation;
use crate::config::arguments;
use crate::flags::{BusFlags, DetectorFlags, DetectorName, RegionFlag};
use crate::outcome::{Failure, Outcome};
use crate::service::ServiceFlags;
use crate::watch::{ViewFlags, WatchFlags};
use child::{Child, Role};
use supervise::{Events, Supervisor};

/// Camera, service and watch at once, each its own process
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus run                                     the built-in scene
  tagbus run --source replay:recording/ --family tagStandard41h12
  tagbus run --json --seconds 10 > detections.jsonl

Ctrl-C ends all three, and they leave nothing behind. A camera or service that
crashes is started again.")]
pub(crate) struct RunCommand {
    #[command(flatten)]
    flags: RunFlags,
}

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct RunFlags {
    /// End after so long
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    view: ViewFlags,
    #[command(flatten)]
    #[serde(flatten)]
    bus: BusFlags,
    #[command(flatten)]
    #[serde(flatten)]
    name: DetectorName,
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceFlags,
    #[command(flatten)]
    #[serde(flatten)]
    detector: DetectorFlags,
    #[command(flatten)]
    #[serde(flatten)]
    part: RegionFlag,
}

impl RunFlags {
    fn limit(&self) -> Result<Option<Duration>, Failure> {
        let duration = |seconds| {
            Duration::try_from_secs_f64(seconds).map_err(|_| {
                Failure::new(format!("{seconds} seconds are not possible: use a number such as 10"))
            })
        };
        self.seconds.map(duration).transpose()
    }

    /// The three processes. Those who listen come first: less is missed.
    fn children(self) -> Result<[Child; 3], Failure> {
        let Self { bus, name, view, source, mut detector, part, .. } = self;
        if detector.family.is_none() && source.is_scene() {
            detector.family = Some(FamilyList::of_scene()?);
        }
        let watch = WatchFlags { bus: bus.clone(), name: name.clone(), view };
        let service = ServiceFlags { bus: bus.clone(), name, detector, part };
        let camera = CameraFlags::new(bus, source);
        Ok([
            Child::new(Role::Watch, arguments(&watch)?)?,
            Child::new(Role::Service, arguments(&service)?)?,
            Child::new(Role::Camera, arguments(&camera)?)?,
        ])
    }
}

/// Runs all three until one of them ends by itself, the time is over or somebody ends it.
pub(crate) fn execute(command: RunCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let (domain, limit) = (flags.bus.domain()?, flags.limit()?);
    // Before the first child, so that no signal is missed.
    let events = Events::start()?;
    let supervisor = Supervisor::new(flags.children()?, events, limit);
    let outcome = supervisor.work();
    // What killed roles left. Where that is not possible the roles have said why.
    let _ = domain.clean_up_if_unused();
    outcome
}
