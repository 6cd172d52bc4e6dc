//! What is known as rows of text, 80 columns wide, for a screen and for a pipe.

use tagbus_message::histogram::Histogram;
use tagbus_message::stats::{
    CAMERA_HOPS, CLIENT_HOPS, CameraStats, ClientStats, DETECTOR_HOPS, DetectorStats,
};

use super::seen::{ClientLife, DetectorKey, Seen, camera_state, client_name, detector_state};
use super::track::{Counted, Life, Track};
use crate::units;

/// Columns before those of the quantiles.
const LEFT: usize = 44;

/// What a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The first one.
    Title,
    /// What is wrong.
    Trouble,
    /// A role.
    Head,
    /// Numbers of it.
    Plain,
}

/// A row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) kind: Kind,
    pub(super) text: String,
}

impl Row {
    fn new(kind: Kind, text: String) -> Self {
        Self { kind, text }
    }

    fn plain(text: String) -> Self {
        Self::new(Kind::Plain, text)
    }
}

/// Everything, the troubles first.
pub(super) fn of(seen: &Seen, domain: &str, now_ns: u64) -> Vec<Row> {
    let mut rows = vec![Row::new(Kind::Title, title(seen, domain))];
    if seen.is_empty() {
        rows.push(Row::plain(
            "Nothing is there yet: start a camera and a service, or `tagbus run`, in this domain".to_owned(),
        ));
    }
    let troubles = seen.troubles(now_ns).into_iter();
    rows.extend(troubles.map(|trouble| Row::new(Kind::Trouble, format!("! {trouble}"))));
    for camera in seen.camera_names() {
        if let Some(track) = seen.cameras.get(camera) {
            rows.extend(camera_rows(camera, track));
        }
        for key in seen.detector_keys(camera) {
            if let Some(track) = seen.detectors.get(key) {
                rows.extend(detector_rows(key, track));
            }
            for (client, track) in seen.clients_of(key) {
                rows.extend(client_rows(track, seen.client_life(client, track, now_ns)));
            }
        }
    }
    rows
}

fn title(seen: &Seen, domain: &str) -> String {
    format!(
        "tagbus top  domain {domain}  {}, {}, {}, the last 5 s",
        units::of(seen.cameras.len() as u64, "camera"),
        units::of(seen.detectors.len() as u64, "detector"),
        units::of(seen.clients.len() as u64, "client"),
    )
}

fn camera_rows(name: &str, track: &Track<CameraStats>) -> Vec<Row> {
    let camera = track.last();
    let state = state_of(track.life(), camera_state(camera).name());
    let mut rows = vec![head(&format!("camera {name} ({})  {state}", camera.process))];
    rows.push(Row::plain(format!(
        "  {} frames/s, {} frames; lost: {} driver, {} damaged, {} no memory; {} copied",
        rate(track, |camera| camera.frames),
        camera.frames,
        camera.lost_in_driver,
        camera.lost_damaged,
        camera.lost_no_loan,
        camera.copied
    )));
    rows.push(memory(camera.touched_bytes, camera.reserved_bytes));
    rows.extend(hop_rows(track, &CAMERA_HOPS));
    rows
}

fn detector_rows(key: &DetectorKey, track: &Track<DetectorStats>) -> Vec<Row> {
    let detector = track.last();
    let state = state_of(track.life(), detector_state(detector).name());
    let DetectorKey { camera, detector: name } = key;
    let mut rows = vec![head(&format!("detector {name} of {camera} ({})  {state}", detector.process))];
    rows.push(Row::plain(format!(
        "  {} frames/s, {} searched, {} skipped, {} refused, {} unwatched",
        rate(track, |detector| detector.searched),
        detector.searched,
        detector.skipped,
        detector.refused,
        detector.unwatched
    )));
    rows.push(Row::plain(format!(
        "  {} tags/s, {} messages to {}, {}",
        rate(track, |detector| detector.tags),
        detector.messages,
        units::of(detector.subscribers.into(), "subscriber"),
        memory(detector.touched_bytes, detector.reserved_bytes).text.trim_start()
    )));
    rows.extend(hop_rows(track, &DETECTOR_HOPS));
    rows
}

fn client_rows(track: &Track<ClientStats>, life: ClientLife) -> Vec<Row> {
    let client = track.last();
    let state = match life {
        ClientLife::Alive => "",
        life => life.name(),
    };
    let mut rows = vec![head(&format!("client {} ({})  {state}", client_name(track), client.process))];
    rows.push(Row::plain(format!(
        "  {} messages/s, {} received, {} missed, {} refused",
        rate(track, |client| client.received),
        client.received,
        client.missed,
        client.refused
    )));
    rows.extend(hop_rows(track, &CLIENT_HOPS));
    rows
}

fn state_of(life: Life, state: &str) -> String {
    match life {
        Life::Alive => state.replace('_', " "),
        Life::Silent => "stuck".to_owned(),
        Life::Halted => "halted".to_owned(),
        Life::Gone => "gone".to_owned(),
    }
}

fn head(left: &str) -> Row {
    let left: String = left.trim_end().chars().take(LEFT - 1).collect();
    Row::new(Kind::Head, format!("{left:<LEFT$}{}", columns(["p50", "p95", "p99", "max"].map(str::to_owned))))
}

fn columns(values: [String; 4]) -> String {
    values.iter().map(|value| format!("{value:>9}")).collect()
}

fn memory(touched: u64, reserved: u64) -> Row {
    Row::plain(format!("  {} of {} reserved touched", units::bytes(touched), units::bytes(reserved)))
}

/// A rate of somebody who speaks; one who does not has none.
fn rate<T: Counted>(track: &Track<T>, count: impl Fn(&T) -> u64) -> String {
    match track.rate(count) {
        Some(rate) if track.life() == Life::Alive => format!("{rate:.1}"),
        _ => "-".to_owned(),
    }
}

fn hop_rows<T: Counted>(track: &Track<T>, names: &[&str]) -> Vec<Row> {
    let row = |(number, name): (usize, &&str)| {
        let hop = track.hop(number);
        let backwards = track.last().hops()[number].backwards;
        let odd = if backwards > 0 { format!("  {backwards} backwards") } else { String::new() };
        let left = format!("  {name}{odd}");
        Row::plain(format!("{left:<LEFT$}{}", columns(quantiles(&hop))))
    };
    names.iter().enumerate().map(row).collect()
}

fn quantiles(hop: &Histogram) -> [String; 4] {
    let told = |ns: Option<f64>| ns.map_or("-".to_owned(), |ns| units::time(ns / 1e3));
    [
        told(hop.quantile_ns(0.5)),
        told(hop.quantile_ns(0.95)),
        told(hop.quantile_ns(0.99)),
        told((hop.count > 0).then_some(hop.max_ns as f64)),
    ]
}
