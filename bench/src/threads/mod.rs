//! How much sooner several threads are done with a frame.

mod contest;
mod cores;
mod frames;
mod measure;
mod report;

pub(crate) use measure::{Plan, run};
pub(crate) use report::page;
