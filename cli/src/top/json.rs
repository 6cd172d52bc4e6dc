//! What is known as one JSON object, for scripts.

use serde_json::{Map, Value, json};
use tagbus_message::stats::{
    CAMERA_HOPS, CLIENT_HOPS, CameraStats, ClientStats, DETECTOR_HOPS, DetectorStats,
};

use super::seen::{ClientLife, DetectorKey, Seen, camera_state, client_name, detector_state};
use super::track::{Counted, Life, Track};

/// The object.
pub(super) fn object(seen: &Seen, domain: &str, now_ns: u64) -> Value {
    let cameras = seen.cameras.iter().map(|(name, track)| camera_json(name, track, now_ns));
    let detectors = seen.detectors.iter().map(|(key, track)| detector_json(key, track, now_ns));
    let clients = seen
        .clients
        .iter()
        .map(|(key, track)| client_json(&key.detector, track, seen.client_life(key, track, now_ns), now_ns));
    json!({
        "domain": domain,
        "monotonic_ns": now_ns,
        "troubles": seen.troubles(now_ns),
        "cameras": cameras.collect::<Vec<_>>(),
        "detectors": detectors.collect::<Vec<_>>(),
        "clients": clients.collect::<Vec<_>>(),
    })
}

fn camera_json(name: &str, track: &Track<CameraStats>, now_ns: u64) -> Value {
    let camera = track.last();
    let mut value = role(track, life_name(track.life()), &CAMERA_HOPS, now_ns);
    extend(
        &mut value,
        json!({
            "camera": name,
            "state": camera_state(camera).name(),
            "frames": camera.frames,
            "frames_per_s": track.rate(|camera| camera.frames),
            "lost": { "driver": camera.lost_in_driver, "damaged": camera.lost_damaged, "no_memory": camera.lost_no_loan },
            "copied": camera.copied,
            "reserved_bytes": camera.reserved_bytes,
            "touched_bytes": camera.touched_bytes,
        }),
    );
    value
}

fn detector_json(key: &DetectorKey, track: &Track<DetectorStats>, now_ns: u64) -> Value {
    let detector = track.last();
    let mut value = role(track, life_name(track.life()), &DETECTOR_HOPS, now_ns);
    extend(
        &mut value,
        json!({
            "camera": key.camera,
            "detector": key.detector,
            "state": detector_state(detector).name(),
            "subscribers": detector.subscribers,
            "searched": detector.searched,
            "searched_per_s": track.rate(|detector| detector.searched),
            "skipped": detector.skipped,
            "refused": detector.refused,
            "unwatched": detector.unwatched,
            "tags": detector.tags,
            "tags_per_s": track.rate(|detector| detector.tags),
            "messages": detector.messages,
            "reserved_bytes": detector.reserved_bytes,
            "touched_bytes": detector.touched_bytes,
        }),
    );
    value
}

fn client_json(key: &DetectorKey, track: &Track<ClientStats>, life: ClientLife, now_ns: u64) -> Value {
    let client = track.last();
    let behind = match life {
        ClientLife::Stuck { behind, .. } => behind,
        ClientLife::Alive | ClientLife::Gone => None,
    };
    let mut value = role(track, life.name(), &CLIENT_HOPS, now_ns);
    extend(
        &mut value,
        json!({
            "camera": key.camera,
            "detector": key.detector,
            "client": client_name(track),
            "messages_behind": behind,
            "received": client.received,
            "received_per_s": track.rate(|client| client.received),
            "missed": client.missed,
            "refused": client.refused,
        }),
    );
    value
}

/// What all have.
fn role<T: Counted>(track: &Track<T>, life: &str, names: &[&str], now_ns: u64) -> Value {
    let last = track.last();
    json!({
        "process": last.process(),
        "life": life,
        "age_s": track.age(now_ns).as_secs_f64(),
        "running_s": now_ns.saturating_sub(last.started_ns()) as f64 / 1e9,
        "epoch": last.epoch(),
        "hops": hops(track, names),
    })
}

fn extend(value: &mut Value, more: Value) {
    if let (Value::Object(value), Value::Object(more)) = (value, more) {
        value.extend(more);
    }
}

/// The name of a life in JSON.
fn life_name(life: Life) -> &'static str {
    match life {
        Life::Alive => "alive",
        Life::Silent => "stuck",
        Life::Halted => "halted",
        Life::Gone => "gone",
    }
}

fn hops<T: Counted>(track: &Track<T>, names: &[&str]) -> Map<String, Value> {
    let hop = |(number, name): (usize, &&str)| {
        let hop = track.hop(number);
        let us = |share| hop.quantile_ns(share).map(|ns| ns / 1e3);
        let value = json!({
            "count": hop.count,
            "p50_us": us(0.5),
            "p95_us": us(0.95),
            "p99_us": us(0.99),
            "max_us": (hop.count > 0).then_some(hop.max_ns as f64 / 1e3),
            "mean_us": hop.mean_ns().map(|ns| ns / 1e3),
            "backwards": track.last().hops()[number].backwards,
        });
        ((*name).to_owned(), value)
    };
    names.iter().enumerate().map(hop).collect()
}
