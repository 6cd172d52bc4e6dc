//! What can be asked for on the command line.

mod bus;
mod detector;
mod pictures;

use std::path::{Path, PathBuf};

use clap::{Parser, Subcommand};

use crate::crowd::Order;
use crate::delay::StandInOrder;
use crate::hostile::AttackOrder;
use crate::latency::{EchoOrder, ListenOrder, ReceiveOrder};

pub(crate) use bus::{
    ChaosArguments, ClockArguments, CriticalArguments, HostileArguments, LatencyArguments, ManyArguments,
    RecorderArguments, SoakArguments, SyscallsArguments,
};
pub(crate) use detector::{
    CornersArguments, CostlyArguments, CpuArguments, PhasesArguments, RecursiveArguments, ThreadsArguments,
};
pub(crate) use pictures::{
    FalsePositivesArguments, IndexArguments, PaperArguments, RenderArguments, SweepArguments,
};

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
    /// A process that notes each wake-up.
    #[command(hide = true)]
    LatencySleeper,
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
