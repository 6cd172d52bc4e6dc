//! Tables I and II of the paper: how often what is no tag is taken for one, by the metric that the family was made with.

mod material;
mod quads;
mod variants;

mod contenders;
mod families;
mod matches;

mod interval;
mod run;

mod plot;
mod report;
mod verdict;

pub(crate) use plot::figure;
pub(crate) use report::{csv, how, page};
pub(crate) use run::{Plan, run};
