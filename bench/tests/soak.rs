//! A minute of many clients, and ten seconds of changes while many listen.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on says where")]

use std::path::Path;
use std::process::Command;

/// Whatever grows, is lost, is mixed, ends, or is left over makes the bench fail; nothing depends on how fast the machine is.
fn passes(arguments: &[&str], verdict: &str) {
    let output =
        Command::new(Path::new(env!("CARGO_BIN_EXE_tagbus-bench"))).args(arguments).output().unwrap();
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{table}{}", String::from_utf8_lossy(&output.stderr));
    println!("{table}");
    assert!(table.contains(verdict), "{table}");
}

#[test]
fn in_a_minute_of_sixteen_clients_slow_and_stuck_ones_among_them_nothing_grows_and_no_frame_is_lost() {
    passes(&["soak", "--minutes", "1"], "Nothing grew");
}

#[test]
fn changes_while_many_listen_take_effect_between_frames_and_nobody_is_refused() {
    passes(&["many", "--seconds", "10"], "Every change took effect between two frames");
}
