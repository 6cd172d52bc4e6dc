//! What can be asked of benches of sets of pictures and of families.

use std::path::PathBuf;

use super::NATURAL;
use crate::sets::NAMES;

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

fn sets_and_natural() -> Vec<&'static str> {
    NAMES.into_iter().chain([NATURAL]).collect()
}
