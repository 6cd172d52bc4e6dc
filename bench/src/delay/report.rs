//! What was found, as a page.

use std::fmt::Write as _;

use super::interval::Delays;
use super::light::Light;
use super::pattern::Pattern;
use super::watch::{HOPS, Seen};

const HEAD: &str = "| until | times | shortest ms | p50 ms | p99 ms | longest ms | +- ms |\n|---|---:|---:|---:|---:|---:|---:|\n";

fn row(name: &str, delays: &Delays) -> String {
    format!(
        "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |\n",
        delays.count(),
        delays.shortest_ms(),
        delays.quantile_ms(0.5),
        delays.quantile_ms(0.99),
        delays.quantile_ms(1.0),
        delays.uncertainty_ms()
    )
}

/// Where only one value fits all.
fn common(delays: &Delays) -> String {
    match delays.common_ms() {
        Some([least, most]) => {
            format!(
                "\nIf the stamp is always late by the same time, that lies between {least:.2} and {most:.2} ms.\n"
            )
        }
        None if delays.count() == 0 => {
            "\nThe stamps are of another clock and cannot be compared.\n".to_owned()
        }
        None => "\nNo one time fits all stamps: they are late by times that differ.\n".to_owned(),
    }
}

/// From the moment that a tag or a number was shown.
pub(crate) fn shown_page(seen: &Seen, pattern: &Pattern) -> String {
    let mut text = format!("From the moment that a frame shows:\n\n{HEAD}");
    for (name, delays) in HOPS.iter().zip(&seen.delays) {
        text += &row(name, delays);
    }
    text += &common(&seen.delays[0]);
    let (what, without) = match pattern.is_number() {
        true => ("number", "Messages of frames whose number was not read"),
        false => ("tag", "Messages without exactly one tag of the pattern"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "A {what} each {:.0} ms tells times apart that are less than {:.1} s old. A single time can be off by what +- says, the median of many \
         is not. {without}: {}; with stamps of another clock: {}.",
        pattern.step_ns() as f64 / 1e6,
        pattern.range_ns() as f64 / 1e9,
        seen.unclear,
        seen.other_clock
    );
    text
}

/// From the moment that a light changed.
pub(crate) fn light_page(light: &Light) -> String {
    let names =
        ["stamp of the camera", "dequeue", "client, after the change (the wait for the next frame included)"];
    let mut text = format!("From the moment that a frame shows; at the client from the change:\n\n{HEAD}");
    for (name, delays) in names.iter().zip(&light.delays) {
        text += &row(name, delays);
    }
    text += &common(&light.delays[0]);
    let _ = writeln!(text, "The light changed {} times, by {:.1} grey levels.", light.steps, light.contrast);
    text
}
