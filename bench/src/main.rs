//! How right, how fast, on what machine, beside which peers.

mod clock;
mod compare;
mod machine;
mod peers;
mod record;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measures tagbus beside its peers.
#[derive(Parser)]
#[command(name = "tagbus-bench", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  tagbus-bench cpu photo.jpg board.png
  cargo run --release -p tagbus-bench --features peers -- cpu --record bench/record/cpu.md photo.jpg";

#[derive(Subcommand)]
enum Command {
    /// CPU time per picture of this detector and, with the feature `peers`, of the AprilTag C library, interleaved.
    Cpu(CpuArguments),
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

fn main() -> ExitCode {
    let Command::Cpu(arguments) = Arguments::parse().command;
    match cpu(&arguments) {
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
