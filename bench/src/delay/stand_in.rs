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
use tagbus_scene::{Scene, SceneConfig, number};

use super::pattern::Pattern;
use crate::Failure;

const WHITE: u8 = 235;
const BLACK: u8 = 16;
const NO_COLOUR: u8 = 128;
/// Pictures of the scene that are drawn before, because drawing one takes longer than a frame may.
const PICTURES: u64 = 16;

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
    /// The built-in scene with a number in its corner, instead of a tag.
    #[arg(long)]
    number: bool,
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
    let delay_ns = u64::from(order.delay) * 1_000_000;
    let show = Show::new(order, size)?;
    let mut frame = vec![NO_COLOUR; size[0] * size[1] * 3 / 2];
    let mut out = io::stdout().lock();
    let mut moment_ns = monotonic_ns();
    loop {
        moment_ns += frame_time_ns;
        sleep_until(moment_ns);
        let luma = &mut frame[..size[0] * size[1]];
        show.draw(luma, size, moment_ns);
        sleep_until(moment_ns + delay_ns);
        match out.write_all(&frame).and_then(|()| out.flush()) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
            Err(error) => return Err(error.into()),
        }
    }
}

/// What frames show.
enum Show {
    Tag(Pattern),
    Light(PathBuf),
    /// Pictures one after the other.
    Number(Pattern, Vec<Vec<u8>>),
}

impl Show {
    fn new(order: &StandInOrder, [width, height]: [usize; 2]) -> Result<Self, Failure> {
        if let Some(file) = &order.light {
            return Ok(Self::Light(file.clone()));
        }
        if !order.number {
            return Ok(Self::Tag(Pattern::new(order.step)?));
        }
        let scene = Scene::new(SceneConfig { width, height, ..SceneConfig::default() })?;
        let mut pictures = vec![vec![0; width * height]; PICTURES as usize];
        pictures.iter_mut().zip(0..).for_each(|(picture, frame)| scene.render(frame, picture));
        Ok(Self::Number(Pattern::of_numbers(order.step)?, pictures))
    }

    fn draw(&self, luma: &mut [u8], size: [usize; 2], moment_ns: u64) {
        match self {
            Self::Light(file) => luma.fill(if is_on(file) { WHITE } else { BLACK }),
            Self::Tag(pattern) => {
                if let Some(grid) = pattern.family().grid(pattern.id_at(moment_ns)) {
                    draw(luma, size, &grid);
                }
            }
            Self::Number(pattern, pictures) => {
                let step = moment_ns / pattern.step_ns();
                luma.copy_from_slice(&pictures[(step % PICTURES) as usize]);
                // There are as many numbers as a byte has values.
                number::write(luma, size[0], pattern.id_at(moment_ns) as u8);
            }
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
