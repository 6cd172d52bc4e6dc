//! `tagbus detect`: pictures on disk.

mod inputs;
mod measure;
mod overlay;
mod report;

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use tagbus_camera::picture::load_grey;
use tagbus_detector::{Detector, LumaView};
use tagbus_family::Family;

use crate::command::Invocation;
use crate::config::text;
use crate::flags::{DetectorFlags, LevelName};
use crate::outcome::{Failure, Outcome, complain};
use measure::Measured;
use report::Report;

/// From so many pictures on a terminal shows a progress bar.
const MANY_PICTURES: usize = 10;

/// Find tags in pictures on disk
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus detect photo.jpg
  tagbus detect --family tagStandard41h12 --decimate 1 photos/
  tagbus detect --json --repeat 20 photo.png | jq .detect_us
  tagbus detect --stages drawn photos/     (writes drawn/*.tags.png)

A folder stands for its pictures (JPEG, PNG, PNM, BMP), frame2 before frame10.
A picture that cannot be read is reported, the others are searched, and the
exit code is 2.")]
pub(crate) struct DetectCommand {
    /// Pictures, or folders of pictures
    #[arg(value_name = "IMAGE|DIR", required_unless_present = "print_config")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    flags: DetectFlags,
}

#[derive(Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct DetectFlags {
    /// One line of JSON a picture
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    json: bool,
    /// Search each picture so many times, after one time that is not counted, and give all times
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Instructions to use: scalar, avx2, avx512, neon; by default the best that the processor has
    #[arg(long, value_name = "LEVEL")]
    #[serde(default, with = "text::optional")]
    level: Option<LevelName>,
    /// Write each picture with its tags drawn in to this folder
    #[arg(long, value_name = "DIR")]
    stages: Option<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    detector: DetectorFlags,
}

/// Searches all pictures; nothing that can be searched is lost to one that cannot.
pub(crate) fn execute(command: DetectCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    let mut search = Search::new(&flags)?;
    let (pictures, refused) = inputs::pictures(&command.inputs);
    let progress = progress_bar(pictures.len());
    let mut tally = Tally { failures: refused.len(), tags: 0 };
    refused.into_iter().for_each(complain);
    for path in &pictures {
        match search.picture(path) {
            Ok(searched) => {
                tally.tags += searched.tags;
                progress.suspend(|| searched.print())?;
            }
            Err(failure) => {
                tally.failures += 1;
                progress.suspend(|| complain(failure));
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(tally.outcome())
}

/// None in a pipe, where indicatif draws nothing anyway, and none for a few pictures.
fn progress_bar(count: usize) -> ProgressBar {
    if count >= MANY_PICTURES && io::stderr().is_terminal() {
        ProgressBar::new(count as u64)
    } else {
        ProgressBar::hidden()
    }
}

struct Tally {
    failures: usize,
    tags: usize,
}

impl Tally {
    fn outcome(&self) -> Outcome {
        match (self.failures, self.tags) {
            (0, 0) => Outcome::NothingFound,
            (0, _) => Outcome::Done,
            _ => Outcome::Failed,
        }
    }
}

/// A detector with what is to be done with its results.
struct Search<'a> {
    families: Vec<Family>,
    detector: Detector,
    flags: &'a DetectFlags,
}

/// A picture that was searched: how many tags it has, and what is said about it.
struct Searched {
    tags: usize,
    text: String,
}

impl Searched {
    fn print(&self) -> io::Result<()> {
        use std::io::Write;
        writeln!(io::stdout().lock(), "{}", self.text)
    }
}

impl<'a> Search<'a> {
    fn new(flags: &'a DetectFlags) -> Result<Self, Failure> {
        let families = flags.detector.families()?;
        let mut detector = Detector::new(&families, &flags.detector.settings()?)?;
        if let Some(LevelName(level)) = flags.level {
            detector.set_level(level);
        }
        if let Some(folder) = &flags.stages {
            std::fs::create_dir_all(folder)
                .map_err(|error| Failure::new(format!("{}: cannot be made: {error}", folder.display())))?;
        }
        Ok(Self { families, detector, flags })
    }

    fn picture(&mut self, path: &Path) -> Result<Searched, Failure> {
        let picture = load_grey(path)?;
        let view = LumaView::grey(&picture.luma, picture.width, picture.height)
            .map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        let measured = Measured::take(&mut self.detector, &view, self.flags.repeat);
        if let Some(folder) = &self.flags.stages {
            overlay::write(folder, path, &picture, &measured.detections)?;
        }
        let report = Report { path, picture: &picture, measured: &measured, families: &self.families };
        let text = if self.flags.json { report.json()? } else { report.text() };
        Ok(Searched { tags: measured.detections.len(), text })
    }
}
