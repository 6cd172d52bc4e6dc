//! `tagbus control`: a detector and a camera that run are asked and told.

use std::process::Command;

use serde_json::Value;

use crate::support::{Bus, Running, Watchdog, complained, json_lines, printed, tagbus};

fn scene(bus: &Bus) -> Running {
    bus.start("run", &["--json", "--family=tag36h11,tag25h9", "--decimate=1"])
}

/// `tagbus control` with these words and patience.
fn control(bus: &Bus, words: &[&str]) -> Command {
    control_waiting(bus, words, "--wait=60")
}

fn control_waiting(bus: &Bus, words: &[&str], wait: &str) -> Command {
    let mut command = tagbus(["control"]);
    command.args(words).arg("--domain").arg(bus.domain.name()).arg("--root").arg(bus.domain.root());
    command.arg(wait);
    command
}

/// Lines of the watcher until one of this change comes.
fn line_of_change(run: &Running, change: u64) -> Value {
    loop {
        let line = run.json();
        match line["change"].as_u64().unwrap() {
            seen if seen < change => {}
            seen => {
                assert_eq!(seen, change);
                return line;
            }
        }
    }
}

fn families(line: &Value) -> Vec<&str> {
    line["detections"].as_array().unwrap().iter().map(|tag| tag["family"].as_str().unwrap()).collect()
}

#[test]
fn a_detector_is_told_and_the_next_messages_name_the_change() {
    let _watchdog = Watchdog::of_seconds(120, "control detector");
    let bus = Bus::new();
    let run = scene(&bus);
    assert_eq!(run.json()["change"], 0);
    let before = printed(&mut control(&bus, &["detector"]), 0);
    assert!(before.contains("family=tag36h11,tag25h9\ndecimate=1\n"), "{before}");
    assert!(before.contains("ids=all\n") && before.contains("region=none\n"), "{before}");
    let said =
        printed(&mut control(&bus, &["detector", "set", "family=tag25h9", "refine=tag", "hamming=1"]), 0);
    assert_eq!(said, "change 1 is in force\n");
    for _ in 0..3 {
        let line = line_of_change(&run, 1);
        assert!(families(&line).iter().all(|family| *family == "tag25h9"), "{line}");
    }
    // What is printed can be put in force again.
    let words: Vec<&str> = ["detector", "set"].into_iter().chain(before.lines()).collect();
    assert_eq!(printed(&mut control(&bus, &words), 0), "change 2 is in force\n");
    assert_eq!(printed(&mut control(&bus, &["detector"]), 0), before);
    let json = &json_lines(&printed(&mut control(&bus, &["detector", "--json"]), 0))[0];
    assert_eq!((&json["change"], &json["state"]), (&2.into(), &"detecting".into()));
    assert_eq!(json["parameters"]["family"], serde_json::json!(["tag36h11", "tag25h9"]));
    assert!(json["statistics"]["frames_searched"].as_u64().unwrap() > 0);
    printed(&mut control(&bus, &["detector", "reset"]), 0);
    let state = printed(&mut control(&bus, &["detector", "state"]), 0);
    assert!(state.starts_with("detector main of camera cam0: detecting, 640x480, change 2\n"), "{state}");
}

#[test]
fn what_is_not_possible_is_said_and_changes_nothing() {
    let _watchdog = Watchdog::of_seconds(120, "refused control");
    let bus = Bus::new();
    let run = scene(&bus);
    run.json();
    for (words, expected) in [
        (&["detector", "set", "decimat=2"][..], "did you mean decimate?"),
        (&["detector", "set", "decimate=2.5"], "1.5 or a whole number from 1 to 128"),
        (&["detector", "set", "family=tag36h12"], "did you mean tag36h11?"),
        (&["detector", "set", "family=mine.toml"], "takes no files"),
        (&["detector", "set", "region=5000,0,10x10"], "640x480"),
        (&["detector", "set", "ids=1", "ids=2"], "ids is set twice"),
        (&["detector", "set"], "name at least one NAME=VALUE"),
        (&["detector", "get", "ids=1"], "write `set ids=1`"),
        (&["detector", "set", "decimate"], "NAME=VALUE"),
        (&["camera", "set", "gain=5"], "there are no controls"),
    ] {
        let error = complained(&mut control(&bus, words), 2);
        assert!(error.contains(expected), "{words:?}: {error}");
    }
    let state = printed(&mut control(&bus, &["detector", "state"]), 0);
    assert!(state.contains("change 0\n"), "{state}");
    let state = printed(&mut control(&bus, &["camera", "state"]), 0);
    assert!(state.starts_with("camera cam0: streaming"), "{state}");
    let error = complained(&mut control(&bus, &["camera"]), 0);
    assert!(error.contains("no controls"), "{error}");
}

#[test]
fn a_role_that_does_not_run_or_was_killed_is_named_after_the_time_that_was_given() {
    let _watchdog = Watchdog::of_seconds(120, "control of nobody");
    let bus = Bus::new();
    let ask = |role: &str| complained(&mut control_waiting(&bus, &[role], "--wait=0.1"), 2);
    assert!(ask("detector").contains("detector main of camera cam0 did not appear"));
    assert!(ask("camera").contains("camera cam0 did not appear"));
    let mut service = bus.start("service", &[]);
    let watcher = bus.start("watch", &[]);
    let waiting = printed(&mut control(&bus, &["detector", "state"]), 0);
    assert!(waiting.starts_with("detector main of camera cam0: waiting for camera"), "{waiting}");
    service.kill();
    assert!(ask("detector").contains("detector main of camera cam0 did not appear"));
    drop(watcher);
}

#[test]
fn a_service_is_started_with_a_region() {
    let _watchdog = Watchdog::of_seconds(120, "region");
    let bus = Bus::new();
    let run = bus.start("run", &["--json", "--region=0,0,8x8"]);
    for _ in 0..3 {
        assert_eq!(run.json()["detections"].as_array().unwrap().len(), 0);
    }
    assert_eq!(printed(&mut control(&bus, &["detector", "set", "region=none"]), 0), "change 1 is in force\n");
    while line_of_change(&run, 1)["detections"].as_array().unwrap().is_empty() {}
}
