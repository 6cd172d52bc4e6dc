//! Who looks at what the roles of a domain count, without being one that any of them knows.

use std::collections::BTreeSet;
use std::time::Duration;

use iceoryx2::prelude::ipc;

use crate::bus::{Bus, BusError, Patience};
use crate::domain::Domain;
use crate::other_version::name_in;
use crate::stats::{CameraStats, ClientStats, DetectorStats};
use crate::stats_ports::StatsIn;
use crate::stop::Stop;
use crate::{sweep, topics};

/// Copies of what a role counts, as they come.
pub type Copies<T> = StatsIn<ipc::Service, T>;

/// A role that counts: its camera's name, and its own where it is a detector.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Recorded {
    /// The camera.
    pub camera: String,
    /// The detector; `None` for the camera itself.
    pub detector: Option<String>,
}

/// A place on the bus from which everything that is counted can be seen.
#[derive(Debug)]
pub struct Onlooker {
    bus: Bus<ipc::Service>,
}

impl Onlooker {
    /// Comes onto the bus. That nobody else is there is no error.
    pub fn start(domain: &Domain, stop: &Stop) -> Result<Self, BusError> {
        Ok(Self { bus: Bus::start(domain, "onlooker", stop)? })
    }

    /// The roles that have a topic of the recorder, in order. A role that was killed stays among them until somebody cleans up.
    #[must_use]
    pub fn recorded(&self) -> BTreeSet<Recorded> {
        let names = sweep::descriptions(self.bus.domain()).into_iter().filter_map(|text| name_in(&text));
        let role = |name: String| {
            let (camera, detector) = topics::recorded(&name)?;
            Some(Recorded { camera: camera.to_owned(), detector: detector.map(str::to_owned) })
        };
        names.filter_map(role).collect()
    }

    /// What a camera counts. Not waited for.
    pub fn camera(&self, camera: &str) -> Result<Copies<CameraStats>, BusError> {
        self.bus.open_camera_stats(camera, NO_PATIENCE)
    }

    /// What a detector counts. Not waited for.
    pub fn detector(&self, camera: &str, detector: &str) -> Result<Copies<DetectorStats>, BusError> {
        self.bus.open_detector_stats(camera, detector, NO_PATIENCE)
    }

    /// What the clients of a detector count. Not waited for.
    pub fn clients(&self, camera: &str, detector: &str) -> Result<Copies<ClientStats>, BusError> {
        self.bus.open_client_stats(camera, detector, NO_PATIENCE)
    }

    /// Gives back what dead roles held.
    pub fn clean_up_dead(&self) {
        let _ = self.bus.clean_up_dead();
    }
}

/// Who looks comes again soon, and must not stand still because one of many is half made.
const NO_PATIENCE: Patience = Patience::AtMost(Duration::ZERO);

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn those_who_count_are_found_their_copies_come_and_their_end_is_seen() {
        let folder = std::env::temp_dir().join(format!("tbo{}", std::process::id()));
        let domain = Domain::with_root(folder.file_name().unwrap().to_str().unwrap(), &folder).unwrap();
        let stop = Stop::new().unwrap();
        let onlooker = Onlooker::start(&domain, &stop).unwrap();
        assert!(onlooker.recorded().is_empty());
        let role = Bus::<ipc::Service>::start(&domain, "role", &stop).unwrap();
        let mut out = role.camera_stats("cam0").unwrap();
        let mut detector = role.detector_stats("cam0", "main").unwrap();
        assert!(onlooker.recorded().is_empty(), "topics are made with the first copy");
        out.publish(&CameraStats::default()).unwrap();
        detector.publish(&DetectorStats::default()).unwrap();
        let found: Vec<_> =
            onlooker.recorded().into_iter().map(|role| (role.camera, role.detector)).collect();
        assert_eq!(found, [("cam0".to_owned(), None), ("cam0".to_owned(), Some("main".to_owned()))]);
        let copies = onlooker.camera("cam0").unwrap();
        out.publish(&CameraStats { frames: 7, ..CameraStats::default() }).unwrap();
        let mut last = None;
        while let Some(copy) = copies.next_with_publisher().unwrap() {
            last = Some(copy);
        }
        let (publisher, copy) = last.unwrap();
        assert_eq!(copy.frames, 7);
        assert_eq!(copies.publishers(), BTreeMap::from([(publisher, std::process::id())]));
        drop(out);
        assert!(copies.publishers().is_empty());
        drop((detector, copies, role, onlooker));
        assert!(!folder.exists());
    }
}
