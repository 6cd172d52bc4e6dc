//! Every configuration of every detector on one data set: what it finds, how exactly, and in what time.

mod measure;
mod natural;
pub(crate) mod plot;
mod score;
mod significance;
mod table;

pub(crate) use measure::{Line, ORDER_SEED, Plan, Times, bar, measure, run};
pub(crate) use natural::{load_scaled, pictures_in, sweep as sweep_natural};
pub(crate) use plot::{figure_7, figure_8};
pub(crate) use score::{Score, score};
pub(crate) use significance::mcnemar;
pub(crate) use table::{csv, page};
