//! What clients cost on a detector's critical path: CPU time from a frame's arrival until its message is sent.

mod report;
mod run;

pub(crate) use report::page;
pub(crate) use run::{Plan, run};
