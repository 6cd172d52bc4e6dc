//! Who may use whom: the table of rooms, held against what `cargo metadata` reports.
//!
//! A new dependency fails here until it is written into [`ROOMS`], which is the place to argue it. Tests and benches of
//! a room (dev-dependencies) may use what they like.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// What a room may use.
struct Room {
    name: &'static str,
    ours: Uses,
    outside: Uses,
}

/// Which dependencies are allowed.
enum Uses {
    Only(&'static [&'static str]),
    Anything,
}

/// The rooms in the order in which a frame passes them.
#[rustfmt::skip]
const ROOMS: [Room; 11] = [
    // Pure: no files, no processes. What a family looks like as text is behind features.
    room("family", &[], &["serde", "toml", "pdf-writer", "png", "svg"]),
    // Its random numbers are its own (scene/src/random.rs).
    room("scene", &["family"], &[]),
    room("detector", &["family"], &["nalgebra"]),
    // Parts of iceoryx2: iceoryx2-bb-posix reads the clock, iceoryx2-bb-linux waits, the others are what a variant of it is made of.
    room("message", &[],
        &["iceoryx2", "iceoryx2-bb-elementary-traits", "iceoryx2-bb-linux", "iceoryx2-bb-posix", "iceoryx2-cal", "rustix"]),
    room("camera", &["message", "scene"],
        &["iceoryx2", "v4l", "libcamera", "dma-buf", "libc", "rustix", "image", "zune-jpeg", "zune-core"]),
    room("service", &["message", "detector", "family"], &["iceoryx2"]),
    // Robot programs link this: its tree is kept tiny.
    room("client", &["message"], &["iceoryx2"]),
    room("cli", &["family", "scene", "detector", "message", "camera", "service", "client"],
        &["clap", "image", "serde", "serde_json", "toml", "indicatif", "ratatui", "tiny_http", "signal-hook", "ctrlc", "sd-notify",
          "rustix"]),
    // The paper's detector as it is written: it shares what a tag looks like with the product, and nothing else.
    room("paper", &["family"], &["nalgebra"]),
    // The test in the virtual machine: what is played to a camera, and a client that judges what comes out.
    room("vm", &["family", "scene", "message", "service", "client"], &[]),
    // Measures everything, beside everybody; nobody depends on it.
    Room { name: "bench", ours: Uses::Anything, outside: Uses::Anything },
];

/// What a room must not reach by any way. It follows from [`ROOMS`] as long as nobody widens one row and forgets what
/// it opens for others.
const UNREACHABLE: [(&str, &[&str]); 7] = [
    ("scene", &["detector", "message"]),
    ("detector", &["message", "camera", "service", "client"]),
    ("message", &["family", "scene", "detector"]),
    ("camera", &["detector", "service", "client"]),
    ("service", &["camera", "client"]),
    ("client", &["family", "scene", "detector", "camera", "service"]),
    ("paper", &["detector", "scene", "message"]),
];

