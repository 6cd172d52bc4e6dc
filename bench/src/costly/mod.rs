//! Frames made to cost: noise, checkerboards and stripes beside natural pictures.

mod frames;
mod measure;
mod report;

pub(crate) use measure::{Plan, run};
pub(crate) use report::page;
