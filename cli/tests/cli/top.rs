//! `tagbus top`: on a terminal, as JSON and as a page for Prometheus; and how soon it says what is wrong.

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::thread;
use std::time::{Duration, Instant};

use prometheus_parse::{HistogramCount, Sample, Scrape, Value};
use rustix::process::Signal;

use crate::support::{Bus, Folder, Running, Watchdog, complained, json_lines, printed};
use crate::terminal::Terminal;

/// A camera, a detector and a client at work.
struct Work {
    camera: Running,
    service: Running,
    watch: Running,
}

impl Work {
    fn start(bus: &Bus) -> Self {
        Self::with_camera(bus, &["--width=320", "--height=240", "--framerate=30"])
    }

    fn with_camera(bus: &Bus, camera: &[&str]) -> Self {
        let camera = bus.start("camera", camera);
        let service = bus.start("service", &[]);
        let watch = bus.start("watch", &["--json"]);
        watch.line();
        Self { camera, service, watch }
    }
}

fn row_of<'a>(rows: &'a [String], name: &str) -> Option<&'a str> {
    let row = rows.iter().find(|row| row.split_whitespace().next() == Some(name));
    row.map(String::as_str)
}

/// Whether a hop has its four times.
fn has_times(rows: &[String], hop: &str) -> bool {
    let times = row_of(rows, hop).unwrap_or_default();
    times.split_whitespace().filter(|word| matches!(*word, "us" | "ms" | "s")).count() == 4
}

#[test]
fn everything_of_a_camera_a_detector_and_a_client_is_on_a_screen_of_80_by_24() {
    let _watchdog = Watchdog::of_seconds(120, "top on a terminal");
    let bus = Bus::new();
    let _work = Work::start(&bus);
    let mut top = Terminal::start(&bus.command("top", &[]));
    let hops = ["capture", "publish", "receive", "start", "binarize", "cluster", "fit", "identify", "detect"];
    let all = hops.iter().chain(&["send", "wake", "deliver", "total"]);
    top.wait_until("times of all hops", |rows| {
        // A built-in source has no moment before it begins to fill the frame.
        all.clone().filter(|hop| **hop != "capture").all(|hop| has_times(rows, hop))
    });
    for text in [
        "camera cam0",
        "detector main of cam0",
        "client watch",
        "streaming",
        "detecting",
        "frames/s",
        "tags/s",
        "messages/s",
        "lost: 0 driver, 0 damaged, 0 no memory",
        "missed",
        "touched",
        "p50      p95      p99      max",
        "q, Esc: end",
    ] {
        top.wait_for(text);
    }
    println!("{}", top.rows().join("\n"));
    top.press(b"q");
    assert_eq!(top.end().code(), Some(0));
}

#[test]
fn an_empty_bus_is_no_error_and_every_key_that_ends_it_leaves_the_terminal_as_it_was() {
    let _watchdog = Watchdog::of_seconds(120, "top on an empty bus");
    let bus = Bus::new();
    for keys in [&b"q"[..], b"\x1b", b"\x03"] {
        let mut top = Terminal::start(&bus.command("top", &[]));
        top.wait_for("Nothing is there yet");
        top.press(keys);
        assert_eq!(top.end().code(), Some(0));
    }
    assert!(printed(&mut bus.command("top", &[]), 0).contains("Nothing is there yet"));
    let json = &json_lines(&printed(&mut bus.command("top", &["--json"]), 0))[0];
    assert_eq!(json["cameras"].as_array().unwrap().len(), 0);
    bus.wait_until_gone();
}

#[test]
fn a_client_that_is_stopped_a_service_and_a_camera_that_are_killed_are_each_said() {
    let _watchdog = Watchdog::of_seconds(240, "faults in top");
    let bus = Bus::new();
    let mut work = Work::start(&bus);
    let top = Terminal::start(&bus.command("top", &[]));
    top.wait_until("times", |rows| has_times(rows, "total"));

    work.watch.send(Signal::STOP);
    let client = format!("client watch (process {}): stuck, took nothing for ", work.watch.number());
    let took = top.wait_for(&client);
    top.wait_for("behind");
    println!("a client that is stopped was said after {:.2} s", took.as_secs_f64());
    let stuck = format!("client of main of cam0 (process {}): stuck", work.watch.number());
    let late = printed(&mut bus.command("top", &[]), 0);
    assert!(late.contains(&stuck), "one who looks only now does not see it:\n{late}");
    work.watch.send(Signal::CONT);
    top.wait_until("end of the trouble", |rows| !rows.iter().any(|row| row.contains("stuck")));

    work.service.kill();
    let gone = format!("detector main of cam0 (process {}): gone", work.service.number());
    let took = top.wait_for(&gone);
    println!("a service that was killed was said after {:.2} s", took.as_secs_f64());
    let shown =
        top.wait_until("no detector", |rows| !rows.iter().any(|row| row.contains("detector main of")));
    println!("it was shown {:.1} s more", shown.as_secs_f64());
    work.service = bus.start("service", &[]);
    top.wait_until("the new detector", |rows| has_times(rows, "detect"));

    work.camera.kill();
    let took = top.wait_for(&format!("camera cam0 (process {}): gone", work.camera.number()));
    println!("a camera that was killed was said after {:.2} s", took.as_secs_f64());
}

