//! All published families loaded at once: how much memory, how soon ready, how long a look-up takes, and whether it finds
//! what comparing with every code finds.

mod agreement;
mod load;
mod lookup;
mod measure;
mod probe;
mod report;

pub(crate) use measure::{Plan, run};
pub(crate) use report::page;
