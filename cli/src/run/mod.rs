//! `tagbus run`: camera, service and watch at once, or a whole machine: each its own process.

mod child;
mod live;
mod machine;
mod part;
mod plan;
mod reload;
mod supervise;

use std::time::Duration;

use clap::Args;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::camera::{CameraFlags, SourceFlags};
use crate::chosen_family::FamilyList;
use crate::command::Invocation;
use crate::flags::{BusFlags, DetectorFlags, DetectorName, ServingFlags};
use crate::outcome::{Failure, Outcome};
use crate::service::ServiceFlags;
use crate::watch::{ViewFlags, WatchFlags};
use child::Role;
use part::Part;
use plan::Plan;
use supervise::{Events, Supervisor};

/// Camera, service and watch at once, or a whole machine: each its own process
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus run                                     the built-in scene
  tagbus run --source replay:recording/ --family tagStandard41h12
  tagbus run --json --seconds 10 > detections.jsonl
  tagbus run --config robot.toml                 every camera and detector of a machine

Ctrl-C ends all of them, and they leave nothing behind. A camera or service that
crashes is started again.

A file with a table for each camera describes a machine:
  domain = \"robot\"
  [cameras.front]
  source = \"v4l:/dev/video0\"
  [cameras.front.detectors.near]
  decimate = 1
  [cameras.rear]
  source = \"rpicam\"
When the file changes, or at SIGHUP, it is read again: parameters of detectors
change while they run, and only what cannot is started anew.")]
pub(crate) struct RunCommand {
    #[command(flatten)]
    flags: RunFlags,
}

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct RunFlags {
    /// The file's table of cameras: a whole machine
    #[arg(skip)]
    #[serde(default)]
    cameras: Option<Table>,
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
    serving: ServingFlags,
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

    /// The processes of a machine, or the three of a first look.
    fn parts(self) -> Result<Vec<Part>, Failure> {
        match &self.cameras {
            Some(cameras) => machine::parts(&self, cameras),
            None => self.three(),
        }
    }

    /// Those who listen come first: less is missed.
    fn three(self) -> Result<Vec<Part>, Failure> {
        let Self { bus, name, view, source, mut detector, serving, .. } = self;
        if detector.family.is_none() && source.is_scene() {
            detector.family = Some(FamilyList::of_scene()?);
        }
        let watch = WatchFlags { bus: bus.clone(), name: name.clone(), view };
        let service = ServiceFlags { bus: bus.clone(), name, detector, serving };
        let camera = CameraFlags::new(bus, source);
        Ok(vec![
            Part::only(Role::Watch, &watch)?,
            Part::only(Role::Service, &service)?,
            Part::only(Role::Camera, &camera)?,
        ])
    }
}

/// Runs all of them until one ends by itself (of a machine: all), the time is over or somebody ends it.
pub(crate) fn execute(command: RunCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let given = command.flags.clone();
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let (domain, limit) = (flags.bus.domain()?, flags.limit()?);
    let machine = flags.cameras.as_ref().and(invocation.file());
    let plan = machine.map(|path| {
        let read = move || invocation.in_force_now(given.clone()).and_then(RunFlags::parts);
        Plan::new(path.to_owned(), Box::new(read))
    });
    // Before the first child, so that no signal is missed.
    let events = Events::start(plan.is_some())?;
    let outcome = Supervisor::new(flags.parts()?, events, limit, plan).work();
    // What killed roles left. Where that is not possible the roles have said why.
    let _ = domain.clean_up_if_unused();
    outcome
}
