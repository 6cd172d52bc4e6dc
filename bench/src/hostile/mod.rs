//! Attackers on the bus of an honest camera, detector and clients: what they break, and what they cost.

mod attack;
mod lies;
mod listener;
mod report;
mod run;
mod verdict;

pub(crate) use attack::{Attack, AttackOrder, attack};
pub(crate) use report::{HOW, csv, page};
pub(crate) use run::{Plan, run};
pub(crate) use verdict::faults;
