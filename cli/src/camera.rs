//! `tagbus camera`: publish frames.

use std::fmt;
use std::io::{self, Write};
use std::str::FromStr;

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tagbus_camera::devices::{self, DeviceInfo};
use tagbus_camera::{
    CameraConfig, ControlInfo, ControlSettings, DEFAULT_FRAMERATE, FramerateError, Pace, Repeat, Source,
    SourceOptions, UnknownFormat, parse_format, run_reporting,
};
use tagbus_message::fourcc::Fourcc;

use crate::command::Invocation;
use crate::config::text;
use crate::flags::BusFlags;
use crate::outcome::{Failure, Outcome, complain};
use crate::role;

/// Publish frames of a camera, of files, or of the built-in scene
#[derive(Args)]
#[command(after_help = "Examples:
  tagbus camera                                  the built-in scene as cam0
  tagbus camera --source replay:recording/ --framerate 10
  tagbus camera --source replay:clip.mjpeg --once --as-fast-as-possible
  tagbus camera --source replay:clip.nv12 --format NV12 --width 640 --height 480
  tagbus camera --source v4l:/dev/video0 --width 1280 --height 720 --control auto_exposure=manual_mode,gain=20
  tagbus camera --list                           video devices, and what is missing")]
pub(crate) struct CameraCommand {
    #[command(flatten)]
    flags: CameraFlags,
}

/// Everything that a camera is told.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct CameraFlags {
    /// List the video devices of this machine and end
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    list: bool,
    /// With --list: in JSON, one line a device
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    json: bool,
    #[command(flatten)]
    #[serde(flatten)]
    bus: BusFlags,
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceFlags,
}

/// Where frames come from, and how.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Source")]
pub(crate) struct SourceFlags {
    /// scene, scene:SEED, replay:PATH (picture, folder, MJPEG, AVI or raw file) v4l:/dev/videoN (or its path or id in /dev/v4l), rpicam, or libcamera, libcamera:ID
    #[arg(long, value_name = "SOURCE", default_value = "scene")]
    #[serde(with = "text")]
    source: Source,
    /// Pixels a row, of the scene (default 640), of a raw file, or of a device (default: as it is set)
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Rows, of the scene (default 480), of a raw file, or of a device (default: as it is set)
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
    /// Frames a second
    #[arg(long, value_name = "RATE", default_value_t = DEFAULT_FRAMERATE, conflicts_with = "as_fast_as_possible")]
    framerate: f64,
    /// The next frame as soon as the last one is sent
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    as_fast_as_possible: bool,
    /// The format of a device's frames (GREY, NV12, YUYV, MJPG, ...), or of a file that has no headers, only frames
    #[arg(long, value_name = "FOURCC")]
    #[serde(default, with = "text::optional")]
    format: Option<FormatName>,
    /// Controls of a device, set whenever it is opened: gain=50,auto_exposure=manual_mode,... (--list names them); of rpicam its options: shutter=5000,gain=4
    #[arg(long, value_name = "NAME=VALUE,...", default_value = "")]
    #[serde(with = "text")]
    control: ControlSettings,
    /// End after the last frame of a file or folder
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set)]
    once: bool,
    /// After the last frame start again with the first, which is the default
    #[arg(long = "loop", num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true",
        value_name = "BOOL", action = clap::ArgAction::Set, conflicts_with = "once")]
    #[serde(rename = "loop")]
    endless: bool,
}

impl CameraFlags {
    /// A camera of this place and source.
    pub(crate) fn new(bus: BusFlags, source: SourceFlags) -> Self {
        Self { list: false, json: false, bus, source }
    }

    fn config(self) -> Result<CameraConfig, Failure> {
        let domain = self.bus.domain()?;
        let options = self.source.options()?;
        Ok(CameraConfig { domain, camera: self.bus.camera, source: self.source.source, options })
    }
}

impl SourceFlags {
    /// Whether frames come from the built-in scene.
    pub(crate) fn is_scene(&self) -> bool {
        matches!(self.source, Source::Scene { .. })
    }

    fn options(&self) -> Result<SourceOptions, FramerateError> {
        Ok(SourceOptions {
            width: self.width,
            height: self.height,
            format: self.format.map(|format| format.0),
            controls: self.control.clone(),
            pace: match self.as_fast_as_possible {
                true => Pace::AsFastAsPossible,
                false => Pace::from_framerate(self.framerate)?,
            },
            repeat: if self.once { Repeat::Once } else { Repeat::Loop },
            ..SourceOptions::default()
        })
    }
}

/// A raw format by its four letters.
#[derive(Clone, Copy, Debug)]
struct FormatName(Fourcc);

impl FromStr for FormatName {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        parse_format(name).map(Self)
    }
}

impl fmt::Display for FormatName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Publishes until the source or somebody ends it.
pub(crate) fn execute(command: CameraCommand, invocation: &Invocation) -> Result<Outcome, Failure> {
    let Some(flags) = invocation.in_force(command.flags)? else { return Ok(Outcome::Done) };
    if flags.list {
        return list(flags.json);
    }
    let stop = role::stop(invocation.parent())?;
    let config = flags.config()?;
    let role = format!("camera {}", config.camera);
    run_reporting(config, stop, &mut |event| complain(format_args!("{role}: {event}")))?;
    Ok(Outcome::Done)
}

/// Devices on the standard output, advice on the standard error.
fn list(json: bool) -> Result<Outcome, Failure> {
    let found = devices::list_devices();
    let mut out = io::stdout().lock();
    for device in &found {
        if json { writeln!(out, "{}", device_json(device))? } else { writeln!(out, "{device}")? }
    }
    devices::advice(&found).into_iter().for_each(complain);
    Ok(if found.is_empty() { Outcome::NothingFound } else { Outcome::Done })
}

fn device_json(device: &DeviceInfo) -> Value {
    let controls: Vec<Value> = device.controls.iter().map(control_json).collect();
    let mut value = json!({
        "path": device.path, "links": device.links, "name": device.name, "driver": device.driver, "controls": controls
    });
    match &device.formats {
        Ok(formats) => value["formats"] = formats.iter().map(format_json).collect(),
        Err(reason) => value["formats_unknown"] = reason.as_str().into(),
    }
    value
}

fn control_json(control: &ControlInfo) -> Value {
    let menu = control.menu.iter().map(|(value, text)| json!({ "value": value, "text": text }));
    json!({
        "name": control.name, "value": control.value, "min": control.min, "max": control.max, "step": control.step,
        "default": control.default, "menu": menu.collect::<Vec<_>>(), "inactive": control.inactive
    })
}

fn format_json(info: &devices::FormatInfo) -> Value {
    let rate = |rate: &devices::RateInfo| json!({ "min": rate.min, "max": rate.max });
    let size = |size: &devices::SizeInfo| {
        let rates: Vec<Value> = size.rates.iter().map(rate).collect();
        json!({ "min": size.min, "max": size.max, "step": size.step, "rates": rates })
    };
    let sizes: Vec<Value> = info.sizes.iter().map(size).collect();
    json!({ "format": info.format.to_string(), "description": info.description, "sizes": sizes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn a_device_that_tells_no_formats_says_why() {
        let silent = DeviceInfo {
            path: PathBuf::from("/dev/video9"),
            name: "nine".to_owned(),
            driver: String::new(),
            links: Vec::new(),
            formats: Err("no permission".to_owned()),
            controls: Vec::new(),
        };
        let json = device_json(&silent).to_string();
        assert!(
            json.contains(r#""path":"/dev/video9""#) && json.contains(r#""formats_unknown":"no permission""#),
            "{json}"
        );
    }
}
