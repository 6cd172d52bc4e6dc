//! A stand-in for `rpicam-vid`: frames whose moment and delay are known.
//!
//! It writes what that program would (raw YUV 4:2:0 of the size it is told), each frame so long after the moment it shows.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use tagbus_family::{Grid, Paint};
use tagbus_message::clock::monotonic_ns;

use super::pattern::Pattern;
use crate::Failure;

const WHITE: u8 = 235;
const BLACK: u8 = 16;
const NO_COLOUR: u8 = 128;

/// What the stand-in shows.
#[derive(clap::Args)]
pub(crate) struct StandInOrder {
    /// Milliseconds from the moment that a frame shows until it is written.
    #[arg(long)]
    delay: u32,
    /// The pattern's step in milliseconds.
    #[arg(long)]
    step: u32,
    /// A file that says 1 or 0: how bright the picture is, instead of a tag.
    #[arg(long)]
    light: Option<PathBuf>,
    /// What `rpicam-vid` would be told.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    told: Vec<String>,
}

/// Writes frames until nobody reads them any more.
pub(crate) fn stand_in(order: &StandInOrder) -> Result<(), Failure> {
    let told = |name: &str| -> Result<u64, Failure> {
        let place = order.told.iter().position(|word| word == name).ok_or(format!("{name} is missing"))?;
        Ok(order.told.get(place + 1).ok_or(format!("{name} without a value"))?.parse::<f64>()? as u64)
    };
    let size = [told("--width")? as usize, told("--height")? as usize];
    let frame_time_ns = 1_000_000_000 / told("--framerate")?.max(1);
    let (pattern, delay_ns) = (Pattern::new(order.step)?, u64::from(order.delay) * 1_000_000);
    let mut frame = vec![NO_COLOUR; size[0] * size[1] * 3 / 2];
    let mut out = io::stdout().lock();
    let mut moment_ns = monotonic_ns();
    loop {
        moment_ns += frame_time_ns;
        sleep_until(moment_ns);
        let luma = &mut frame[..size[0] * size[1]];
        match &order.light {
            Some(file) => luma.fill(if is_on(file) { WHITE } else { BLACK }),
            None => {
                if let Some(grid) = pattern.family().grid(pattern.id_at(moment_ns)) {
                    draw(luma, size, &grid);
                }
            }
        }
        sleep_until(moment_ns + delay_ns);
        match out.write_all(&frame).and_then(|()| out.flush()) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
            Err(error) => return Err(error.into()),
        }
    }
}

fn sleep_until(moment_ns: u64) {
    thread::sleep(Duration::from_nanos(moment_ns.saturating_sub(monotonic_ns())));
}

fn is_on(file: &PathBuf) -> bool {
    fs::read_to_string(file).is_ok_and(|text| text.starts_with('1'))
}

/// The tag in the middle of white.
fn draw(luma: &mut [u8], [width, height]: [usize; 2], grid: &Grid) {
    let scale = (width.min(height) * 2 / 3 / grid.width()).max(1);
    let corner = [width, height].map(|side| side.saturating_sub(grid.width() * scale) / 2);
    luma.fill(WHITE);
    for (cell_y, cells) in grid.rows().enumerate() {
        for (cell_x, _) in cells.iter().enumerate().filter(|(_, paint)| **paint == Paint::Black) {
            for y in 0..scale {
                let first = (corner[1] + cell_y * scale + y) * width + corner[0] + cell_x * scale;
                luma[first..first + scale].fill(BLACK);
            }
        }
    }
}
