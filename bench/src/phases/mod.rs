//! Where the time goes: each phase on the same frames, at every level of instructions, and what the C library takes.

mod frames;
mod goals;
mod measure;
mod report;

pub(crate) use measure::{Plan, run};
pub(crate) use report::page;
