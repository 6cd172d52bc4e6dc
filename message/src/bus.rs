//! How every role comes onto the bus and leaves it.
//!
//! [`Bus::start`] makes the role's node; [`crate::ports`] opens or makes topics with it. Both go through one loop that
//! waits for what is coming, mends what the dead left half made, makes the dead give back their places, and says clearly
//! what waiting does not mend. When the last clone of a [`Bus`] is dropped the node goes, and the domain's last role
//! removes everything.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::{CallbackProgression, Node, NodeBuilder, NodeName, Service, SignalHandlingMode};

use crate::domain::{Domain, DomainError};
use crate::gate::{Company, Pass};
use crate::other_version;
use crate::qos::QosError;
use crate::room::{self, MORE_ROOM, SHARED_MEMORY, TO_JOIN};
use crate::stop::Stop;
use crate::sweep;
use crate::verdict::{Judge, Verdict};

/// Pause between two tries; a topic that is not there is asked for less and less often.
const PAUSE: Duration = Duration::from_millis(10);
const LONGEST_PAUSE: Duration = Duration::from_millis(100);
/// How long something may be broken or half made: longer than any healing takes.
const STUCK_AFTER: Duration = Duration::from_secs(10);
/// How long whoever removes a topic may take for it. After that he is taken for dead: he was killed between saying so and doing so, and
/// nobody would ever finish it.
const REMOVED_AFTER: Duration = Duration::from_millis(200);
/// How long places may be taken after the dead were cleaned up: a process that is killed takes a while to die.
const CROWDED_AFTER: Duration = Duration::from_secs(1);
/// How long a topic with other settings may stay: the last who use it may be leaving.
const DIFFERENT_AFTER: Duration = Duration::from_millis(500);

/// A role's place on the bus. Cheap to clone; the node lives as long as the last clone.
///
/// Samples and loans in hand keep the node too: drop them before the last clone, or cleaning up is left to the next role.
#[derive(Debug)]
pub struct Bus<S: Service> {
    place: Arc<Place<S>>,
}

#[derive(Debug)]
struct Place<S: Service> {
    /// Only `None` while this is dropped.
    node: Option<Node<S>>,
    domain: Domain,
    stop: Stop,
}

/// How long to wait for a topic that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// Until it comes or the role is stopped.
    Endless,
    /// So long, for everything that has to be there.
    AtMost(Duration),
    /// Not at all, for a topic that is not there. What others are half way through, or left broken, is waited for and mended.
    IfThere,
}

/// Who made or makes a topic: what a role does about one that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Makes what is not there.
    Producer,
    /// Waits for it.
    Consumer,
}

impl<S: Service> Clone for Bus<S> {
    fn clone(&self) -> Self {
        Self { place: Arc::clone(&self.place) }
    }
}

impl<S: Service> Bus<S> {
    /// Comes onto the bus: makes the domain's root and a node named after the role, such as "camera cam0".
    ///
    /// What the dead left is removed first. Errors name both users when the domain is another's.
    pub fn start(domain: &Domain, role: &str, stop: &Stop) -> Result<Self, BusError> {
        let config = domain.config()?;
        let name = NodeName::new(role).unwrap_or_default();
        let mut tries = Tries::new(role, Patience::Endless, stop);
        room::check().map_err(|free| BusError::NoRoom { free })?;
        loop {
            // Alone, so that a role that ends sees either no node of ours or a whole one.
            let mut pass = domain.enter(Company::Alone)?;
            domain.prepare(&mut pass)?;
            if !sweep::has_living_nodes(domain) {
                sweep::remove_leftovers(domain);
            }
            // Before the node, which cleans up the dead when it is made.
            sweep::bury(domain);
            let node = NodeBuilder::new()
                .name(&name)
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<S>();
            drop(pass);
            match node {
                Ok(node) => {
                    let place = Place { node: Some(node), domain: domain.clone(), stop: stop.clone() };
                    return Ok(Self { place: Arc::new(place) });
                }
                Err(error) => drop(tries.failed(&error)?),
            }
        }
    }

    /// The role's node.
    #[must_use]
    pub fn node(&self) -> &Node<S> {
        self.place.node.as_ref().expect("the node is taken only when the place is dropped")
    }

