//! What can be asked of benches of the detector.

use std::path::PathBuf;

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
