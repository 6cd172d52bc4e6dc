//! `tagbus watch`: print detections as they come.

mod hops;
mod json;
mod late;
mod line;
mod screen;

use std::io::{self, Write};
use std::time::Duration;

use clap::Args;
use serde::{Deserialize, Serialize};
use tagbus_client::{Client, ConnectOptions, Detections, Stop};

use crate::command::Invocation;
use crate::flags::{BusFlags, DetectorName};
use crate::outcome::{Failure, Outcome, complain};
use crate::output::Reader;
use crate::role;
use hops::Hops;
use late::{Deadline, Late};
use screen::Screen;

/// Print the detections of a detector as they come
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus watch
  tagbus watch --camera cam1 --detector near
  tagbus watch --json --frames 100 | jq '.detections[].id'
  tagbus watch --frames 1 --timeout 5 || echo nothing
  tagbus watch --deadline 40                     say what is older than 40 ms when it comes, and why

Exit code 1: no message came in time, or none of the frames had a tag.")]
pub(crate) struct WatchCommand {
    #[command(flatten)]
    flags: WatchFlags,
}

/// Everything that a watcher is told.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct WatchFlags {
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) bus: BusFlags,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) name: DetectorName,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) view: ViewFlags,
}

/// What is printed, and for how long.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct ViewFlags {
    /// One line of JSON a frame
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    pub(crate) json: bool,
    /// End after so many frames
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u64>,
    /// End when no message comes for so long
    #[arg(long, value_name = "SECONDS")]
    pub(crate) timeout: Option<f64>,
    /// Say which detections are older than this when they arrive, and which hop took longer than usual; counted at the end
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub(crate) deadline: Option<f64>,
}

impl ViewFlags {
    fn timeout(&self) -> Result<Option<Duration>, Failure> {
        let duration = |seconds| {
            Duration::try_from_secs_f64(seconds).map_err(|_| {
                Failure::new(format!("a timeout of {seconds} s is not possible: use a number such as 5"))
            })
        };
        self.timeout.map(duration).transpose()
    }
}

/// Prints until it has printed enough, nothing comes any more, or somebody ends it.
pub(crate) fn execute(command: WatchCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let stop = role::stop(invocation.parent())?;
    let timeout = flags.view.timeout()?;
    let deadline = flags.view.deadline.map(Deadline::new).transpose()?;
    let mut options = ConnectOptions::in_domain(flags.bus.domain()?)
        .camera(&flags.bus.camera)
        .detector(&flags.name.detector)
        .named("watch")
        .stop(stop.clone());
    options.deadline = timeout;
    let client = match Client::connect(&options) {
        Err(tagbus_client::ConnectError::Stopped) => return Ok(Outcome::Done),
        connected => connected?,
    };
    Watch { client, stop, flags, timeout, deadline }.work()
}

struct Watch {
    client: Client,
    stop: Stop,
    flags: WatchFlags,
    timeout: Option<Duration>,
    deadline: Option<Deadline>,
}

impl Watch {
    fn work(mut self) -> Result<Outcome, Failure> {
        let outcome = self.watch();
        if let Some(deadline) = &self.deadline {
            complain(deadline);
        }
        outcome
    }

    fn watch(&mut self) -> Result<Outcome, Failure> {
        let mut printer = Printer::new(&self.flags);
        let (mut frames, mut tags) = (0, 0);
        while self.flags.view.frames.is_none_or(|limit| frames < limit) {
            let Some(detections) = self.client.receive(self.timeout.unwrap_or(Duration::MAX))? else {
                return Ok(self.silence());
            };
            frames += 1;
            tags += detections.tags().len();
            let hops = Hops::of(&detections);
            let late = self.deadline.as_mut().and_then(|deadline| deadline.judge(&hops));
            printer.print(&detections, late)?;
        }
        Ok(if tags > 0 { Outcome::Done } else { Outcome::NothingFound })
    }

    /// Nothing comes any more: somebody wants us to end, or the other side is gone.
    fn silence(&self) -> Outcome {
        if self.stop.is_triggered() {
            return Outcome::Done;
        }
        let waited = self.timeout.unwrap_or_default().as_secs_f64();
        let (camera, detector) = (&self.flags.bus.camera, &self.flags.name.detector);
        complain(format_args!(
            "no message of detector {detector} of camera {camera} for {waited:.1} s: do camera and service run?"
        ));
        Outcome::NothingFound
    }
}

/// The one of three ways of printing that fits who reads.
enum Printer {
    Json { camera: String, detector: String },
    Lines,
    Screen(Screen),
}

impl Printer {
    fn new(flags: &WatchFlags) -> Self {
        match (flags.view.json, Reader::of_stdout()) {
            (true, _) => {
                Self::Json { camera: flags.bus.camera.clone(), detector: flags.name.detector.clone() }
            }
            (false, Reader::Program) => Self::Lines,
            (false, Reader::Person) => {
                Self::Screen(Screen::new(format!("{} {}", flags.bus.camera, flags.name.detector)))
            }
        }
    }

    fn print(&mut self, detections: &Detections, late: Option<Late>) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        match self {
            Self::Json { camera, detector } => {
                writeln!(out, "{}", json::line(camera, detector, detections, late)?)?;
            }
            Self::Lines => writeln!(out, "{}", line::of(detections, late))?,
            Self::Screen(screen) => screen.show(detections, late, &mut out)?,
        }
        Ok(())
    }
}