const fn room(name: &'static str, ours: &'static [&'static str], outside: &'static [&'static str]) -> Room {
    Room { name, ours: Uses::Only(ours), outside: Uses::Only(outside) }
}

impl Uses {
    fn allows(&self, name: &str) -> bool {
        match self {
            Self::Only(names) => names.contains(&name),
            Self::Anything => true,
        }
    }
}

/// Crates of the workspace and what they depend on, but for their tests. Crates of ours are called by their room.
type Graph = BTreeMap<String, BTreeSet<String>>;

const OURS: &str = "tagbus-";

fn violations(graph: &Graph) -> Vec<String> {
    let mut found = Vec::new();
    for name in graph.keys().filter(|name| ROOMS.iter().all(|room| room.name != name.as_str())) {
        found.push(format!("{name} is not in the table of rooms"));
    }
    for room in &ROOMS {
        match graph.get(room.name) {
            Some(edges) => found.extend(forbidden_edges(graph, room, edges)),
            None => found.push(format!("{} is in the table of rooms but not in the workspace", room.name)),
        }
    }
    for (room, unreachable) in UNREACHABLE {
        let reached = reachable(graph, room);
        let wrong = unreachable.iter().filter(|name| reached.contains(**name));
        found.extend(wrong.map(|name| format!("{room} reaches {name}")));
    }
    found
}

fn forbidden_edges(graph: &Graph, room: &Room, edges: &BTreeSet<String>) -> Vec<String> {
    let is_forbidden = |name: &&String| match graph.contains_key(name.as_str()) {
        true => name.as_str() == "bench" || !room.ours.allows(name),
        false => !room.outside.allows(name),
    };
    edges.iter().filter(is_forbidden).map(|name| format!("{} must not use {name}", room.name)).collect()
}

fn reachable(graph: &Graph, from: &str) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut ahead = vec![from.to_owned()];
    while let Some(name) = ahead.pop() {
        for next in graph.get(&name).into_iter().flatten() {
            if reached.insert(next.clone()) {
                ahead.push(next.clone());
            }
        }
    }
    reached
}

/// What cargo knows of the workspace's own crates; it needs neither network nor lock file for that.
fn metadata() -> Value {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(workspace)
        .output()
        .expect("cargo built this test, so it can be started");
    assert!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("cargo metadata writes JSON")
}

fn packages(metadata: &Value) -> impl Iterator<Item = &Value> {
    metadata["packages"].as_array().into_iter().flatten()
}

fn name_of(package: &Value) -> String {
    let name = package["name"].as_str().unwrap_or_default();
    name.strip_prefix(OURS).unwrap_or(name).to_owned()
}

/// Optional dependencies and those of other platforms count, too.
fn graph_of(metadata: &Value) -> Graph {
    let edges = |package: &Value| {
        let all = package["dependencies"].as_array().into_iter().flatten();
        all.filter(|edge| edge["kind"] != "dev").map(name_of).collect()
    };
    packages(metadata).map(|package| (name_of(package), edges(package))).collect()
}

#[test]
fn every_room_uses_only_what_the_table_allows() {
    let found = violations(&graph_of(&metadata()));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A build without libclang turns off all default features (tools/libclang), and must lose nothing but video devices.
#[test]
fn v4l_is_the_only_default_feature() {
    for package in packages(&metadata()) {
        let default = package["features"]["default"].as_array().cloned().unwrap_or_default();
        assert!(default.iter().all(|feature| feature == "v4l"), "{}: {default:?}", name_of(package));
    }
}

/// The smallest graph in which nothing is wrong.
fn bare_rooms() -> Graph {
    ROOMS.iter().map(|room| (room.name.to_owned(), BTreeSet::new())).collect()
}

fn with_edge(from: &str, to: &str) -> Vec<String> {
    let mut graph = bare_rooms();
    graph.entry(from.to_owned()).or_default().insert(to.to_owned());
    violations(&graph)
}

#[test]
fn a_forbidden_edge_is_found() {
    for (from, to) in [
        ("family", "image"),
        ("scene", "detector"),
        ("detector", "iceoryx2"),
        ("message", "nalgebra"),
        ("camera", "detector"),
        ("service", "v4l"),
        ("client", "nalgebra"),
        ("cli", "iceoryx2"),
    ] {
        let found = with_edge(from, to);
        assert!(found.contains(&format!("{from} must not use {to}")), "{from} -> {to}: {found:?}");
    }
}

#[test]
fn nobody_may_depend_on_bench() {
    for room in ROOMS {
        assert!(!with_edge(room.name, "bench").is_empty(), "{}", room.name);
    }
}

#[test]
fn an_allowed_edge_is_no_violation() {
    for (from, to) in
        [("detector", "nalgebra"), ("camera", "scene"), ("cli", "client"), ("bench", "criterion")]
    {
        assert_eq!(with_edge(from, to), Vec::<String>::new(), "{from} -> {to}");
    }
}

#[test]
fn what_a_room_reaches_through_another_is_found() {
    let mut graph = bare_rooms();
    for (from, to) in [("client", "message"), ("message", "scene"), ("scene", "detector")] {
        graph.entry(from.to_owned()).or_default().insert(to.to_owned());
    }
    assert!(violations(&graph).contains(&"client reaches detector".to_owned()));
}

#[test]
fn a_room_that_is_in_one_place_only_is_found() {
    let mut graph = bare_rooms();
    graph.insert("viewer".to_owned(), BTreeSet::new());
    graph.remove("service");
    let found = violations(&graph);
    assert!(found.contains(&"viewer is not in the table of rooms".to_owned()), "{found:?}");
    assert!(
        found.contains(&"service is in the table of rooms but not in the workspace".to_owned()),
        "{found:?}"
    );
}

#[test]
fn dependencies_of_tests_do_not_count_and_optional_ones_do() {
    let metadata = serde_json::json!({ "packages": [{ "name": "tagbus-client", "dependencies": [
        { "name": "tagbus-service", "kind": "dev", "optional": false },
        { "name": "tagbus-message", "kind": null, "optional": false },
        { "name": "v4l", "kind": null, "optional": true },
        { "name": "bindgen", "kind": "build", "optional": false },
    ] }] });
    let edges: Vec<_> = graph_of(&metadata)["client"].iter().cloned().collect();
    assert_eq!(edges, ["bindgen", "message", "v4l"]);
}
