//! Every configuration of every detector on one data set: what it finds, how exactly, and in what time.

mod measure;
mod natural;
mod plot;
mod score;
mod significance;
mod table;

pub(crate) use measure::{Line, Plan, run};
pub(crate) use natural::sweep as sweep_natural;
pub(crate) use plot::{figure_7, figure_8};
pub(crate) use table::{csv, page};
