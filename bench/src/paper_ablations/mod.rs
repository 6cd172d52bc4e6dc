//! What each choice of the paper buys (its ablations): the paper's pipeline, plainly, with one step at a time done in the
//! way that the choice replaced.

mod cases;
mod measure;
mod table;

pub(crate) use measure::run;
pub(crate) use table::{COLUMNS, section};
