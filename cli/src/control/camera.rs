//! A camera is asked or told, and what it answers is printed.

use std::io::Write;

use serde_json::{Value, json};
use tagbus_client::control::{CameraAnswer, CameraControl, CameraStatistics, DeviceControl};

use super::{Action, Asked, ControlFlags};
use crate::command::Invocation;
use crate::outcome::{Failure, Outcome, complain};

pub(super) fn ask(asked: &Asked, flags: &ControlFlags, invocation: &Invocation) -> Result<Outcome, Failure> {
    let mut camera = CameraControl::connect(&flags.options(invocation)?)?.timeout(flags.wait()?);
    let settings: Vec<(&str, &str)> =
        asked.settings.iter().map(|setting| (setting.name.as_str(), setting.value.as_str())).collect();
    let answer = match asked.action {
        Action::Get | Action::State => camera.get(),
        Action::Set => camera.set(&settings),
        Action::Reset => camera.reset_statistics(),
    }?;
    let mut out = std::io::stdout().lock();
    if flags.json {
        writeln!(out, "{}", json_of(&answer, flags))?;
        return Ok(Outcome::Done);
    }
    match asked.action {
        Action::Get if answer.controls.is_empty() => complain("this camera has no controls"),
        Action::Get => {
            for control in &answer.controls {
                writeln!(out, "{}", line_of(control))?;
            }
        }
        Action::Set => writeln!(out, "{} (information {})", answer.text, answer.info_number)?,
        Action::Reset => writeln!(out, "statistics begin anew")?,
        Action::State => print_state(&answer, flags, &mut out)?,
    }
    Ok(Outcome::Done)
}

/// `NAME=VALUE`, from which it can be set again; a button and what cannot be read have no value.
fn line_of(control: &DeviceControl) -> String {
    match control.value {
        Some(value) => format!("{}={value}", control.name),
        None => control.name.clone(),
    }
}

fn print_state(answer: &CameraAnswer, flags: &ControlFlags, out: &mut impl Write) -> Result<(), Failure> {
    let (camera, state, number) = (&flags.bus.camera, answer.state.name(), answer.info_number);
    writeln!(out, "camera {camera}: {state}, information {number}")?;
    for (name, count) in counts(&answer.statistics) {
        writeln!(out, "{:<18} {count}", name.replace('_', " "))?;
    }
    writeln!(out, "{:<18} {:.1} s", "counted for", seconds(&answer.statistics))?;
    Ok(())
}

fn counts(statistics: &CameraStatistics) -> [(&'static str, u64); 5] {
    [
        ("frames", statistics.frames),
        ("damaged", statistics.damaged),
        ("no_memory", statistics.no_loan),
        ("requests_answered", statistics.requests_answered),
        ("requests_refused", statistics.requests_refused),
    ]
}

fn seconds(statistics: &CameraStatistics) -> f64 {
    statistics.taken_ns.saturating_sub(statistics.since_ns) as f64 / 1e9
}

fn json_of(answer: &CameraAnswer, flags: &ControlFlags) -> Value {
    let mut counted: serde_json::Map<String, Value> =
        counts(&answer.statistics).into_iter().map(|(name, count)| (name.to_owned(), count.into())).collect();
    counted.insert("seconds".to_owned(), seconds(&answer.statistics).into());
    let control = |control: &DeviceControl| {
        json!({
            "name": control.name, "value": control.value, "min": control.min, "max": control.max,
            "default": control.default, "inactive": control.inactive,
        })
    };
    json!({
        "camera": flags.bus.camera,
        "info": answer.info_number,
        "state": answer.state.name(),
        "text": answer.text,
        "controls": answer.controls.iter().map(control).collect::<Vec<_>>(),
        "statistics": counted,
    })
}
