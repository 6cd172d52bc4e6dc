//! Several cameras, detectors and many clients on one domain while parameters change all the time.

mod report;
mod run;
mod verdict;

pub(crate) use report::{HOW, page};
pub(crate) use run::{Plan, run};
pub(crate) use verdict::faults;
