//! The run: start, change each detector again and again, end.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::control::{DetectorChange, DetectorControl};

use crate::Failure;
use crate::crowd::{InForce, Machine, Part, Tally, Temper};

/// Camera and name of each detector.
const DETECTORS: [[&str; 2]; 3] = [["cam0", "main"], ["cam0", "near"], ["cam1", "main"]];
/// Ids below this and from this on take turns.
const MIDDLE_ID: u32 = 300;
const LAST_ID: u32 = 586;
/// The sequence of changes, three of which follow each other before hamming is the same again.
const CORRECTED: [u32; 3] = [0, 1, 2];

/// What runs how long.
pub(crate) struct Plan {
    pub(crate) program: PathBuf,
    pub(crate) seconds: u32,
    pub(crate) clients: usize,
    /// Frames a second of each camera.
    pub(crate) rate: u32,
}

/// One detector: what it was told under which number, and what its clients saw.
pub(crate) struct Told {
    pub(super) place: [String; 2],
    pub(super) changes: BTreeMap<u64, Expected>,
    pub(super) tallies: Vec<Tally>,
}

/// What messages of a change have to be like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Expected {
    pub(super) decimation: f64,
    pub(super) hamming: i64,
    pub(super) ids: [u64; 2],
}

impl Expected {
    /// Three parameters that change together.
    pub(super) fn of(round: usize) -> Self {
        let ids = if round.is_multiple_of(2) { [0, MIDDLE_ID - 1] } else { [MIDDLE_ID, LAST_ID] };
        Self {
            decimation: if round.is_multiple_of(2) { 1.0 } else { 2.0 },
            hamming: i64::from(CORRECTED[round % CORRECTED.len()]),
            ids: ids.map(u64::from),
        }
    }

    fn change(self) -> DetectorChange {
        let [first, last] = self.ids.map(|id| id as u32);
        DetectorChange {
            decimation: Some(self.decimation as f32),
            hamming: Some(Some(self.hamming as u32)),
            ids: Some(vec![(first, last)]),
            ..DetectorChange::default()
        }
    }

    /// Whether messages were like this.
    pub(super) fn is_met_by(self, seen: &InForce) -> bool {
        let ids = seen.ids.is_none_or(|[least, most]| self.ids[0] <= least && most <= self.ids[1]);
        ids && (self.decimation, self.hamming) == (seen.decimation, seen.hamming)
    }
}

/// Starts everything, changes every detector once a second, ends everything. An error is a change that is refused, a client that
/// cannot connect, and whatever ends before, ends badly or leaves something.
pub(crate) fn run(plan: &Plan) -> Result<Vec<Told>, Failure> {
    let mut machine = start(plan)?;
    let mut asking = Vec::new();
    for [camera, name] in DETECTORS {
        asking.push(DetectorControl::connect(&machine.reach(camera, name))?);
    }
    let mut told: Vec<Told> = DETECTORS.map(Told::new).into();
    let begun = Instant::now();
    for round in 0..plan.seconds as usize {
        thread::sleep(Duration::from_secs(round as u64 + 1).saturating_sub(begun.elapsed()));
        machine.check()?;
        for (detector, told) in asking.iter_mut().zip(&mut told) {
            let expected = Expected::of(round);
            told.changes.insert(detector.set(&expected.change())?.control_number, expected);
        }
    }
    thread::sleep(Duration::from_secs(1));
    drop(asking);
    for (part, place, tally) in machine.end()? {
        let detector = told.iter_mut().find(|told| told.place == place);
        detector
            .filter(|_| matches!(part, Part::Client(_)))
            .into_iter()
            .for_each(|told| told.tallies.push(tally.clone()));
    }
    Ok(told)
}

impl Told {
    fn new(place: [&str; 2]) -> Self {
        Self { place: place.map(str::to_owned), changes: BTreeMap::new(), tallies: Vec::new() }
    }
}

fn start(plan: &Plan) -> Result<Machine, Failure> {
    let mut machine = Machine::new(&plan.program)?;
    let rate = format!("--framerate={}", plan.rate);
    machine.camera("cam0", &["--source=scene:1".to_owned(), rate.clone()])?;
    machine.camera("cam1", &["--source=scene:2".to_owned(), rate])?;
    for [camera, name] in DETECTORS {
        machine.detector(camera, name, &[])?;
    }
    for client in 0..plan.clients {
        let [camera, name] = DETECTORS[client % DETECTORS.len()];
        machine.client(camera, name, Temper::Honest)?;
    }
    Ok(machine)
}
