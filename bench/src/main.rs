//! How right, how fast, on what machine, beside which peers.

mod clock;
mod compare;
mod corners;
mod machine;
mod peers;
mod record;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tagbus_family::Family;

/// Measures tagbus beside its peers.
#[derive(Parser)]
#[command(name = "tagbus-bench", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  tagbus-bench cpu photo.jpg board.png
  tagbus-bench corners --family tagCustom48h12 --decimate 2
  cargo run --release -p tagbus-bench --features peers -- cpu --record bench/record/cpu.md photo.jpg";

#[derive(Subcommand)]
enum Command {
    /// CPU time per picture of this detector and, with the feature `peers`, of the AprilTag C library, interleaved.
    Cpu(CpuArguments),
    /// How exact corners are on rendered tags, for each kind of refinement.
    Corners(CornersArguments),
}

#[derive(clap::Args)]
struct CpuArguments {
    /// Pictures to search.
    #[arg(required = true)]
    pictures: Vec<PathBuf>,
    /// Tag family to look for.
    #[arg(long, default_value = "tag36h11")]
    family: String,
    /// Decimation factors, one block of the table each.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2")]
    decimate: Vec<f64>,
    /// Rounds; in each round every detector searches every picture once.
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    core: usize,
    /// Write the table and what it was measured on to this file (Markdown), and the figures beside it (CSV).
    #[arg(long)]
    record: Option<PathBuf>,
}

#[derive(clap::Args)]
struct CornersArguments {
    /// Tag families.
    #[arg(long, value_delimiter = ',', default_value = "tag36h11,tagStandard41h12")]
    family: Vec<String>,
    /// Decimation factor.
    #[arg(long, default_value_t = 1.0)]
    decimate: f64,
    /// Pictures a row of the table.
    #[arg(long, default_value_t = 400)]
    pictures: u64,
    /// Blur of the picture, standard deviation in pixels.
    #[arg(long, default_value_t = 0.7)]
    blur: f32,
    /// Noise of the picture, standard deviation in grey levels.
    #[arg(long, default_value_t = 3.0)]
    noise: f32,
    /// Another seed gives other pictures.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the table and what it was measured on to this file (Markdown).
    #[arg(long)]
    record: Option<PathBuf>,
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Cpu(arguments) => cpu(&arguments),
        Command::Corners(arguments) => corners(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tagbus-bench: {error}");
            ExitCode::from(2)
        }
    }
}

fn cpu(arguments: &CpuArguments) -> Result<(), Box<dyn std::error::Error>> {
    machine::pin_to(arguments.core)?;
    let pictures = compare::load(&arguments.pictures)?;
    let rows = compare::run(&pictures, &arguments.family, &arguments.decimate, arguments.rounds)?;
    print!("{}", record::table(&rows));
    if let Some(path) = &arguments.record {
        record::write(path, &rows, arguments.rounds)?;
    }
    Ok(())
}

fn corners(arguments: &CornersArguments) -> Result<(), Box<dyn std::error::Error>> {
    let families: Result<_, _> = arguments.family.iter().map(|name| Family::published(name)).collect();
    let conditions = corners::Conditions {
        families: families?,
        factor: arguments.decimate,
        pictures: arguments.pictures,
        blur_sigma: arguments.blur,
        noise_sigma: arguments.noise,
        seed: arguments.seed,
    };
    let table = corners::table(&conditions)?;
    print!("{table}");
    if let Some(path) = &arguments.record {
        let CornersArguments { decimate, blur, noise, seed, .. } = arguments;
        let how = format!(
            "decimation {decimate}, blur sigma {blur} px, noise sigma {noise}, tilt to 30 degrees, seed {seed}"
        );
        record::write_page(path, "Corner errors on rendered tags", &how, &table)?;
    }
    Ok(())
}