    /// The domain that the role is in.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.place.domain
    }

    /// What ends the role.
    #[must_use]
    pub fn stop(&self) -> &Stop {
        &self.place.stop
    }

    /// Gives back what dead roles held, and says how many there were. To be called when a deadline was missed:
    /// nobody looks for the dead by himself.
    pub fn clean_up_dead(&self) -> u64 {
        self.node().try_cleanup_dead_nodes().cleanups
    }

    /// Tries until it works or waiting does not help any more.
    pub(crate) fn persist<T, E: Judge>(
        &self,
        topic: &str,
        part: Part,
        patience: Patience,
        mut attempt: impl FnMut() -> Result<T, E>,
    ) -> Result<T, BusError> {
        let mut tries = Tries::new(topic, patience, &self.place.stop);
        let mut is_mended = false;
        loop {
            room::check().map_err(|free| BusError::NoRoom { free })?;
            // Whoever makes something is seen by those who heal; whoever only waits must not keep them off.
            let pass = match part {
                Part::Producer => Some(self.place.domain.enter(Company::Shared)?),
                Part::Consumer => None,
            };
            let outcome = attempt();
            drop(pass);
            let error = match outcome {
                Ok(made) => return Ok(made),
                Err(error) => error,
            };
            let lasted = match tries.failed(&error) {
                Ok(lasted) => lasted,
                // iceoryx2 may wait as long for what is half made as there is patience: who makes a topic mends it once all the same.
                Err(BusError::Stuck { .. })
                    if part == Part::Producer && error.verdict() == Verdict::Heal && !is_mended =>
                {
                    is_mended = true;
                    Duration::ZERO
                }
                Err(error) => return Err(self.look_for_other_version(error, patience)),
            };
            match error.verdict() {
                Verdict::Heal => self.heal()?,
                Verdict::Leaving if lasted >= REMOVED_AFTER => self.heal()?,
                Verdict::Crowded | Verdict::Different => drop(self.bury()?),
                Verdict::Leaving | Verdict::Absent | Verdict::Again | Verdict::Hopeless => {}
            }
        }
    }

    /// A topic that did not come in time may be there in another version.
    fn look_for_other_version(&self, error: BusError, patience: Patience) -> BusError {
        match (error, patience) {
            (BusError::Absent { topic, waited }, Patience::AtMost(_)) => {
                match other_version::instead_of(self.domain(), &topic) {
                    Some(there) => BusError::OtherVersion { topic, there },
                    None => BusError::Absent { topic, waited },
                }
            }
            (error, _) => error,
        }
    }

    fn heal(&self) -> Result<(), BusError> {
        let _alone = self.bury()?;
        sweep::heal(&self.place.domain);
        Ok(())
    }

    /// Gives back what the dead held. One node that somebody left half made keeps iceoryx2 from cleaning up any other.
    fn bury(&self) -> Result<Pass, BusError> {
        self.clean_up_dead();
        let alone = self.place.domain.enter(Company::Alone)?;
        sweep::bury(&self.place.domain);
        Ok(alone)
    }

    /// Whether one of a topic's places is taken by nobody. Who is killed while he cleans up another can leave a place that has no
    /// mark any more by which the next one would find it; it stays taken for as long as the topic lives. `holders` are the nodes
    /// that the topic names, of those that have one of its `places`.
    pub(crate) fn is_haunted(&self, holders: impl Fn() -> Vec<UniqueNodeId>, places: usize) -> bool {
        let is_so = || {
            let (mut known, holders) = (Vec::new(), holders());
            let listed = Node::<S>::list(self.node().config(), |node| {
                known.push(*node.node_id());
                CallbackProgression::Continue
            });
            let is_unknown = |holder| !known.contains(holder);
            listed.is_ok() && (holders.len() < places || holders.iter().any(is_unknown))
        };
        // Who just comes or goes is not taken for a ghost.
        is_so() && !self.stop().wait(2 * PAUSE) && is_so()
    }

    /// Makes others forget a topic that is of no use any more: the next one who makes it makes a new one. Those who are connected to
    /// the old one find out when nothing comes from it.
    pub(crate) fn forget(&self, description: &Path) -> Result<(), BusError> {
        let _alone = self.place.domain.enter(Company::Alone)?;
        // That it is gone already is what is wanted.
        let _ = std::fs::remove_file(description);
        Ok(())
    }
}

impl<S: Service> Drop for Place<S> {
    fn drop(&mut self) {
        // The node first: its going makes this role count as gone.
        self.node = None;
        if let Ok(pass) = self.domain.enter(Company::Alone) {
            sweep::end_if_last(&self.domain, pass);
        }
    }
}

