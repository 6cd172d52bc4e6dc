//! kill -9 of random roles of a whole machine, again and again.

mod arrivals;
mod kills;
mod machine;
mod moment;
mod plot;
mod process;
mod report;
mod storage;

pub(crate) use kills::{Plan, run};
pub(crate) use plot::figure;
pub(crate) use report::{HOW, csv, page};
