//! Sixty kills of random roles of a whole machine, half of them while the role starts.

use std::path::Path;
use std::process::Command;

/// Kills of running roles, and as many of starting ones.
const KILLS: &str = "30";
const SEED: &str = "20240607";

#[test]
fn a_machine_whose_roles_are_killed_at_random_delivers_again_leaks_nothing_and_panics_nowhere() {
    let bench = Path::new(env!("CARGO_BIN_EXE_tagbus-bench"));
    // Whatever does not recover, ends, panics or is left over makes the bench fail; a recovery that hangs does so after 20 s.
    let mut command = Command::new(bench);
    command.args(["chaos", "--kills", KILLS, "--seed", SEED, "--startup"]);
    let output = command.output().unwrap();
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaints}");
    let table = String::from_utf8(output.stdout).unwrap();
    println!("{table}");
    for kind in ["running", "starting"] {
        let row = format!("| {kind} | all | {KILLS} |");
        assert!(table.contains(&row), "{row} is not in {table}");
    }
}
