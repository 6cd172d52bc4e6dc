//! Every attack once, for a moment each: nobody ends, every frame is accounted for, nothing is left. Times are not looked at.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::path::Path;
use std::process::Command;

#[test]
fn attackers_on_the_bus_break_nothing() {
    let bench = Path::new(env!("CARGO_BIN_EXE_tagbus-bench"));
    let output = Command::new(bench).args(["hostile", "--rounds", "1", "--seconds", "1"]).output().unwrap();
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{table}{}", String::from_utf8_lossy(&output.stderr));
    println!("{table}");
    assert!(table.contains("Nobody ended, every frame that was searched arrived or was counted"), "{table}");
    for attack in ["frames", "detections", "hoard", "deaf", "requests", "visits"] {
        assert!(table.contains(&format!("\n| {attack} |")), "{attack} is not in {table}");
    }
}
