//! What can be asked of benches of the bus.

use std::path::{Path, PathBuf};

use clap::builder::TypedValueParser as _;
use tagbus_client::{ConnectOptions, Domain};

use super::size;
use crate::delay::{Pattern, Screen, Switch};
use crate::hostile::Attack;
use crate::latency::Way;

#[derive(clap::Args)]
pub(crate) struct ChaosArguments {
    /// Kills of running roles.
    #[arg(long, default_value_t = 500)]
    pub(crate) kills: usize,
    /// Clients, each a process of its own.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=32).map(|count| count as usize))]
    pub(crate) clients: usize,
    /// Another seed gives other roles and moments.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// In addition, in random order, as many kills of roles within 100 ms of their start.
    #[arg(long)]
    pub(crate) startup: bool,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page, every kill as CSV and the plot.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct ClockArguments {
    /// The domain of camera and detector.
    #[arg(long, default_value = "tagbus")]
    pub(crate) domain: String,
    /// Where the domain keeps its files; by default where every role looks.
    #[arg(long)]
    pub(crate) root: Option<PathBuf>,
    #[arg(long, default_value = "cam0")]
    pub(crate) camera: String,
    /// It has to look for tag36h11; not needed with a light.
    #[arg(long, default_value = "main")]
    pub(crate) detector: String,
    /// How long is measured.
    #[arg(long, default_value_t = 20)]
    pub(crate) seconds: u32,
    /// Milliseconds from tag to tag of the pattern. Several times a screen's 17 ms, and no multiple of the camera's frame time.
    #[arg(long, default_value_t = 47, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) step: u32,
    /// Shows the pattern while measuring: in this `terminal`, or in a frame buffer such as /dev/fb0. Without it another one shows it.
    #[arg(long)]
    pub(crate) show: Option<PathBuf>,
    /// A light's file into which 1 and 0 are written, such as /sys/class/leds/ACT/brightness, instead of the pattern.
    #[arg(long, conflicts_with = "show")]
    pub(crate) led: Option<PathBuf>,
    /// A command that switches a light and gets 1 or 0 as its last argument, instead of the pattern.
    #[arg(long, conflicts_with_all = ["show", "led"])]
    pub(crate) toggle: Option<String>,
    /// A number in the top left corner of the frames instead of a tag, as `tagbus_scene::number` writes it: for whoever plays frames to a driver.
    #[arg(long, conflicts_with_all = ["show", "led", "toggle"])]
    pub(crate) number: bool,
    /// Instead of a real camera one of its own, whose frames are late by so many milliseconds: what is found has to be that.
    #[arg(long, conflicts_with_all = ["show", "led", "toggle"])]
    pub(crate) check: Option<u32>,
    /// The camera of its own sees a light.
    #[arg(long, requires = "check", conflicts_with = "number")]
    pub(crate) light: bool,
    /// Frames a second of the camera of its own.
    #[arg(long, default_value_t = 30, requires = "check")]
    pub(crate) rate: u32,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
}

impl ClockArguments {
    /// Whom to listen to.
    pub(crate) fn options(&self) -> Result<ConnectOptions, crate::Failure> {
        let domain = match &self.root {
            Some(root) => Domain::with_root(&self.domain, root)?,
            None => Domain::new(&self.domain)?,
        };
        let options = ConnectOptions::in_domain(domain).camera(&self.camera).detector(&self.detector);
        Ok(options.deadline(std::time::Duration::from_secs(10)))
    }

    pub(crate) fn pattern(&self) -> Result<Pattern, crate::Failure> {
        if self.number { Pattern::of_numbers(self.step) } else { Pattern::new(self.step) }
    }

    pub(crate) fn switch(&self) -> Option<Switch> {
        let file = self.led.clone().map(Switch::File);
        file.or_else(|| self.toggle.clone().map(Switch::Command))
    }

    pub(crate) fn screen(&self) -> Option<Screen> {
        let place = self.show.clone()?;
        Some(if place == Path::new("terminal") { Screen::Terminal } else { Screen::FrameBuffer(place) })
    }
}

#[derive(clap::Args)]
pub(crate) struct CriticalArguments {
    /// Numbers of clients, each a process of its own; one line of the table each.
    #[arg(long, value_delimiter = ',', default_value = "0,1,4,16")]
    pub(crate) clients: Vec<usize>,
    /// Rounds after one that warms up; in each the numbers of clients take turns.
    #[arg(long, default_value_t = 5)]
    pub(crate) rounds: usize,
    /// Frames of each number of clients in a round.
    #[arg(long, default_value_t = 300)]
    pub(crate) frames: usize,
    /// Frames a second.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) rate: u32,
    /// The core of the detector; camera and clients are kept off it where there is another.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct HostileArguments {
    /// Kinds of attack; all when not given.
    #[arg(long, value_delimiter = ',')]
    pub(crate) attacks: Vec<Attack>,
    /// Rounds; in each all attacks take turns, each beside its tame twin.
    #[arg(long, default_value_t = 7)]
    pub(crate) rounds: usize,
    /// Length of each measurement.
    #[arg(long, default_value_t = 3.0)]
    pub(crate) seconds: f64,
    /// Frames a second.
    #[arg(long, default_value_t = 60)]
    pub(crate) rate: u32,
    /// Another seed gives other lies.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The core of the detectors; the others are kept off it where there is another.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct LatencyArguments {
    /// Size of a frame.
    #[arg(long, default_value = "1296x964", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Numbers of receivers and of clients, each a process of its own.
    #[arg(long, value_delimiter = ',', default_value = "1,4,16")]
    pub(crate) clients: Vec<usize>,
    /// How long each line is measured, over all rounds.
    #[arg(long, default_value_t = 20)]
    pub(crate) seconds: u32,
    /// Rounds, in each of which every line is measured once.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) rounds: u32,
    /// Frames a second.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) rate: u32,
    /// Only these ways.
    #[arg(long, value_delimiter = ',')]
    pub(crate) ways: Vec<Way>,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page, the figures as CSV and the plot.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct ManyArguments {
    /// How long, with a change of each detector every second.
    #[arg(long, default_value_t = 60)]
    pub(crate) seconds: u32,
    /// Clients, each a process of its own.
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(3..=96))]
    pub(crate) clients: u32,
    /// Frames a second of each camera.
    #[arg(long, default_value_t = 30)]
    pub(crate) rate: u32,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct RecorderArguments {
    /// How often 100,000 frames are counted, and a single one with empty caches.
    #[arg(long, default_value_t = 51)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// A folder for recorder.md.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct SoakArguments {
    /// How long.
    #[arg(long, default_value_t = 30.0)]
    pub(crate) minutes: f64,
    /// Clients, each a process of its own; a quarter of them is slow and an eighth stuck.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(crate) clients: u32,
    /// Frames a second.
    #[arg(long, default_value_t = 200)]
    pub(crate) rate: u32,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page, the figures as CSV and the plot.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct SyscallsArguments {
    /// How long each of both is counted.
    #[arg(long, default_value_t = 10)]
    pub(crate) seconds: u32,
    /// Numbers of clients, one line of the table each.
    #[arg(long, value_delimiter = ',', default_value = "0,1,4,16")]
    pub(crate) clients: Vec<usize>,
    /// Frames a second.
    #[arg(long, default_value_t = 60)]
    pub(crate) rate: u32,
    /// The program `tagbus`; by default the one beside this program.
    #[arg(long)]
    pub(crate) program: Option<PathBuf>,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}
