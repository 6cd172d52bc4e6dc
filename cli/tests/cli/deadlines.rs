//! `tagbus watch --deadline`: what comes too late is said, with the hop that was to blame.

use crate::support::{Bus, Watchdog, complained, json_lines};

const HOPS: [&str; 6] = ["publish", "receive", "start", "detect", "send", "client"];

/// The lines of so many frames with a deadline, and the summary.
fn watch(bus: &Bus, deadline: &str) -> (Vec<serde_json::Value>, String) {
    let output = bus.command("watch", &["--json", "--frames=10", "--deadline", deadline]).output().unwrap();
    let complaints = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{complaints}");
    (json_lines(&String::from_utf8(output.stdout).unwrap()), complaints)
}

#[test]
fn with_a_deadline_of_a_microsecond_all_are_late_and_with_one_of_a_hundred_seconds_none_is() {
    let _watchdog = Watchdog::of_seconds(120, "watch --deadline");
    let bus = Bus::new();
    let _camera = bus.start("camera", &["--framerate=30"]);
    let _service = bus.start("service", &[]);
    let (lines, summary) = watch(&bus, "0.001");
    assert_eq!(lines.len(), 10);
    for line in &lines {
        let stamp = |name: &str| line[name].as_u64().unwrap() as f64;
        let total_ms = (stamp("client_ns") - stamp("dequeue_ns")) / 1e6;
        assert!((line["late_by_ms"].as_f64().unwrap() - (total_ms - 0.001)).abs() < 1e-3, "{line}");
        assert!(HOPS.contains(&line["late_hop"].as_str().unwrap()), "{line}");
    }
    assert!(summary.contains("10 of 10 frames came later than 1 us: "), "{summary}");
    println!("{summary}");
    let (lines, summary) = watch(&bus, "100000");
    assert!(lines.iter().all(|line| line.get("late_by_ms").is_none() && line.get("late_hop").is_none()));
    assert!(summary.contains("0 of 10 frames came later than 100.0 s\n"), "{summary}");
}

#[test]
fn impossible_deadlines_are_refused_with_what_is_allowed() {
    let bus = Bus::new();
    for deadline in ["0", "-3", "nan", "inf"] {
        let complaint = complained(&mut bus.command("watch", &["--deadline", deadline]), 2);
        assert!(complaint.contains("use a number from 0.001 to 3600000"), "{complaint}");
    }
    assert!(complained(&mut bus.command("watch", &["--deadline=soon"]), 2).contains("soon"));
}
