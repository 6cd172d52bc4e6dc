//! What is known about everybody on the bus, and what is wrong.

use std::collections::BTreeMap;
use std::time::Duration;

use tagbus_message::control::DetectorState;
use tagbus_message::info::CameraState;
use tagbus_message::stats::{CameraStats, ClientStats, DetectorStats};

use super::process::Process;
use super::track::{Counted, Life, STALE, Track};
use crate::units;

/// How long a client may not have said that it took what was sent: longer than from one copy to the next.
const BEHIND: Duration = Duration::from_secs(1);

/// A detector by its names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DetectorKey {
    pub(super) camera: String,
    pub(super) detector: String,
}

/// A client: names need not be unique, and a process can have several.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ClientKey {
    pub(super) detector: DetectorKey,
    started_ns: u64,
    process: u32,
    epoch: u64,
}

impl ClientKey {
    /// The client that wrote a copy.
    pub(super) fn new(detector: DetectorKey, copy: &ClientStats) -> Self {
        Self { detector, started_ns: copy.started_ns, process: copy.process, epoch: copy.epoch }
    }
}

/// Everybody that was heard.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub(super) cameras: BTreeMap<String, Track<CameraStats>>,
    pub(super) detectors: BTreeMap<DetectorKey, Track<DetectorStats>>,
    pub(super) clients: BTreeMap<ClientKey, Track<ClientStats>>,
    mutes: BTreeMap<u128, Mute>,
}

/// Somebody who has a place to publish on and was not heard yet.
#[derive(Debug)]
struct Mute {
    who: String,
    process: u32,
    since_ns: u64,
}

/// How a client is: as any role, or behind what its detector sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ClientLife {
    /// It takes what comes, or nothing comes.
    Alive,
    /// It takes nothing, though there is something.
    Stuck {
        /// How many messages were sent since the last one that it took; `None` when that one was of another start of the detector.
        behind: Option<u64>,
        /// Whether it was stopped by a signal or a debugger.
        halted: bool,
    },
    /// Its process has gone, or it has left the bus.
    Gone,
}

impl ClientLife {
    /// The name in JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::Stuck { .. } => "stuck",
            Self::Gone => "gone",
        }
    }
}

impl Seen {
    /// Whether nobody was heard.
    pub(super) fn is_empty(&self) -> bool {
        self.cameras.is_empty() && self.detectors.is_empty() && self.clients.is_empty()
    }

    /// Whether everybody who speaks has spoken long enough for rates.
    pub(super) fn has_rates(&self) -> bool {
        !self.is_empty()
            && self.cameras.values().all(has_rates)
            && self.detectors.values().all(has_rates)
            && self.clients.values().all(has_rates)
    }

    /// Whether somebody was not heard yet.
    pub(super) fn has_mutes(&self) -> bool {
        !self.mutes.is_empty()
    }

    /// Notes who of those who publish was not heard yet: each by the number of its place, with words for it and its process.
    pub(super) fn note_mutes(&mut self, there: BTreeMap<u128, (String, u32)>, now_ns: u64) {
        self.mutes.retain(|publisher, _| there.contains_key(publisher));
        for (publisher, (who, process)) in there {
            if self.is_heard(publisher) {
                self.mutes.remove(&publisher);
            } else {
                self.mutes.entry(publisher).or_insert(Mute { who, process, since_ns: now_ns });
            }
        }
    }

    fn is_heard(&self, publisher: u128) -> bool {
        self.cameras.values().any(|track| track.publisher() == publisher)
            || self.detectors.values().any(|track| track.publisher() == publisher)
            || self.clients.values().any(|track| track.publisher() == publisher)
    }

    /// How many are gone and still known.
    pub(super) fn gone(&self) -> usize {
        gone(&self.cameras) + gone(&self.detectors) + gone(&self.clients)
    }

