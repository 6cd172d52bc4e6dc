//! The doubly nested tag of the paper's Figure 1: from how near to how far it is found, and which of its tags.

mod landing;
mod measure;
mod plot;
mod report;

pub(crate) use measure::{Plan, run};
pub(crate) use plot::figure;
pub(crate) use report::{csv, page, verdict};