/// Frames until it is told to end, and none when it is started again.
const STAND_IN: &str = r#"#!/bin/sh
folder=$(dirname "$0")
if [ ! -e "$folder/go" ]; then
    while [ ! -e "$folder/go" ]; do head -c 1536 /dev/zero; sleep 0.05; done
    exit 1
fi
exec sleep 60
"#;

#[test]
fn a_camera_whose_device_gives_no_frames_is_said() {
    let _watchdog = Watchdog::of_seconds(120, "lost camera in top");
    let (bus, folder) = (Bus::new(), Folder::new());
    let program = folder.file("stand-in");
    fs::write(&program, STAND_IN).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let source = format!("--source=rpicam:{}", program.display());
    let work = Work::with_camera(&bus, &[&source, "--width=64", "--height=16"]);
    let top = Terminal::start(&bus.command("top", &[]));
    top.wait_until("times", |rows| has_times(rows, "total"));
    fs::write(folder.file("go"), "").unwrap();
    let camera = format!("camera cam0 (process {}): waiting: the device is there", work.camera.number());
    let took = top.wait_for(&camera);
    println!("a camera whose device gives no frames was said after {:.2} s", took.as_secs_f64());
}

#[test]
fn json_holds_everything_once() {
    let _watchdog = Watchdog::of_seconds(120, "top --json");
    let bus = Bus::new();
    let work = Work::start(&bus);
    // The client joins the recorder a moment after it connected.
    let json = until(Duration::from_secs(30), || {
        let json = json_lines(&printed(&mut bus.command("top", &["--json"]), 0)).remove(0);
        json["clients"][0]["received_per_s"].is_f64().then_some(json)
    });
    println!("{json}");
    let (camera, detector, client) = (&json["cameras"][0], &json["detectors"][0], &json["clients"][0]);
    assert_eq!((&camera["camera"], &camera["state"]), (&"cam0".into(), &"streaming".into()));
    assert_eq!((&detector["camera"], &detector["detector"]), (&"cam0".into(), &"main".into()));
    assert_eq!((&client["client"], &client["detector"]), (&"watch".into(), &"main".into()));
    for (role, running) in [(camera, &work.camera), (detector, &work.service), (client, &work.watch)] {
        assert_eq!(role["process"], running.number());
        assert!(role["age_s"].as_f64().unwrap() < 60.0, "{role}");
        for (name, hop) in role["hops"].as_object().unwrap() {
            let us = ["p50_us", "p95_us", "p99_us", "max_us"].map(|key| hop[key].as_f64());
            assert!(us.is_sorted(), "{name}: {hop}");
            assert!(us[0].is_some() || name == "capture", "{name}: {hop}");
        }
    }
    assert!(camera["frames_per_s"].as_f64().unwrap() > 0.0 && camera["frames"].as_u64().unwrap() > 0);
    assert!(camera["reserved_bytes"].as_u64().unwrap() >= camera["touched_bytes"].as_u64().unwrap());
    assert!(camera["touched_bytes"].as_u64().unwrap() >= 320 * 240);
    for key in ["driver", "damaged", "no_memory"] {
        assert_eq!(camera["lost"][key], 0);
    }
    assert!(detector["messages"].as_u64().unwrap() > 0 && client["received"].as_u64().unwrap() > 0);
    assert!(detector["hops"]["detect"]["count"].as_u64().unwrap() > 0);
}

/// Tries again until there is something.
fn until<T>(patience: Duration, mut attempt: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = attempt() {
            return found;
        }
        assert!(started.elapsed() < patience, "it did not come within {patience:?}");
        thread::sleep(Duration::from_millis(50));
    }
}

/// What a server at this address answers: its first line and its body.
fn fetch(address: &str, path: &str) -> (String, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    // What follows would be in pieces with their lengths between.
    assert!(!head.to_lowercase().contains("transfer-encoding"), "{head}");
    (head.to_owned(), body.to_owned())
}

fn scrape(address: &str) -> Vec<Sample> {
    let (head, body) = fetch(address, "/metrics");
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("text/plain; version=0.0.4"), "{head}");
    Scrape::parse(body.lines().map(|line| Ok(line.to_owned()))).unwrap().samples
}

fn find<'a>(samples: &'a [Sample], metric: &str, labels: &[(&str, &str)]) -> Option<&'a Value> {
    let has = |sample: &&Sample| {
        sample.metric == metric && labels.iter().all(|(name, value)| sample.labels.get(name) == Some(*value))
    };
    samples.iter().find(has).map(|sample| &sample.value)
}

