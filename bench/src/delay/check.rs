//! A camera whose delay is known, found again: whether what this bench says can be believed.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::light::{self, Light, Switch};
use super::pattern::Pattern;
use super::watch::{self, Seen};
use crate::Failure;
use crate::crowd::Machine;

const CAMERA: &str = "cam0";
const DETECTOR: &str = "main";
const SIZE: [u32; 2] = [640, 480];

/// A camera of our own.
pub(crate) struct Check {
    pub(crate) program: PathBuf,
    /// Milliseconds from the moment that a frame shows until its camera has it.
    pub(crate) delay_ms: u32,
    /// What shows when there is no light.
    pub(crate) pattern: Pattern,
    /// Frames a second.
    pub(crate) rate: u32,
    pub(crate) duration: Duration,
    /// A light instead of the pattern.
    pub(crate) light: bool,
}

/// What was found of a delay that is known.
pub(crate) enum Found {
    /// A tag or a number.
    Shown(Seen),
    Light(Light),
}

/// Starts a stand-in, its camera and a detector, measures, ends all.
pub(crate) fn check(check: &Check) -> Result<Found, Failure> {
    let mut machine = Machine::new(&check.program)?;
    let folder = std::env::temp_dir().join(format!("{}-stand-in", machine.domain.name()));
    fs::create_dir_all(&folder)?;
    let found = in_folder(check, &folder, &mut machine);
    let ended = machine.end();
    fs::remove_dir_all(&folder)?;
    let found = found?;
    ended?;
    Ok(found)
}

fn in_folder(check: &Check, folder: &Path, machine: &mut Machine) -> Result<Found, Failure> {
    let lamp = folder.join("lamp");
    write_script(check, folder, &lamp)?;
    machine.programs = Some(folder.to_owned());
    let [width, height] = SIZE.map(|side| side.to_string());
    let flags = ["--source=rpicam".to_owned(), format!("--width={width}"), format!("--height={height}")];
    machine.camera(CAMERA, &[&flags[..], &[format!("--framerate={}", check.rate)]].concat())?;
    let reach = machine.reach(CAMERA, DETECTOR);
    if check.light {
        return Ok(Found::Light(light::light(&reach, &Switch::File(lamp), check.duration)?));
    }
    let family = format!("--family={}", check.pattern.family().name());
    machine.detector(CAMERA, DETECTOR, &[family])?;
    Ok(Found::Shown(watch::watch(&reach, &check.pattern, check.duration)?))
}

/// What the camera takes for `rpicam-vid`.
fn write_script(check: &Check, folder: &Path, lamp: &Path) -> Result<(), Failure> {
    fs::write(lamp, "0")?;
    let bench = std::env::current_exe()?;
    let shown = match (check.light, check.pattern.is_number()) {
        (true, _) => format!("--light '{}'", lamp.display()),
        (false, true) => "--number".to_owned(),
        (false, false) => String::new(),
    };
    let script = format!(
        "#!/bin/sh\nexec '{}' clock-stand-in --delay {} --step {} {shown} -- \"$@\"\n",
        bench.display(),
        check.delay_ms,
        check.pattern.step_ns() / 1_000_000
    );
    let path = folder.join("rpicam-vid");
    fs::write(&path, script)?;
    Ok(fs::set_permissions(&path, fs::Permissions::from_mode(0o755))?)
}
