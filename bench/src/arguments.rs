//! What can be asked for on the command line.

use std::path::{Path, PathBuf};

use clap::builder::TypedValueParser as _;
use clap::{Parser, Subcommand};
use tagbus_client::{ConnectOptions, Domain};

use crate::crowd::Order;
use crate::delay::{Screen, StandInOrder, Switch};
use crate::hostile::{Attack, AttackOrder};
use crate::latency::{EchoOrder, ListenOrder, ReceiveOrder, Way};
use crate::sets::NAMES;

/// The set of pictures that the user names.
pub(crate) const NATURAL: &str = "natural";

/// Measures tagbus beside its peers.
#[derive(Parser)]
#[command(name = "tagbus-bench", version, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "Examples:
  tagbus-bench chaos --kills 60 --startup
  tagbus-bench clock --check 30
  tagbus-bench clock --show terminal
  tagbus-bench clock --led /sys/class/leds/ACT/brightness
  tagbus-bench cpu photo.jpg board.png
  tagbus-bench corners --family tagCustom48h12 --decimate 2
  tagbus-bench corners --gamma 2.2 --cell 5,6,7,8
  cargo run --release -p tagbus-bench --features peers -- cpu --record bench/record/cpu.md photo.jpg
  tagbus-bench false-positives --images photos,boards --record bench/record
  tagbus-bench latency --clients 1,4 --seconds 10
  tagbus-bench render textured --count 20 --out target/textured
  tagbus-bench soak --minutes 1
  cargo run --release -p tagbus-bench --features peers -- sweep textured --count 10 --record bench/record";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// An attacker of a machine that this program starts.
    #[command(hide = true)]
    Attack(AttackOrder),
    /// kill -9 of random roles of a whole machine (supervisor, camera, detector, clients), and how soon detections arrive again.
    /// Fails when one does not recover, ends, panics or leaves something.
    Chaos(ChaosArguments),
    /// A client of a machine that this program starts.
    #[command(hide = true)]
    Client(Order),
    /// How late a camera's stamps are and how old a frame is at a client, measured from outside: with a tag that tells the time, on a
    /// screen that the camera sees, or with a light.
    Clock(ClockArguments),
    /// A stand-in for `rpicam-vid`.
    #[command(hide = true)]
    ClockStandIn(StandInOrder),
    /// CPU time per picture of this detector and, with the feature `peers`, of the AprilTag C library, interleaved.
    Cpu(CpuArguments),
    /// How exact corners are on rendered tags and what that costs, for each kind of refinement; and whether decimation
    /// shifts them.
    Corners(CornersArguments),
    /// CPU time of a detector from a frame's arrival until its message is sent, by the number of clients.
    Critical(CriticalArguments),
    /// Tables I and II of the paper: how often what is no tag is taken for one, by the metric that chose a family's codes.
    FalsePositives(FalsePositivesArguments),
    /// CPU time and memory of frames made to cost (noise, checkerboards, stripes) beside natural pictures.
    Costly(CostlyArguments),
    /// Attackers on the bus of an honest camera, detector and clients: what they cost. Fails when one breaks something.
    Hostile(HostileArguments),
    /// All published families loaded at once: memory, time until ready, time of a look-up, agreement with brute force.
    Index(IndexArguments),
    /// Sending to waking, from camera to detector and on to clients, and what the bus adds to a detector: beside Unix sockets, pipes
    /// and (with the feature `zeromq`) ZeroMQ, all of which copy the same frames, and beside the least that a wake-up takes.
    Latency(LatencyArguments),
    /// A client of a machine that this program starts.
    #[command(hide = true)]
    LatencyClient(ListenOrder),
    /// A process that answers each wake-up.
    #[command(hide = true)]
    LatencyEcho(EchoOrder),
    /// A receiver of frames that this program sends.
    #[command(hide = true)]
    LatencyReceiver(ReceiveOrder),
    /// Two cameras, three detectors and many clients on one domain while parameters change every second: fails when a message mixes
    /// two parameter sets, a change takes effect within a frame, or anybody is refused.
    Many(ManyArguments),
    /// CPU time of each phase at every level of instructions and, with the feature `peers`, how many times ours the AprilTag
    /// C library takes on the same frames.
    Phases(PhasesArguments),
    /// What each choice of the paper buys: its pipeline, plainly, with one step changed at a time.
    Paper(PaperArguments),
    /// What it costs a frame that every role counts its hops.
    Recorder(RecorderArguments),
    /// From how near to how far the nested tag of the paper's Figure 1 is found, and which of its tags.
    Recursive(RecursiveArguments),
    /// Frames of a data set with exact truth, as files or as a list.
    Render(RenderArguments),
    /// Camera, detector and clients, four of 16 slow and two stuck, for a long time: fails when anything grows or is lost.
    Soak(SoakArguments),
    /// Every configuration of every detector on a data set: recall, wrong ids, corner errors, CPU time.
    Sweep(SweepArguments),
    /// CPU time and system calls of a running detector for each empty frame, the latter counted by strace.
    Syscalls(SyscallsArguments),
    /// Wall time of a frame with one thread and with several.
    Threads(ThreadsArguments),
}

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
    /// Instead of a real camera one of its own, whose frames are late by so many milliseconds: what is found has to be that.
    #[arg(long, conflicts_with_all = ["show", "led", "toggle"])]
    pub(crate) check: Option<u32>,
    /// The camera of its own sees a light.
    #[arg(long, requires = "check")]
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
pub(crate) struct CpuArguments {
    /// Pictures to search.
    #[arg(required = true)]
    pub(crate) pictures: Vec<PathBuf>,
    /// Tag family to look for.
    #[arg(long, default_value = "tag36h11")]
    pub(crate) family: String,
    /// Decimation factors, one block of the table each.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2")]
    pub(crate) decimate: Vec<f64>,
    /// Rounds; in each round every detector searches every picture once.
    #[arg(long, default_value_t = 15)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// Write the table and what it was measured on to this file (Markdown), and the figures beside it (CSV).
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct CornersArguments {
    /// Tag families.
    #[arg(long, value_delimiter = ',', default_value = "tag36h11,tagStandard41h12")]
    pub(crate) family: Vec<String>,
    /// Decimation factor.
    #[arg(long, default_value_t = 1.0)]
    pub(crate) decimate: f64,
    /// Pictures a row of the table.
    #[arg(long, default_value_t = 400)]
    pub(crate) pictures: u64,
    /// Blur of the picture, standard deviation in pixels.
    #[arg(long, default_value_t = 0.7)]
    pub(crate) blur: f32,
    /// Noise of the picture, standard deviation in grey levels.
    #[arg(long, default_value_t = 3.0)]
    pub(crate) noise: f32,
    /// Cell sizes, pixels; a tag that is 20 pixels wide comes in addition.
    #[arg(long, value_delimiter = ',', default_value = "2,3,5,9,20")]
    pub(crate) cell: Vec<f64>,
    /// Gamma of the camera: 1 for a straight line, 2.2 for what screens expect.
    #[arg(long, default_value_t = 1.0)]
    pub(crate) gamma: f32,
    /// Factor on the light; above about 1.1 white is clipped.
    #[arg(long, default_value_t = 1.0)]
    pub(crate) exposure: f32,
    /// How far black ink has spread into white, in cells.
    #[arg(long, default_value_t = 0.0)]
    pub(crate) ink: f64,
    /// Another seed gives other pictures.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the table and what it was measured on to this file (Markdown).
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct PaperArguments {
    /// Data sets, one section for each of them and each family.
    #[arg(required = true, value_parser = NAMES)]
    pub(crate) sets: Vec<String>,
    /// Tag families.
    #[arg(long, value_delimiter = ',', default_value = "tag36h11,tagStandard41h12")]
    pub(crate) family: Vec<String>,
    /// Frames of each set, family, distance and tilt.
    #[arg(long, default_value_t = 3)]
    pub(crate) count: usize,
    /// Another seed gives other frames.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Rounds; in each round every line searches the frame once.
    #[arg(long, default_value_t = 2)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// Write the tables and what they were measured on to this file (Markdown).
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct RenderArguments {
    /// The data set.
    #[arg(value_parser = NAMES)]
    pub(crate) set: String,
    /// Tag families.
    #[arg(long, value_delimiter = ',', default_value = "tag36h11,tagStandard41h12")]
    pub(crate) family: Vec<String>,
    /// Frames of each family; all of the set when not given. Distances and tilts take turns.
    #[arg(long)]
    pub(crate) count: Option<usize>,
    /// Another seed gives other frames.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for the frames (PNG) and their truth (JSON). Without it each frame's name, truth and hash is a line.
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct SweepArguments {
    /// The data set, or `natural` for pictures of your own without truth.
    #[arg(value_parser = sets_and_natural())]
    pub(crate) set: String,
    /// Tag families, one table each.
    #[arg(long, value_delimiter = ',', default_value = "tag36h11,tagStandard41h12")]
    pub(crate) family: Vec<String>,
    /// Frames of each family, distance and tilt; as many as the set has when not given. Of natural pictures: how many.
    #[arg(long)]
    pub(crate) count: Option<usize>,
    /// Only detectors whose name, decimation and settings hold this text, for example "AprilTag C 3.4.5 1 ". The first
    /// one is what others are compared with.
    #[arg(long, default_value = "")]
    pub(crate) only: String,
    /// A Python interpreter with further detectors (bench/peers/python.py says which and how to install them).
    #[arg(long)]
    pub(crate) python: Option<PathBuf>,
    /// Another seed gives other frames.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Rounds; in each round every detector searches the frame once.
    #[arg(long, default_value_t = 3)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// Folder of pictures for the set `natural`.
    #[arg(long)]
    pub(crate) pictures: Option<PathBuf>,
    /// Folder for the page, the figures as CSV and the plots.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct CostlyArguments {
    /// Folder of natural pictures without tags; their middle parts are brought to the size of the frames.
    #[arg(long)]
    pub(crate) pictures: PathBuf,
    /// Decimation factors.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    pub(crate) decimate: Vec<f64>,
    /// Rounds after one warm-up; in each round every detector searches the frame once.
    #[arg(long, default_value_t = 5)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
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
pub(crate) struct IndexArguments {
    /// Wrong bits to be corrected, where a family's distance allows it.
    #[arg(long, default_value_t = 3)]
    pub(crate) hamming: u32,
    /// How often all families are loaded, and each list of codes looked up.
    #[arg(long, default_value_t = 51)]
    pub(crate) rounds: usize,
    /// Codes of each family for which look-up is compared with every code in every rotation: half of them random, half of
    /// them tags with 0 to 4 wrong bits.
    #[arg(long, default_value_t = 1_000_000)]
    pub(crate) probes: u64,
    /// Another seed gives other codes.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct PhasesArguments {
    /// Folder of natural pictures; their middle parts are brought to 1296x964. Without it only rendered frames are timed.
    #[arg(long)]
    pub(crate) pictures: Option<PathBuf>,
    /// Decimation factors.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2")]
    pub(crate) decimate: Vec<f64>,
    /// Rounds after one warm-up; in each round every detector searches the frame once.
    #[arg(long, default_value_t = 5)]
    pub(crate) rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    pub(crate) core: usize,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct RecursiveArguments {
    /// Decimation factors, one line of the table each.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2")]
    pub(crate) decimate: Vec<f64>,
    /// Frames of every distance.
    #[arg(long, default_value_t = 10)]
    pub(crate) seeds: u64,
    /// Another seed gives other frames.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for the page, the figures as CSV and the plot.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct FalsePositivesArguments {
    /// Folders of pictures without tags. A `manifest.json` beside a folder may name pictures to be left out, by `families` or
    /// `ignore_families` that they hold.
    #[arg(long, required = true, value_delimiter = ',')]
    pub(crate) images: Vec<PathBuf>,
    /// What the names of pictures of one place or board begin with; such pictures count as one for the intervals. Every other
    /// picture is a place of its own.
    #[arg(long, value_delimiter = ',')]
    pub(crate) same_place: Vec<String>,
    /// Families of each line, each by a seed of its own.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub(crate) seeds: u32,
    /// Threads of the search for families; the figures do not depend on it.
    #[arg(long, default_value_t = 1)]
    pub(crate) threads: usize,
    /// Folder for the page, the figures as CSV and the plot.
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
pub(crate) struct ThreadsArguments {
    /// Folder of natural pictures, brought to several sizes. Without it only rendered and random frames are timed.
    #[arg(long)]
    pub(crate) pictures: Option<PathBuf>,
    /// Decimation factor.
    #[arg(long, default_value_t = 1.0)]
    pub(crate) decimate: f64,
    /// Numbers of threads; the others are compared with the first.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    pub(crate) threads: Vec<usize>,
    /// Rounds after one warm-up; in each round every number of threads searches the frame once.
    #[arg(long, default_value_t = 15)]
    pub(crate) rounds: usize,
    /// Milliseconds of rest before each search, in which threads fall asleep.
    #[arg(long, default_value_t = 2)]
    pub(crate) pause: u64,
    /// Folder for the page.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
}

/// The program `tagbus` that is named, or that lies beside this one.
pub(crate) fn beside_this(named: Option<&Path>) -> Result<PathBuf, std::io::Error> {
    let program = match named {
        Some(program) => program.to_owned(),
        None => std::env::current_exe()?.with_file_name("tagbus"),
    };
    if program.is_file() {
        return Ok(program);
    }
    let path = program.display();
    Err(std::io::Error::other(format!(
        "{path} is not there: build it (cargo build --release -p tagbus-cli) or name it with --program"
    )))
}

/// `WIDTHxHEIGHT`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    match sides {
        Some(size @ [16..=8192, 16..=8192]) => Ok(size),
        _ => Err("a size is WIDTHxHEIGHT, 16 to 8192 pixels each, for example 1296x964".to_owned()),
    }
}

fn sets_and_natural() -> Vec<&'static str> {
    NAMES.into_iter().chain([NATURAL]).collect()
}
