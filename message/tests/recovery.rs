//! What the dead leave, made by hand: each must be mended by the next role that comes.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use iceoryx2::prelude::ipc;
use tagbus_message::bus::{Bus, BusError, Patience};
use tagbus_message::domain::Domain;
use tagbus_message::ports::{FramesIn, FramesOut};
use tagbus_message::qos;
use tagbus_message::stop::Stop;

/// Long enough for any machine: only a hanging test gets there.
const WATCHDOG: Duration = Duration::from_secs(60);
/// What is younger may be in work: iceoryx2's own patience.
const SETTLED: Duration = Duration::from_millis(150);

type Local = ipc::Service;

/// A domain of the test's own; that it was left clean is checked when it is dropped.
struct Ground {
    domain: Domain,
}

impl Ground {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("r{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let root = std::env::temp_dir().join(format!("tb-{name}"));
        Self { domain: Domain::with_root(&name, root).unwrap() }
    }

    fn bus(&self, role: &str) -> Bus<Local> {
        Bus::start(&self.domain, role, &Stop::new().unwrap()).unwrap()
    }

    fn camera(&self) -> Result<FramesOut<Local>, BusError> {
        self.bus("camera cam0").create_frames("cam0", &qos::FRAMES, 64)
    }

    fn viewer(&self) -> FramesIn<Local> {
        self.bus("viewer").open_frames("cam0", 1, Patience::AtMost(WATCHDOG)).unwrap()
    }

    /// Files of this kind that belong to the domain.
    fn files(&self, folder: &Path, end: &str) -> Vec<PathBuf> {
        let own = |path: &PathBuf| {
            let name = path.file_name().unwrap().to_str().unwrap();
            name.starts_with(self.domain.prefix()) && name.ends_with(end)
        };
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(own).collect()
    }

    fn descriptions(&self) -> Vec<PathBuf> {
        self.files(&self.domain.root().join("services"), ".service")
    }
}

impl Drop for Ground {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert_eq!(self.domain.leftovers().unwrap(), Vec::<String>::new());
            assert!(!self.domain.root().exists(), "the root is still there");
        }
    }
}

/// Whether a frame of `camera` comes to `viewer`.
fn is_heard(camera: &FramesOut<Local>, viewer: &FramesIn<Local>) -> bool {
    camera.publisher().loan_slice(1).unwrap().send().unwrap();
    viewer.newest().unwrap().is_some()
}

/// Keeps files under other names while `work` is done, and brings them back.
fn kept<T>(files: &[PathBuf], work: impl FnOnce() -> T) -> T {
    let twin = |path: &PathBuf| path.with_extension("twin");
    files.iter().for_each(|path| fs::hard_link(path, twin(path)).unwrap());
    let outcome = work();
    files.iter().for_each(|path| fs::rename(twin(path), path).unwrap());
    outcome
}

#[test]
fn a_topic_whose_last_user_was_killed_between_marking_and_removing_it_is_made_anew() {
    let ground = Ground::new();
    let _witness = ground.bus("witness");
    let camera = ground.camera().unwrap();
    let files = [ground.descriptions(), ground.files(Path::new("/dev/shm"), ".dynamic")].concat();
    assert_eq!(files.len(), 4, "{files:?}");
    // Everything is removed but these, which say that the topic is being removed.
    kept(&files, || drop(camera));
    std::thread::sleep(SETTLED);
    let camera = ground.camera().unwrap();
    assert!(!files[2..].iter().any(|memory| memory.exists()), "what was marked is still there");
    assert!(is_heard(&camera, &ground.viewer()));
}

#[test]
fn a_topic_whose_memory_was_never_completed_is_made_anew() {
    let ground = Ground::new();
    let witness = ground.bus("witness");
    let camera = ground.camera().unwrap();
    let files = [ground.descriptions(), ground.files(Path::new("/dev/shm"), ".dynamic")].concat();
    kept(&files, || drop(camera));
    for memory in ground.files(Path::new("/dev/shm"), ".dynamic") {
        fs::set_permissions(memory, Permissions::from_mode(0o200)).unwrap();
    }
    std::thread::sleep(SETTLED);
    let camera = witness.create_frames("cam0", &qos::FRAMES, 64).unwrap();
    assert!(!files[2..].iter().any(|memory| memory.exists()), "what was half made is still there");
    assert!(is_heard(&camera, &ground.viewer()));
}