fn number(samples: &[Sample], metric: &str, labels: &[(&str, &str)]) -> f64 {
    match find(samples, metric, labels) {
        Some(Value::Counter(number) | Value::Gauge(number) | Value::Untyped(number)) => *number,
        other => panic!("{metric} {labels:?} is {other:?}"),
    }
}

/// The buckets of the one series of a hop. The parser makes several of it, because it takes labels in any order.
fn buckets(samples: &[Sample], hop: &str) -> Vec<HistogramCount> {
    let of_hop =
        |sample: &&Sample| sample.metric == "tagbus_hop_seconds" && sample.labels.get("hop") == Some(hop);
    let of_sample = |sample: &Sample| match &sample.value {
        Value::Histogram(buckets) => buckets.clone(),
        other => panic!("the histogram of {hop} is {other:?}"),
    };
    let mut all: Vec<_> = samples.iter().filter(of_hop).flat_map(of_sample).collect();
    all.sort_by(|a, b| a.less_than.total_cmp(&b.less_than));
    all
}

#[test]
fn a_page_for_prometheus_has_the_histogram_of_every_hop_and_all_counts() {
    let _watchdog = Watchdog::of_seconds(120, "top --metrics");
    let bus = Bus::new();
    let _work = Work::start(&bus);
    let mut top = bus.start("top", &["--metrics=127.0.0.1:0"]);
    let said = top.complaints.recv().unwrap();
    let address = said.split("http://").nth(1).unwrap().trim_end_matches("/metrics").to_owned();
    let samples = until(Duration::from_secs(30), || {
        let samples = scrape(&address);
        let is_up = |role: &&str| matches!(find(&samples, "tagbus_up", &[("role", role)]), Some(Value::Gauge(up)) if *up == 1.0);
        // A role's first copy may be older than its first frame.
        let has_counted = |hop: &&str| buckets(&samples, hop).last().is_some_and(|bucket| bucket.count > 0.0);
        let is_whole = ["camera", "detector", "client"].iter().all(is_up)
            && ["publish", "detect", "deliver"].iter().all(has_counted);
        is_whole.then_some(samples)
    });
    for hop in [
        "publish", "receive", "start", "binarize", "cluster", "fit", "identify", "detect", "send", "deliver",
        "total",
    ] {
        let buckets = buckets(&samples, hop);
        let counts: Vec<f64> = buckets.iter().map(|bucket| bucket.count).collect();
        assert!(counts.is_sorted() && counts.len() > 10, "{hop}: {counts:?}");
        assert!(buckets.last().unwrap().less_than.is_infinite() && *counts.last().unwrap() > 0.0, "{hop}");
    }
    let searched =
        number(&samples, "tagbus_frames_searched_total", &[("detector", "main"), ("camera", "cam0")]);
    let detected = buckets(&samples, "detect").last().unwrap().count;
    assert!(detected > 0.0 && (detected - searched).abs() <= 1.0, "{detected} and {searched}");
    for role in ["camera", "detector", "client"] {
        assert!(number(&samples, "tagbus_age_seconds", &[("role", role)]) < 60.0);
    }
    assert_eq!(number(&samples, "tagbus_state", &[("role", "camera"), ("state", "streaming")]), 1.0);
    assert_eq!(number(&samples, "tagbus_state", &[("role", "camera"), ("state", "lost")]), 0.0);
    assert_eq!(number(&samples, "tagbus_frames_lost_total", &[("cause", "driver")]), 0.0);
    let names = [
        "tagbus_tags_total",
        "tagbus_messages_total",
        "tagbus_messages_missed_total",
        "tagbus_frames_skipped_total",
        "tagbus_frames_refused_total",
        "tagbus_memory_reserved_bytes",
        "tagbus_memory_touched_bytes",
    ];
    names.iter().for_each(|name| assert!(number(&samples, name, &[]) >= 0.0));
    let frames = number(&samples, "tagbus_frames_total", &[("camera", "cam0")]);
    until(Duration::from_secs(30), || {
        (number(&scrape(&address), "tagbus_frames_total", &[("camera", "cam0")]) > frames).then_some(())
    });
    assert!(fetch(&address, "/").0.starts_with("HTTP/1.1 404"));
    top.send(Signal::TERM);
    assert_eq!(top.wait().code(), Some(0));
}

#[test]
fn addresses_that_cannot_be_served_are_refused_with_what_is_allowed() {
    let _watchdog = Watchdog::of_seconds(60, "addresses of metrics");
    let bus = Bus::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let complaint = complained(&mut bus.command("top", &["--metrics", &address]), 2);
    assert!(
        complaint.contains(&address) && complaint.contains("another program listens there"),
        "{complaint}"
    );
    for address in ["9464", "localhost:9464", "127.0.0.1:99999"] {
        let complaint = complained(&mut bus.command("top", &["--metrics", address]), 2);
        assert!(complaint.contains("127.0.0.1:9464") && complaint.contains(address), "{complaint}");
    }
    bus.wait_until_gone();
}
