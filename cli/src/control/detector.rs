//! A detector is asked or told, and what it answers is printed.

use std::io::Write;

use serde_json::{Value, json};
use tagbus_client::control::{DetectorAnswer, DetectorControl, DetectorParameters, DetectorStatistics};

use super::{Action, Asked, DetectorControlFlags, setting};
use crate::command::Invocation;
use crate::outcome::{Failure, Outcome, complain};

pub(super) fn ask(
    asked: &Asked,
    flags: &DetectorControlFlags,
    invocation: &Invocation,
) -> Result<Outcome, Failure> {
    let change = setting::change_of(&asked.settings)?;
    let options = flags.common.options(invocation)?.detector(&flags.name.detector);
    let mut detector = DetectorControl::connect(&options)?.timeout(flags.common.wait()?);
    let answer = match asked.action {
        Action::Get | Action::State => detector.get(),
        Action::Set => detector.set(&change),
        Action::Reset => detector.reset_statistics(),
    }?;
    if !answer.text.is_empty() {
        complain(&answer.text);
    }
    let mut out = std::io::stdout().lock();
    if flags.common.json {
        writeln!(out, "{}", json_of(&answer, flags))?;
        return Ok(Outcome::Done);
    }
    match asked.action {
        Action::Get => {
            for (name, value) in answer.parameters.named() {
                writeln!(out, "{name}={value}")?;
            }
        }
        Action::Set => writeln!(out, "change {} is in force", answer.control_number)?,
        Action::Reset => writeln!(out, "statistics begin anew")?,
        Action::State => print_state(&answer, flags, &mut out)?,
    }
    Ok(Outcome::Done)
}

fn print_state(
    answer: &DetectorAnswer,
    flags: &DetectorControlFlags,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let (camera, detector) = (&flags.common.bus.camera, &flags.name.detector);
    let state = answer.state.name().replace('_', " ");
    write!(out, "detector {detector} of camera {camera}: {state}")?;
    if let Some((width, height)) = answer.frame_size {
        write!(out, ", {width}x{height}")?;
    }
    writeln!(out, ", change {}", answer.control_number)?;
    for (name, count) in counts(&answer.statistics) {
        writeln!(out, "{:<18} {count}", name.replace('_', " "))?;
    }
    writeln!(out, "{:<18} {:.1} s", "counted for", seconds(&answer.statistics))?;
    Ok(())
}

fn counts(statistics: &DetectorStatistics) -> [(&'static str, u64); 10] {
    [
        ("frames_searched", statistics.frames_searched),
        ("frames_skipped", statistics.frames_skipped),
        ("frames_refused", statistics.frames_refused),
        ("tags_found", statistics.tags_found),
        ("messages_sent", statistics.messages_sent),
        ("camera_starts", statistics.camera_starts),
        ("deadlines_missed", statistics.deadlines_missed),
        ("dead_cleaned", statistics.dead_cleaned),
        ("requests_answered", statistics.requests_answered),
        ("requests_refused", statistics.requests_refused),
    ]
}

fn seconds(statistics: &DetectorStatistics) -> f64 {
    statistics.taken_ns.saturating_sub(statistics.since_ns) as f64 / 1e9
}

fn json_of(answer: &DetectorAnswer, flags: &DetectorControlFlags) -> Value {
    let statistics = &answer.statistics;
    let mut counted: serde_json::Map<String, Value> =
        counts(statistics).into_iter().map(|(name, count)| (name.to_owned(), count.into())).collect();
    counted.insert("search_ns".to_owned(), statistics.search_ns.into());
    counted.insert("seconds".to_owned(), seconds(statistics).into());
    json!({
        "camera": flags.common.bus.camera,
        "detector": flags.name.detector,
        "change": answer.control_number,
        "state": answer.state.name(),
        "frame_size": answer.frame_size.map(|(width, height)| [width, height]),
        "text": answer.text,
        "parameters": json_of_parameters(&answer.parameters),
        "statistics": counted,
    })
}

fn json_of_parameters(parameters: &DetectorParameters) -> Value {
    json!({
        "family": parameters.families,
        "decimate": parameters.decimation,
        "sampling": parameters.sampling.name(),
        "search": parameters.search.name(),
        "threads": parameters.threads,
        "hamming": parameters.hamming,
        "refine": parameters.refinement.name(),
        "sharpening": parameters.sharpening,
        "ids": parameters.ids,
        "min-margin": parameters.min_margin,
        "region": parameters.region.map(|region| region.to_string()),
    })
}