/// Takes away everything by which others would know that the node of this role was ever there: its place stays taken.
fn forget_node(ground: &Ground, others: &[PathBuf]) {
    let nodes = ground.domain.root().join("nodes");
    for entry in fs::read_dir(&nodes).unwrap().map(|entry| entry.unwrap().path()) {
        if others.contains(&entry) {
            continue;
        }
        if entry.is_dir() { fs::remove_dir_all(entry).unwrap() } else { fs::remove_file(entry).unwrap() }
    }
}

fn nodes_of(ground: &Ground) -> Vec<PathBuf> {
    let nodes = fs::read_dir(ground.domain.root().join("nodes")).unwrap();
    nodes.map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_place_that_is_taken_by_nobody_does_not_keep_a_camera_from_coming_back() {
    let ground = Ground::new();
    let _witness = ground.bus("witness");
    let others = nodes_of(&ground);
    let ghost = ground.camera().unwrap();
    forget_node(&ground, &others);
    std::mem::forget(ghost);
    // Somebody has the topic open, so that it lives on with its ghost.
    let viewer = ground.viewer();
    let camera = ground.camera().unwrap();
    assert!(!viewer.is_current());
    drop(viewer);
    assert!(camera.is_in_place(), "who left the old topic removed the new one");
    assert!(is_heard(&camera, &ground.viewer()));
}

#[test]
fn a_place_that_is_taken_by_nobody_does_not_keep_a_detector_from_answering() {
    let ground = Ground::new();
    let _witness = ground.bus("witness");
    let others = nodes_of(&ground);
    let ghost = ground.bus("detector").create_detector_control("cam0", "main").unwrap();
    forget_node(&ground, &others);
    std::mem::forget(ghost);
    let asking = ground.bus("asking");
    let old = asking.open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
    let _desk = ground.bus("detector").create_detector_control("cam0", "main").unwrap();
    assert!(!old.is_current());
    drop(old);
    let asker = asking.open_detector_control("cam0", "main", Patience::AtMost(WATCHDOG)).unwrap();
    assert!(asker.is_served() && asker.is_current());
}

#[test]
fn a_living_camera_is_no_ghost() {
    let ground = Ground::new();
    let _camera = ground.camera().unwrap();
    assert!(matches!(ground.camera(), Err(BusError::Taken { .. })));
}

#[test]
fn who_leaves_a_topic_that_was_emptied_by_force_does_not_take_the_new_one_away() {
    let ground = Ground::new();
    let _witness = ground.bus("witness");
    let (old_camera, old_viewer) = (ground.camera().unwrap(), ground.viewer());
    assert!(old_camera.is_in_place() && old_viewer.is_current());
    for name in ground.domain.leftovers().unwrap() {
        let _ = fs::remove_file(Path::new("/dev/shm").join(name));
    }
    assert!(!old_camera.is_in_place());
    drop(old_camera);
    std::thread::sleep(SETTLED);
    let camera = ground.camera().unwrap();
    assert!(camera.is_in_place() && !old_viewer.is_current());
    let viewer = ground.viewer();
    drop(old_viewer);
    assert!(camera.is_in_place() && viewer.is_current());
    assert!(is_heard(&camera, &viewer));
}

#[test]
fn a_connection_that_is_made_anew_gets_what_comes_and_nothing_twice() {
    let ground = Ground::new();
    let camera = ground.camera().unwrap();
    let mut viewer = ground.viewer();
    assert!(is_heard(&camera, &viewer));
    viewer.connect_anew().unwrap();
    assert!(viewer.newest().unwrap().is_none());
    camera.publisher().loan_slice(7).unwrap().send().unwrap();
    assert_eq!(viewer.receive().unwrap().unwrap().payload().len(), 7);
    assert!(viewer.receive().unwrap().is_none());
}

/// Who is connected is still woken; who comes later is not, until the topic is made anew.
#[test]
fn a_bell_that_was_removed_by_force_is_noticed_on_both_sides() {
    let ground = Ground::new();
    let (camera, viewer) = (ground.camera().unwrap(), ground.viewer());
    let bells = ground.files(Path::new("/dev/shm"), ".bell");
    assert!(bells.len() == 1 && camera.is_in_place() && viewer.is_current());
    fs::remove_file(&bells[0]).unwrap();
    assert!(!camera.is_in_place() && !viewer.is_current());
    let late = ground.viewer();
    assert!(!camera.is_in_place() && late.is_current());
    drop((camera, viewer, late));
    let (camera, viewer) = (ground.camera().unwrap(), ground.viewer());
    assert!(camera.is_in_place() && viewer.is_current());
}