/// Counts the time of failed tries and decides when to give up.
struct Tries<'a> {
    topic: &'a str,
    patience: Patience,
    stop: &'a Stop,
    started: Instant,
    pause: Duration,
    lost: Lost,
}

impl<'a> Tries<'a> {
    fn new(topic: &'a str, patience: Patience, stop: &'a Stop) -> Self {
        Self { topic, patience, stop, started: Instant::now(), pause: PAUSE, lost: Lost::default() }
    }

    /// Sleeps before the next try, or says why there must not be one. Gives the time that was lost to this kind of error.
    fn failed<E: Judge>(&mut self, error: &E) -> Result<Duration, BusError> {
        let verdict = error.verdict();
        self.lost.note(verdict, Instant::now());
        if self.is_over(verdict) {
            return Err(self.give_up(verdict, error));
        }
        if self.stop.wait(self.pause) {
            return Err(BusError::Stopped);
        }
        self.pause = match verdict {
            Verdict::Absent => (self.pause * 2).min(LONGEST_PAUSE),
            _ => PAUSE,
        };
        Ok(self.lost.to(verdict))
    }

    fn is_over(&self, verdict: Verdict) -> bool {
        let out_of_patience = match self.patience {
            Patience::Endless => false,
            Patience::AtMost(limit) => self.started.elapsed() >= limit,
            Patience::IfThere => verdict == Verdict::Absent,
        };
        out_of_patience || self.lost.too_much_to(verdict)
    }

    fn give_up<E: Judge>(&self, verdict: Verdict, error: &E) -> BusError {
        let (topic, reason) = (self.topic.to_owned(), format!("{error:?}"));
        match verdict {
            Verdict::Absent => BusError::Absent { topic, waited: self.started.elapsed() },
            Verdict::Crowded => BusError::Crowded { topic, reason },
            Verdict::Different => BusError::Different { topic, reason, both: String::new() },
            Verdict::Again | Verdict::Leaving | Verdict::Heal | Verdict::Hopeless => {
                BusError::Stuck { topic, reason, waited: self.started.elapsed() }
            }
        }
    }
}

/// The time that was lost to each kind of error. Kinds may take turns: none of them begins the time of another anew, or a role could
/// try for ever. Only where nothing is there at all nothing is broken either.
#[derive(Debug, Default)]
struct Lost {
    /// Half made or coming and going.
    broken: Duration,
    /// Being removed.
    leaving: Duration,
    crowded: Duration,
    different: Duration,
    last: Option<(Verdict, Instant)>,
}

impl Lost {
    /// Takes note of a failed try. The time from one to the next is lost to the first.
    fn note(&mut self, verdict: Verdict, now: Instant) {
        if let Some((last, since)) = self.last.replace((verdict, now)) {
            let lost = now.saturating_duration_since(since);
            match last {
                Verdict::Again | Verdict::Heal => self.broken += lost,
                Verdict::Leaving => self.leaving += lost,
                Verdict::Crowded => self.crowded += lost,
                Verdict::Different => self.different += lost,
                Verdict::Absent | Verdict::Hopeless => {}
            }
        }
        if verdict == Verdict::Absent {
            *self = Self { last: self.last, ..Self::default() };
        }
    }

    fn to(&self, verdict: Verdict) -> Duration {
        match verdict {
            Verdict::Again | Verdict::Heal => self.broken,
            Verdict::Leaving => self.leaving,
            Verdict::Crowded => self.crowded,
            Verdict::Different => self.different,
            Verdict::Absent | Verdict::Hopeless => Duration::ZERO,
        }
    }

    fn too_much_to(&self, verdict: Verdict) -> bool {
        match verdict {
            Verdict::Absent => false,
            Verdict::Again | Verdict::Leaving | Verdict::Heal => self.broken + self.leaving >= STUCK_AFTER,
            Verdict::Crowded => self.crowded >= CROWDED_AFTER,
            Verdict::Different => self.different >= DIFFERENT_AFTER,
            Verdict::Hopeless => true,
        }
    }
}

