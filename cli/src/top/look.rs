//! Looking: who counts on the bus, and what their last copies say.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::{Duration, Instant};

use tagbus_message::bus::BusError;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::domain::Domain;
use tagbus_message::onlooker::{Copies, Onlooker, Recorded};
use tagbus_message::stats::{CameraStats, ClientStats, DetectorStats, Stats};
use tagbus_message::stop::Stop;

use super::seen::{ClientKey, DetectorKey, Seen};
use super::track::{Counted, Track};

/// How often the list of topics is read.
const LISTED: Duration = Duration::from_secs(1);
/// A topic on which nothing comes for so long is opened anew: it may be another one of the same name by now.
const REOPENED: Duration = Duration::from_secs(3);
/// Rates need two copies of each role, and copies come twice a second.
const SETTLED: Duration = Duration::from_millis(700);
const SETTLED_AT_LAST: Duration = Duration::from_millis(1700);
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Somebody who looks again and again.
pub(super) struct Look {
    onlooker: Onlooker,
    listed: Option<Instant>,
    cameras: BTreeMap<String, Source<CameraStats>>,
    detectors: BTreeMap<DetectorKey, Source<DetectorStats>>,
    clients: BTreeMap<DetectorKey, Source<ClientStats>>,
    seen: Seen,
}

/// A topic that copies come on.
struct Source<T: Stats> {
    copies: Copies<T>,
    publishers: BTreeMap<u128, u32>,
    heard: Instant,
}

impl<T: Stats> Source<T> {
    fn new(copies: Copies<T>) -> Self {
        Self { publishers: copies.publishers(), copies, heard: Instant::now() }
    }

    /// The copies that have come, each with the number of its publisher.
    fn read(&mut self) -> Vec<(u128, T)> {
        let mut read = Vec::new();
        while let Ok(Some(copy)) = self.copies.next_with_publisher() {
            read.push(copy);
        }
        if !read.is_empty() {
            self.heard = Instant::now();
        }
        // After the copies: of whoever left before, nothing comes any more.
        self.publishers = self.copies.publishers();
        read
    }

    fn is_heard(&self) -> bool {
        self.heard.elapsed() < REOPENED
    }
}

impl Look {
    /// Comes onto the bus.
    pub(super) fn start(domain: &Domain, stop: &Stop) -> Result<Self, BusError> {
        Ok(Self {
            onlooker: Onlooker::start(domain, stop)?,
            listed: None,
            cameras: BTreeMap::new(),
            detectors: BTreeMap::new(),
            clients: BTreeMap::new(),
            seen: Seen::default(),
        })
    }

    /// Looks, and says what is known now.
    pub(super) fn again(&mut self) -> &Seen {
        if self.listed.is_none_or(|listed| listed.elapsed() >= LISTED) {
            self.list();
            self.listed = Some(Instant::now());
        }
        self.read();
        self.judge();
        &self.seen
    }

    /// Looks until there are rates, where there is something to look at.
    pub(super) fn settled(&mut self, stop: &Stop) -> &Seen {
        let started = Instant::now();
        self.again();
        while !self.cameras.is_empty() || !self.detectors.is_empty() {
            let looked = started.elapsed();
            let is_settled = looked >= SETTLED && self.seen.has_rates() && !self.seen.has_mutes();
            if is_settled || looked >= SETTLED_AT_LAST || stop.wait(BETWEEN_LOOKS) {
                break;
            }
            self.again();
        }
        &self.seen
    }
}

impl Look {
    /// Opens what is new. What cannot be opened now is tried the next time: it may be half made, or about to go.
    fn list(&mut self) {
        self.cameras.retain(|_, source| source.is_heard());
        self.detectors.retain(|_, source| source.is_heard());
        self.clients.retain(|_, source| source.is_heard());
        for Recorded { camera, detector } in self.onlooker.recorded() {
            match detector {
                None => self.open_camera(camera),
                Some(detector) => self.open_detector(DetectorKey { camera, detector }),
            }
        }
    }

    fn open_camera(&mut self, camera: String) {
        if let Entry::Vacant(place) = self.cameras.entry(camera)
            && let Ok(copies) = self.onlooker.camera(place.key())
        {
            place.insert(Source::new(copies));
        }
    }

    fn open_detector(&mut self, key: DetectorKey) {
        if let Entry::Vacant(place) = self.clients.entry(key.clone())
            && let Ok(copies) = self.onlooker.clients(&key.camera, &key.detector)
        {
            place.insert(Source::new(copies));
        }
        if let Entry::Vacant(place) = self.detectors.entry(key)
            && let Ok(copies) = self.onlooker.detector(&place.key().camera, &place.key().detector)
        {
            place.insert(Source::new(copies));
        }
    }

    fn read(&mut self) {
        for (camera, source) in &mut self.cameras {
            for (publisher, copy) in source.read() {
                take(&mut self.seen.cameras, camera.clone(), publisher, copy);
            }
        }
        for (detector, source) in &mut self.detectors {
            for (publisher, copy) in source.read() {
                take(&mut self.seen.detectors, detector.clone(), publisher, copy);
            }
        }
        for (detector, source) in &mut self.clients {
            for (publisher, copy) in source.read() {
                let key = ClientKey::new(detector.clone(), &copy);
                take(&mut self.seen.clients, key, publisher, copy);
            }
        }
    }

    /// Who publishes and was never heard: one who is stuck since before this began to look.
    fn note_mutes(&mut self, now_ns: u64) {
        let mut there = BTreeMap::new();
        for (camera, source) in &self.cameras {
            let who = format!("camera {camera}");
            there.extend(source.publishers.iter().map(|(id, process)| (*id, (who.clone(), *process))));
        }
        for (DetectorKey { camera, detector }, source) in &self.detectors {
            let who = format!("detector {detector} of {camera}");
            there.extend(source.publishers.iter().map(|(id, process)| (*id, (who.clone(), *process))));
        }
        for (DetectorKey { camera, detector }, source) in &self.clients {
            let who = format!("client of {detector} of {camera}");
            there.extend(source.publishers.iter().map(|(id, process)| (*id, (who.clone(), *process))));
        }
        self.seen.note_mutes(there, now_ns);
    }

    fn judge(&mut self) {
        let now_ns = monotonic_ns();
        self.note_mutes(now_ns);
        let gone_before = self.seen.gone();
        for (camera, track) in &mut self.seen.cameras {
            track.judge(self.cameras.get(camera).map(|source| &source.publishers), now_ns);
        }
        for (detector, track) in &mut self.seen.detectors {
            track.judge(self.detectors.get(detector).map(|source| &source.publishers), now_ns);
        }
        for (client, track) in &mut self.seen.clients {
            track.judge(self.clients.get(&client.detector).map(|source| &source.publishers), now_ns);
        }
        if self.seen.gone() > gone_before {
            self.onlooker.clean_up_dead();
        }
        self.seen.forget(now_ns);
    }
}

fn take<K: Ord, T: Counted>(tracks: &mut BTreeMap<K, Track<T>>, key: K, publisher: u128, copy: T) {
    match tracks.entry(key) {
        Entry::Occupied(mut track) => track.get_mut().take(publisher, copy),
        Entry::Vacant(place) => {
            place.insert(Track::new(publisher, copy));
        }
    }
}
