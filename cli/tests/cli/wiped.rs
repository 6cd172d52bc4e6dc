//! Shared memory that somebody empties under running roles.

use std::fs;
use std::path::Path;

use rustix::process::Signal;

use crate::support::{Bus, Watchdog};

#[test]
fn roles_whose_shared_memory_is_emptied_say_so_begin_anew_and_are_found_by_old_and_new_clients() {
    let _watchdog = Watchdog::of_seconds(120, "emptied shared memory");
    let bus = Bus::new();
    let mut run = bus.start("run", &["--json", "--framerate=60"]);
    run.json();
    for name in bus.domain.leftovers().unwrap() {
        // What went by itself meanwhile is gone, too.
        let _ = fs::remove_file(Path::new("/dev/shm").join(name));
    }
    let mut said = Vec::new();
    while said.len() < 2 {
        let line = run.complaints.recv().unwrap();
        if line.contains("were removed (logind does that at logout") {
            said.push(line);
        }
    }
    assert!(said.iter().any(|line| line.contains("camera cam0:")), "{said:?}");
    assert!(said.iter().any(|line| line.contains("detector main of cam0:")), "{said:?}");
    let mut newcomer = bus.start("watch", &["--json", "--timeout=60"]);
    let published = |line: &serde_json::Value| line["publish_ns"].as_u64().unwrap();
    let first = published(&newcomer.json());
    while published(&run.json()) < first {}
    newcomer.send(Signal::INT);
    newcomer.wait();
    run.send(Signal::INT);
    assert_eq!(run.wait().code(), Some(0));
    bus.wait_until_gone();
}
