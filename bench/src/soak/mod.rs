//! A camera, a detector and many clients for a long time: does anything grow, is anything lost?

mod plot;
mod report;
mod run;
mod usage;
mod verdict;

pub(crate) use plot::figure;
pub(crate) use report::{HOW, csv, page};
pub(crate) use run::{Plan, run};
pub(crate) use usage::Stored;
pub(crate) use verdict::faults;
