//! `tagbus run`: everything together, and nothing afterwards.

use std::collections::BTreeSet;
use std::process::Stdio;

use rustix::process::Signal;
use tagbus_scene::{Scene, SceneConfig};

use crate::support::{Bus, Running, Watchdog, test_data};

/// Pairs of family and id in a line of `watch --json`.
fn tags(line: &serde_json::Value) -> Vec<(String, u32)> {
    let tag = |tag: &serde_json::Value| {
        (tag["family"].as_str().unwrap().to_owned(), tag["id"].as_u64().unwrap() as u32)
    };
    line["detections"].as_array().unwrap().iter().map(tag).collect()
}

fn start(bus: &Bus) -> Running {
    let families = "--family=tag36h11,tagStandard41h12,tag25h9,tagCustom48h12";
    bus.start("run", &["--json", families, "--decimate=1"])
}

#[test]
fn the_built_in_scene_is_seen_with_its_ids_and_the_stamps_of_every_hop() {
    let _watchdog = Watchdog::of_seconds(60, "run");
    let bus = Bus::new();
    let mut run = start(&bus);
    let truth: BTreeSet<_> = Scene::new(SceneConfig::default())
        .unwrap()
        .truth(0)
        .into_iter()
        .map(|tag| (tag.family, tag.id))
        .collect();
    let mut seen = BTreeSet::new();
    for _ in 0..15 {
        let line = run.json();
        assert_eq!((&line["camera"], &line["detector"]), (&"cam0".into(), &"main".into()));
        let stamps = ["dequeue", "publish", "receive", "detect_start", "detect_end", "send", "client"];
        let stamps = stamps.map(|name| line[format!("{name}_ns")].as_u64().unwrap());
        assert!(stamps.is_sorted() && stamps[0] > 0, "{line}");
        assert!(
            line["capture_ns"].is_u64()
                && line["capture_kind"].is_string()
                && line["frames_dropped"].is_u64()
                && line["camera_epoch"].is_u64()
                && line["detector_epoch"].is_u64()
        );
        seen.extend(tags(&line));
    }
    assert!(seen.is_subset(&truth), "{seen:?} are not all of {truth:?}");
    assert!(seen.len() >= 4, "only {seen:?} of {truth:?} were seen");
    assert_eq!(bus.processes().len(), 4);
    run.send(Signal::INT);
    assert_eq!(run.wait().code(), Some(0));
    bus.wait_until_gone();
}

#[test]
fn after_kill_9_of_the_parent_nothing_remains() {
    let _watchdog = Watchdog::of_seconds(90, "kill -9 of run");
    let bus = Bus::new();
    for _ in 0..3 {
        let mut run = start(&bus);
        run.json();
        run.kill();
        bus.wait_until_gone();
    }
}

#[test]
fn the_end_of_one_by_itself_is_the_end_of_all() {
    let _watchdog = Watchdog::of_seconds(60, "end of run");
    let bus = Bus::new();
    let mut run = bus.start("run", &["--json", "--frames=5"]);
    assert_eq!(run.wait().code(), Some(0));
    assert_eq!(run.lines.iter().count(), 5);
    bus.wait_until_gone();
    let mut run = bus.start("run", &["--seconds=0.5"]);
    assert_eq!(run.wait().code(), Some(0));
    bus.wait_until_gone();
    let mut command = bus.command("run", &[]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0), "a closed pipe is a clean end");
    bus.wait_until_gone();
}

#[test]
fn what_crashes_is_started_again_and_the_others_carry_on() {
    let _watchdog = Watchdog::of_seconds(60, "crashes in run");
    let bus = Bus::new();
    let mut run = start(&bus);
    for role in ["camera", "service"] {
        run.json();
        kill_role(&bus, role);
        run.wait_for_complaint(&format!("{role} ended (signal: 9"));
        run.lines.try_iter().count();
        for _ in 0..3 {
            run.json();
        }
    }
    kill_role(&bus, "watch");
    assert_eq!(run.wait().code(), Some(2));
    bus.wait_until_gone();
}

fn kill_role(bus: &Bus, role: &str) {
    let is_role = |process: &i32| {
        let line = std::fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
        line.split(|&byte| byte == 0).nth(1) == Some(role.as_bytes())
    };
    let process = bus.processes().into_iter().find(is_role).unwrap();
    rustix::process::kill_process(rustix::process::Pid::from_raw(process).unwrap(), Signal::KILL).unwrap();
}

#[test]
fn a_recording_is_replayed_to_its_end() {
    let Some(data) = test_data() else { return };
    let _watchdog = Watchdog::of_seconds(60, "replay");
    let bus = Bus::new();
    let source = format!("--source=replay:{}", data.join("real/seq").display());
    let mut run = bus.start("run", &["--json", "--once", &source]);
    let lines: Vec<serde_json::Value> =
        run.lines.iter().map(|line| serde_json::from_str(&line).unwrap()).collect();
    assert_eq!(run.wait().code(), Some(0));
    let seen = lines.iter().filter(|line| tags(line) == [("tag36h11".to_owned(), 12)]).count();
    println!("{} of 93 frames arrived, the tag was seen in {seen}", lines.len());
    assert!(lines.iter().any(|line| line["frame"] == 92), "the last frame did not arrive");
    assert!(seen * 10 >= lines.len() * 9, "the tag was seen in {seen} of {} frames", lines.len());
    bus.wait_until_gone();
}