    /// Forgets who is gone long enough.
    pub(super) fn forget(&mut self, now_ns: u64) {
        self.cameras.retain(|_, track| track.is_shown(now_ns));
        self.detectors.retain(|_, track| track.is_shown(now_ns));
        self.clients.retain(|_, track| track.is_shown(now_ns));
    }

    /// The clients of a detector, in the order in which they came.
    pub(super) fn clients_of(
        &self,
        detector: &DetectorKey,
    ) -> impl Iterator<Item = (&ClientKey, &Track<ClientStats>)> {
        self.clients.iter().filter(move |(key, _)| key.detector == *detector)
    }

    /// Every camera that was heard, or of which a detector was.
    pub(super) fn camera_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.cameras.keys().map(String::as_str).collect();
        names.extend(self.detectors.keys().map(|key| key.camera.as_str()));
        names.extend(self.clients.keys().map(|key| key.detector.camera.as_str()));
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Every detector of a camera that was heard, or of which a client was.
    pub(super) fn detector_keys(&self, camera: &str) -> Vec<&DetectorKey> {
        let mut keys: Vec<&DetectorKey> = self.detectors.keys().collect();
        keys.extend(self.clients.keys().map(|key| &key.detector));
        keys.retain(|key| key.camera == camera);
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// How a client is, beside its detector.
    pub(super) fn client_life(&self, key: &ClientKey, track: &Track<ClientStats>, now_ns: u64) -> ClientLife {
        if track.life() == Life::Gone {
            return ClientLife::Gone;
        }
        let Some(detector) = self.detectors.get(&key.detector) else { return ClientLife::Alive };
        let client = track.last();
        let is_anew = detector.last().epoch != client.detector_epoch;
        // Messages are numbered from 0.
        let taken = if is_anew { 0 } else { client.last_message + 1 };
        let Some(since_ns) = detector.first_written(|detector| detector.messages > taken) else {
            return ClientLife::Alive;
        };
        let behind = Duration::from_nanos(now_ns.saturating_sub(since_ns));
        if behind < BEHIND || took_nothing(track, now_ns) < STALE {
            return ClientLife::Alive;
        }
        let messages = detector.last().messages - taken;
        ClientLife::Stuck { behind: (!is_anew).then_some(messages), halted: track.life() == Life::Halted }
    }

    /// What is wrong, in words.
    pub(super) fn troubles(&self, now_ns: u64) -> Vec<String> {
        let cameras = self.cameras.iter().filter_map(|(name, track)| camera_trouble(name, track, now_ns));
        let detectors = self.detectors.iter().filter_map(|(key, track)| detector_trouble(key, track, now_ns));
        let clients = self.clients.iter().filter_map(|(key, track)| {
            client_trouble(&client_name(track), track, self.client_life(key, track, now_ns), now_ns)
        });
        let mutes = self.mutes.values().filter_map(|mute| mute_trouble(mute, now_ns));
        cameras.chain(detectors).chain(clients).chain(mutes).collect()
    }
}

fn has_rates<T: Counted>(track: &Track<T>) -> bool {
    track.life() != Life::Alive || track.window().is_some()
}

fn gone<K, T: Counted>(tracks: &BTreeMap<K, Track<T>>) -> usize {
    tracks.values().filter(|track| track.life() == Life::Gone).count()
}

/// How long a client took nothing: it says so itself while it waits, and not at all while it does something else.
fn took_nothing(track: &Track<ClientStats>, now_ns: u64) -> Duration {
    track.age(now_ns).max(track.resting(now_ns))
}

/// What a client calls itself, fit for a terminal.
pub(super) fn client_name(track: &Track<ClientStats>) -> String {
    track.last().name().chars().map(|letter| if letter.is_control() { '?' } else { letter }).collect()
}

/// The name of a camera's state.
pub(super) fn camera_state(camera: &CameraStats) -> CameraState {
    CameraState::from_code(camera.state)
}

/// The name of a detector's state.
pub(super) fn detector_state(detector: &DetectorStats) -> DetectorState {
    DetectorState::from_code(detector.state)
}

fn camera_trouble(name: &str, track: &Track<CameraStats>, now_ns: u64) -> Option<String> {
    let state = match camera_state(track.last()) {
        CameraState::Lost => "lost: the device has gone and is looked for",
        CameraState::Waiting => "waiting: the device is there but gives no frames",
        CameraState::Ended => "ended: its source has no more frames",
        CameraState::Unknown | CameraState::Starting | CameraState::Streaming => "",
    };
    let who = format!("camera {name} (process {})", track.last().process);
    if let Some(trouble) = silence(&who, track, now_ns) {
        return Some(trouble);
    }
    let rest = seconds(track.resting(now_ns));
    (!state.is_empty()).then(|| format!("{who}: {state}, no frame for {rest}"))
}

fn detector_trouble(key: &DetectorKey, track: &Track<DetectorStats>, now_ns: u64) -> Option<String> {
    let DetectorKey { camera, detector } = key;
    let who = format!("detector {detector} of {camera} (process {})", track.last().process);
    silence(&who, track, now_ns).or_else(|| match detector_state(track.last()) {
        DetectorState::WaitingForCamera => {
            Some(format!("{who}: waits for camera {camera}, which is not there"))
        }
        DetectorState::Silent => {
            Some(format!("{who}: gets no frames, none for {}", seconds(track.resting(now_ns))))
        }
        DetectorState::Unknown | DetectorState::Detecting | DetectorState::Paused => None,
    })
}

fn client_trouble(name: &str, track: &Track<ClientStats>, life: ClientLife, now_ns: u64) -> Option<String> {
    let who = format!("client {name} (process {})", track.last().process);
    let (behind, halted) = match life {
        ClientLife::Alive => return None,
        ClientLife::Gone => return silence(&who, track, now_ns),
        ClientLife::Stuck { behind, halted } => (behind, halted),
    };
    let behind = match behind {
        Some(behind) => format!("{} behind", units::of(behind, "message")),
        None => "nothing yet since its detector began".to_owned(),
    };
    let halted = if halted { ", it was halted by a signal" } else { "" };
    let rest = seconds(took_nothing(track, now_ns));
    Some(format!("{who}: stuck, took nothing for {rest}, {behind}{halted}"))
}

/// Whoever is dead already leaves places that are cleaned up when somebody comes who needs them.
fn mute_trouble(mute: &Mute, now_ns: u64) -> Option<String> {
    let silent = Duration::from_nanos(now_ns.saturating_sub(mute.since_ns));
    let process = Process::of(mute.process);
    if silent < STALE || process == Process::Gone {
        return None;
    }
    let Mute { who, process: number, .. } = mute;
    let halted = if process == Process::Halted { ", it was halted by a signal" } else { "" };
    Some(format!("{who} (process {number}): stuck, said nothing for {} or more{halted}", seconds(silent)))
}

/// What is wrong when a role does not speak.
fn silence<T: Counted>(who: &str, track: &Track<T>, now_ns: u64) -> Option<String> {
    let age = seconds(track.age(now_ns));
    match track.life() {
        Life::Alive => None,
        Life::Silent => Some(format!("{who}: stuck, said nothing for {age}")),
        Life::Halted => Some(format!("{who}: halted by a signal, said nothing for {age}")),
        Life::Gone => Some(format!("{who}: gone, heard last {age} ago")),
    }
}

fn seconds(duration: Duration) -> String {
    format!("{:.1} s", duration.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn key() -> DetectorKey {
        DetectorKey { camera: "cam0".to_owned(), detector: "main".to_owned() }
    }

    /// A detector of this start that spoke every half a second, sent 15 messages between, and has sent so many at this moment.
    fn detector(epoch: u64, last_ns: u64, sent: u64) -> Track<DetectorStats> {
        let copy = |ago: u64| DetectorStats {
            epoch,
            written_ns: last_ns - ago * SECOND / 2,
            messages: sent.saturating_sub(15 * ago),
            state: 2,
            ..DetectorStats::default()
        };
        let mut track = Track::new(1, copy(9));
        (0..9).rev().for_each(|ago| track.take(1, copy(ago)));
        track
    }

    /// Such a detector at 10 s, and a client that spoke for the last time then and has received so many.
    fn seen(sent: u64, client_ns: u64, received: u64) -> Seen {
        let mut seen = Seen::default();
        seen.detectors.insert(key(), detector(3, 10 * SECOND, sent));
        let mut client = ClientStats {
            epoch: 4,
            written_ns: client_ns,
            received,
            last_message: received.saturating_sub(1),
            detector_epoch: 3,
            ..ClientStats::default()
        };
        client.name[..5].copy_from_slice(b"wa\x1bch");
        seen.clients.insert(ClientKey::new(key(), &client), Track::new(2, client));
        seen
    }

    #[test]
    fn a_client_that_takes_nothing_of_what_was_sent_is_stuck() {
        let stuck = seen(396, 7 * SECOND, 300).troubles(10 * SECOND + SECOND / 5);
        let process = std::process::id();
        let wanted =
            format!("client wa?ch (process {process}): stuck, took nothing for 3.2 s, 96 messages behind");
        assert_eq!(stuck, [wanted]);
    }

    #[test]
    fn a_client_is_not_stuck_that_has_all_or_spoke_a_moment_ago_or_of_whom_the_first_message_is_new() {
        let has_all = seen(300, 7 * SECOND, 300);
        let spoke = seen(400, 9 * SECOND, 300);
        let new = seen(310, 2 * SECOND, 300);
        for (case, seen) in [has_all, spoke, new].iter().enumerate() {
            assert!(seen.troubles(10 * SECOND).is_empty(), "{case}: {:?}", seen.troubles(10 * SECOND));
        }
    }

    #[test]
    fn a_client_that_took_nothing_of_a_detector_that_began_anew_is_not_told_how_far_behind_it_is() {
        let mut seen = seen(0, 7 * SECOND, 300);
        seen.detectors.insert(key(), detector(9, 10 * SECOND, 150));
        let troubles = seen.troubles(10 * SECOND);
        assert!(
            troubles[0].ends_with("took nothing for 3.0 s, nothing yet since its detector began"),
            "{troubles:?}"
        );
    }

    #[test]
    fn whoever_publishes_and_was_never_heard_is_stuck_as_long_as_it_is_there() {
        let mut seen = seen(300, 10 * SECOND, 300);
        let there = |process| {
            let client = |number: u128| (number, (format!("client {number}"), process));
            BTreeMap::from([client(1), client(2), client(8)])
        };
        let process = std::process::id();
        seen.note_mutes(there(process), 8 * SECOND);
        seen.note_mutes(there(process), 10 * SECOND);
        let wanted = format!("client 8 (process {process}): stuck, said nothing for 2.0 s or more");
        assert_eq!(seen.troubles(10 * SECOND), [wanted]);
        assert!(seen.troubles(9 * SECOND).is_empty());
        seen.note_mutes(BTreeMap::new(), 10 * SECOND);
        assert!(!seen.has_mutes());
        seen.note_mutes(there(1 << 30), 10 * SECOND);
        assert!(seen.troubles(12 * SECOND).iter().all(|trouble| !trouble.contains("client 8")));
    }

    #[test]
    fn a_camera_says_what_its_state_means() {
        let mut seen = Seen::default();
        let camera = CameraStats { state: 4, written_ns: SECOND, ..CameraStats::default() };
        seen.cameras.insert("cam0".to_owned(), Track::new(1, camera));
        let troubles = seen.troubles(2 * SECOND);
        assert!(
            troubles[0].ends_with("lost: the device has gone and is looked for, no frame for 1.0 s"),
            "{troubles:?}"
        );
    }
}