/// Why a role could not come onto the bus.
#[derive(Debug)]
#[non_exhaustive]
pub enum BusError {
    /// The domain or a name in it cannot be used.
    Domain(DomainError),
    /// A quality of service that is not possible.
    Qos(QosError),
    /// Shared memory is full.
    NoRoom {
        /// Bytes that are free.
        free: u64,
    },
    /// The role was asked to stop while it started.
    Stopped,
    /// A topic did not come in time.
    Absent {
        /// The topic.
        topic: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// A topic did not come in time, but one of another version is there.
    OtherVersion {
        /// The topic that this program knows.
        topic: String,
        /// What is there instead.
        there: String,
    },
    /// Another role of this name runs.
    Taken {
        /// "camera" or "detector".
        role: &'static str,
        /// The name of both.
        name: String,
        /// The domain of both.
        domain: String,
    },
    /// All places of a topic are taken by living processes.
    Crowded {
        /// The topic.
        topic: String,
        /// iceoryx2's word for what there is too much of.
        reason: String,
    },
    /// A topic runs with other settings than this program needs.
    Different {
        /// The topic.
        topic: String,
        /// iceoryx2's word for what differs.
        reason: String,
        /// Both sides and who holds the topic.
        both: String,
    },
    /// Something is broken and stays so.
    Stuck {
        /// The topic or role.
        topic: String,
        /// iceoryx2's word for it.
        reason: String,
        /// How long it was tried.
        waited: Duration,
    },
}

impl From<DomainError> for BusError {
    fn from(error: DomainError) -> Self {
        Self::Domain(error)
    }
}

impl From<QosError> for BusError {
    fn from(error: QosError) -> Self {
        Self::Qos(error)
    }
}

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Domain(error) => error.fmt(f),
            Self::Qos(error) => error.fmt(f),
            Self::Stopped => write!(f, "stopped while starting"),
            Self::NoRoom { free } => {
                write!(
                    f,
                    "{SHARED_MEMORY} has {free} bytes free, and joining takes up to {TO_JOIN}: {MORE_ROOM}"
                )
            }
            Self::Absent { topic, waited } => write!(
                f,
                "{topic} did not appear within {:.1} s: start its publisher, in the same --domain and under the same user",
                waited.as_secs_f64()
            ),
            Self::OtherVersion { topic, there } => write!(
                f,
                "{topic} is not there, but {there}: the versions do not understand each other, use programs of one version of tagbus"
            ),
            Self::Taken { role, name, domain } => write!(
                f,
                "a {role} named {name} is already running in domain {domain} (choose another --{role} name or stop it)"
            ),
            Self::Crowded { topic, reason } => write!(
                f,
                "all places of {topic} are taken by running processes ({reason}): stop one that is not needed"
            ),
            Self::Different { topic, reason, both } => write!(
                f,
                "{topic} runs with other settings ({reason}){both}: stop those processes, or use another --domain"
            ),
            Self::Stuck { topic, reason, waited } => write!(
                f,
                "{topic} cannot be opened ({reason}, tried for {:.1} s): were its files removed (logind does that at logout, see RemoveIPC=)? end all roles of the domain and start them again",
                waited.as_secs_f64()
            ),
        }
    }
}

impl std::error::Error for BusError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Domain(error) => Some(error),
            Self::Qos(error) => Some(error),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How long tries that fail every 100 ms in these ways, one after another and again, go on; `None` for a minute and longer.
    fn given_up_after(verdicts: &[Verdict]) -> Option<Duration> {
        let (begin, step) = (Instant::now(), Duration::from_millis(100));
        let mut lost = Lost::default();
        (0..600).map(|number| step * number).zip(verdicts.iter().cycle()).find_map(|(after, &verdict)| {
            lost.note(verdict, begin + after);
            lost.too_much_to(verdict).then_some(after)
        })
    }

    #[test]
    fn errors_that_take_turns_come_to_an_end_as_one_error_does() {
        use Verdict::{Absent, Again, Crowded, Different, Heal, Hopeless, Leaving};
        for verdicts in [&[Again][..], &[Heal], &[Heal, Again], &[Again, Leaving, Heal]] {
            assert_eq!(given_up_after(verdicts), Some(STUCK_AFTER), "{verdicts:?}");
        }
        assert_eq!(given_up_after(&[Crowded]), Some(CROWDED_AFTER));
        assert_eq!(given_up_after(&[Crowded, Again]), Some(2 * CROWDED_AFTER));
        assert_eq!(given_up_after(&[Different]), Some(DIFFERENT_AFTER));
        assert_eq!(given_up_after(&[Hopeless]), Some(Duration::ZERO));
        assert_eq!(given_up_after(&[Absent]), None);
        assert_eq!(given_up_after(&[Absent, Again]), None);
    }
}
