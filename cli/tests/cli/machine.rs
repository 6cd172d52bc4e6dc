//! `tagbus run --config`: a whole machine from one file, which changes while it runs.

use std::fs;
use std::path::PathBuf;

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::support::{Bus, Folder, Running, Watchdog, complained, json_lines, printed, tagbus};

/// A machine on a bus of its own, and its file.
struct Machine {
    bus: Bus,
    _folder: Folder,
    file: PathBuf,
}

impl Machine {
    fn new(tables: &str) -> Self {
        let (bus, folder) = (Bus::new(), Folder::new());
        let machine = Self { file: folder.file("robot.toml"), bus, _folder: folder };
        machine.write(tables);
        machine
    }

    fn write(&self, tables: &str) {
        // Another file with the same name: nobody reads half of it.
        let draft = self.file.with_extension("draft");
        fs::write(&draft, format!("family = \"tag36h11\"\nframerate = 60\n{tables}")).unwrap();
        fs::rename(draft, &self.file).unwrap();
    }

    fn run(&self) -> Running {
        self.bus.start("run", &["--config", self.file.to_str().unwrap()])
    }

    /// What a detector says of itself.
    fn state(&self, camera: &str, detector: &str) -> Value {
        let mut command = tagbus(["control", "detector", "state", "--json", "--wait=60"]);
        command.arg("--domain").arg(self.bus.domain.name()).arg("--root").arg(self.bus.domain.root());
        command.args(["--camera", camera, "--detector", detector]);
        json_lines(&printed(&mut command, 0)).remove(0)
    }

    fn watch(&self, camera: &str, detector: &str) -> Running {
        self.bus.start("watch", &["--json", "--camera", camera, "--detector", detector, "--timeout=60"])
    }
}

/// Ends a watcher in good order: one that is killed leaves its traces to others.
fn end(mut watch: Running) {
    watch.send(Signal::INT);
    watch.wait();
}

const TWO_CAMERAS: &str = "\
[cameras.front]
source = \"scene:2\"
[cameras.front.detectors.near]
decimate = 1
process = \"vision\"
[cameras.front.detectors.far]
decimate = 4
[cameras.rear]
width = 320
height = 240
[cameras.rear.detectors.main]
process = \"vision\"
";

#[test]
fn every_camera_and_every_detector_of_the_file_runs_and_all_end_together() {
    let _watchdog = Watchdog::of_seconds(120, "a whole machine");
    let machine = Machine::new(TWO_CAMERAS);
    let mut run = machine.run();
    for (camera, detector, width) in [("front", "near", 640), ("front", "far", 640), ("rear", "main", 320)] {
        let watch = machine.watch(camera, detector);
        let line = watch.json();
        assert_eq!((&line["camera"], &line["detector"]), (&camera.into(), &detector.into()));
        assert_eq!(machine.state(camera, detector)["frame_size"][0], width);
        end(watch);
    }
    // The supervisor, two cameras, and two processes with three detectors.
    let alive = || machine.bus.processes().len();
    while alive() != 5 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    run.send(Signal::TERM);
    assert_eq!(run.wait().code(), Some(0));
    machine.bus.wait_until_gone();
}

#[test]
fn a_changed_file_changes_a_detector_while_it_runs_and_starts_anew_only_what_must_be() {
    let _watchdog = Watchdog::of_seconds(120, "a changed file");
    let machine = Machine::new(TWO_CAMERAS);
    let mut run = machine.run();
    let near = machine.watch("front", "near");
    assert_eq!(near.json()["change"], 0);
    machine.write(&TWO_CAMERAS.replace("decimate = 1\n", "decimate = 3\nids = \"1-20\"\n"));
    run.send(Signal::HUP);
    run.wait_for_complaint("service vision changed while it runs: decimate=3.0 ids=1-20");
    let mut line = near.json();
    while line["change"] == 0 {
        line = near.json();
    }
    assert_eq!(line["change"], 1);
    let parameters = &machine.state("front", "near")["parameters"];
    assert_eq!((&parameters["decimate"], &parameters["ids"]), (&3.0.into(), &json!([[1, 20]])));
    // Without a signal, too; a camera cannot change while it runs.
    machine.write(&TWO_CAMERAS.replace("width = 320", "width = 480"));
    run.wait_for_complaint("service vision changed while it runs: decimate=1.0 ids=all");
    run.wait_for_complaint("camera rear is started anew: a camera reads its settings at its start");
    let rear = machine.watch("rear", "main");
    while machine.state("rear", "main")["frame_size"] != json!([480, 240]) {
        rear.json();
    }
    [near, rear].into_iter().for_each(end);
    run.send(Signal::INT);
    assert_eq!(run.wait().code(), Some(0));
    machine.bus.wait_until_gone();
}

#[test]
fn what_is_added_to_the_file_starts_what_is_removed_ends_and_a_wrong_file_changes_nothing() {
    let _watchdog = Watchdog::of_seconds(120, "cameras that come and go");
    let machine = Machine::new("[cameras.front]\n");
    let mut run = machine.run();
    let front = machine.watch("front", "main");
    front.json();
    machine.write("[cameras.front]\nwidht = 3\n");
    run.send(Signal::HUP);
    run.wait_for_complaint("unknown key \"widht\", did you mean width?");
    front.json();
    machine.write("[cameras.rear]\n");
    run.send(Signal::HUP);
    run.wait_for_complaint("camera front is not in the file any more");
    let rear = machine.watch("rear", "main");
    rear.json();
    end(rear);
    end(front);
    while machine.bus.processes().len() != 3 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    run.send(Signal::INT);
    assert_eq!(run.wait().code(), Some(0));
    machine.bus.wait_until_gone();
}

#[test]
fn what_crashes_or_fails_is_started_again_and_the_others_carry_on() {
    let _watchdog = Watchdog::of_seconds(120, "crashes of a machine");
    let machine = Machine::new("[cameras.front]\n[cameras.lost]\nsource = \"replay:/nonexistent\"\n");
    let mut run = machine.run();
    run.wait_for_complaint("camera lost ended (exit status: 2): starting it again");
    run.wait_for_complaint("camera lost ended (exit status: 2): starting it again");
    let front = machine.watch("front", "main");
    front.json();
    end(front);
    run.send(Signal::INT);
    assert_eq!(run.wait().code(), Some(0));
    machine.bus.wait_until_gone();
}

#[test]
fn a_file_without_a_usable_camera_is_refused_at_the_start() {
    for (tables, words) in [
        ("[cameras]\n", "names no camera"),
        ("[cameras.a]\nsorce = \"scene\"\n", "did you mean source?"),
        ("[cameras.a.detectors.b]\ndecimate = 1.7\n", "1.7"),
    ] {
        let machine = Machine::new(tables);
        let mut command = tagbus(["run", "--seconds=20", "--config"]);
        let complaint =
            complained(command.arg(&machine.file).arg("--root").arg(machine.bus.domain.root()), 2);
        assert!(complaint.contains(words), "{tables}: {complaint}");
    }
}
