//! A known delay is found, and every way from process to process is measured.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::path::Path;
use std::process::Command;

/// What the bench writes; it must not fail.
fn run(arguments: &[&str]) -> String {
    let output =
        Command::new(Path::new(env!("CARGO_BIN_EXE_tagbus-bench"))).args(arguments).output().unwrap();
    let page = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{page}{}", String::from_utf8_lossy(&output.stderr));
    println!("{page}");
    page
}

/// The numbers of a line of a table.
fn numbers(page: &str, name: &str) -> Vec<f64> {
    let line = page.lines().find(|line| line.starts_with(&format!("| {name} |")));
    let line = line.unwrap_or_else(|| panic!("no line of {name} in {page}"));
    line.split('|').skip(2).filter_map(|cell| cell.trim().parse().ok()).collect()
}

/// The delay that the camera of the bench adds, milliseconds.
const DELAY_MS: f64 = 30.0;
/// What a frame takes in addition in the quickest of many frames on a machine that does other things: milliseconds.
const SLACK_MS: f64 = 200.0;

#[test]
fn a_delay_that_no_stamp_tells_is_found_with_a_tag() {
    finds_the_delay(&["clock", "--check", "30", "--step", "5", "--seconds", "6"]);
}

#[test]
fn a_delay_that_no_stamp_tells_is_found_with_the_number_of_a_frame() {
    finds_the_delay(&["clock", "--check", "30", "--number", "--step", "5", "--seconds", "6"]);
}

fn finds_the_delay(arguments: &[&str]) {
    let page = run(arguments);
    let stamp = numbers(&page, "stamp of the camera");
    let [count, shortest, median, .., uncertainty] = stamp[..] else { panic!("{page}") };
    assert!(count > 20.0 && uncertainty == 2.5, "{page}");
    // No stamp can be earlier than the frame was written; a median is right within a part of a step.
    assert!((DELAY_MS..DELAY_MS + SLACK_MS).contains(&shortest), "{page}");
    assert!(median >= DELAY_MS - 1.0, "{page}");
    // The hops follow each other.
    let medians =
        ["stamp of the camera", "publish", "detector awake", "client"].map(|hop| numbers(&page, hop)[2]);
    assert!(medians.is_sorted(), "{page}");
}

#[test]
fn a_delay_that_no_stamp_tells_is_found_with_a_light() {
    let page = run(&["clock", "--check", "30", "--light", "--seconds", "8"]);
    let [count, shortest, ..] = numbers(&page, "stamp of the camera")[..] else { panic!("{page}") };
    assert!(count >= 5.0 && page.contains("by 219.0 grey levels"), "{page}");
    // The light changes up to a frame's time before the first frame that shows it.
    assert!((DELAY_MS..DELAY_MS + 34.0 + SLACK_MS).contains(&shortest), "{page}");
}

/// No figure is judged: only that all of them are there, and that nothing is left behind, which the bench itself looks for.
#[test]
fn every_way_is_measured_beside_the_floor_and_the_pipeline() {
    let page = run(&[
        "latency",
        "--size",
        "320x240",
        "--clients",
        "1,2",
        "--seconds",
        "1",
        "--rounds",
        "2",
        "--rate",
        "50",
    ]);
    for way in [
        "tagbus",
        "tagbus, waiting with iceoryx2's wait set",
        "tagbus, polling",
        "Unix stream socket",
        "pipe",
    ] {
        let lines = page.lines().filter(|line| line.starts_with(&format!("| {way} |"))).count();
        assert_eq!(lines, 2, "{way}");
    }
    for part in ["| futex (POSIX semaphore) |", "| eventfd |", "us are left", "load average"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.lines().filter(|line| line.contains("| met |") || line.contains("missed")).count() >= 3);
}
