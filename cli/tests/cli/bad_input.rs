//! Mistakes of users get a clear answer.

use std::os::unix::fs::chown;

use crate::support::{Bus, Watchdog, complained, tagbus};

#[test]
fn a_family_that_does_not_exist_is_refused_with_the_nearest_name() {
    for command in ["service", "run", "detect"] {
        let error = complained(&mut tagbus([command, "--family", "tag36h11,tag25h8", "--print-config"]), 2);
        assert!(error.contains("\"tag25h8\", did you mean tag25h9?"), "{command}: {error}");
    }
}

#[test]
fn a_missing_device_and_a_missing_file_are_named() {
    let _watchdog = Watchdog::of_seconds(60, "missing sources");
    let bus = Bus::new();
    for command in ["camera", "run"] {
        let error = complained(&mut bus.command(command, &["--source", "v4l:/dev/video98765"]), 2);
        assert!(error.contains("/dev/video98765") && error.contains("tagbus camera --list"), "{error}");
        let error = complained(&mut bus.command(command, &["--source", "replay:/nowhere/at/all"]), 2);
        assert!(error.contains("/nowhere/at/all"), "{error}");
    }
    let error = complained(&mut bus.command("camera", &["--source", "/dev/video0"]), 2);
    assert!(error.contains("did you mean v4l:/dev/video0?"), "{error}");
    bus.wait_until_gone();
}

#[test]
fn values_that_cannot_be_are_refused_with_what_is_allowed() {
    let bus = Bus::new();
    for (command, flag, word) in [
        ("camera", "--framerate=0", "frame rate 0"),
        ("camera", "--width=3", "3"),
        ("camera", "--format=RGB9", "RGB9"),
        ("service", "--decimate=2.5", "1.5 or a whole number"),
        ("service", "--threads=65", "from 1 to 64"),
        ("service", "--ids=5-1", "1-20,33"),
        ("watch", "--timeout=-1", "timeout of -1"),
        ("run", "--seconds=-1", "-1 seconds"),
        ("watch", "--camera=no/slash", "no/slash"),
        ("camera", "--domain=UPPER", "UPPER"),
    ] {
        let mut arguments = vec![flag];
        if flag.starts_with("--domain") {
            let error = complained(&mut tagbus([command, flag]), 2);
            assert!(error.contains(word), "{flag}: {error}");
            continue;
        }
        if command == "watch" && flag != "--timeout=-1" {
            arguments.push("--timeout=1");
        }
        let error = complained(&mut bus.command(command, &arguments), 2);
        assert!(error.contains(word), "{flag}: {error}");
    }
    bus.wait_until_gone();
}

#[test]
fn a_second_camera_or_detector_of_the_same_name_is_refused_and_the_first_goes_on() {
    let _watchdog = Watchdog::of_seconds(90, "second camera");
    let bus = Bus::new();
    let camera = bus.start("camera", &["--width=320", "--height=240"]);
    let service = bus.start("service", &[]);
    let watch = bus.start("watch", &["--json"]);
    watch.json();
    let error = complained(&mut bus.command("camera", &[]), 2);
    assert!(error.contains("a camera named cam0 is already running"), "{error}");
    let error = complained(&mut bus.command("service", &[]), 2);
    assert!(error.contains("a detector named main is already running"), "{error}");
    let error = complained(&mut bus.command("run", &[]), 2);
    assert!(error.contains("is already running"), "{error}");
    let frame = watch.json()["frame"].as_u64();
    assert!((0..20).any(|_| watch.json()["frame"].as_u64() > frame), "the first camera has stopped");
    for role in [watch, service, camera] {
        role.send(rustix::process::Signal::TERM);
        let mut role = role;
        assert_eq!(role.wait().code(), Some(0));
    }
    bus.wait_until_gone();
}

#[test]
fn nobody_publishing_ends_a_watch_that_has_a_timeout() {
    let _watchdog = Watchdog::of_seconds(60, "watch without a service");
    let bus = Bus::new();
    let error = complained(&mut bus.command("watch", &["--timeout=0.3"]), 2);
    assert!(error.contains("detector main of camera cam0 did not appear"), "{error}");
    bus.wait_until_gone();
}

#[test]
fn a_domain_of_another_user_is_refused_with_both_users() {
    let bus = Bus::new();
    std::fs::create_dir(bus.domain.root()).unwrap();
    if chown(bus.domain.root(), Some(4242), None).is_err() {
        eprintln!("SKIPPED: only root can give a folder to another user");
        return;
    }
    for command in ["camera", "service", "watch", "run"] {
        let error = complained(&mut bus.command(command, &[]), 2);
        let users = error.contains("uid 4242") && error.contains(&format!("uid {}", bus.domain.uid()));
        assert!(users && error.contains("sudo -u '#4242'"), "{command}: {error}");
    }
}
