//! One family after the other.

use tagbus_family::{Family, Index, UnknownFamily};

use super::agreement::{self, Agreement};
use super::load::{self, Load};
use super::lookup::{self, LookupNs};
use crate::sweep::bar;

/// How much is measured.
pub(crate) struct Plan {
    /// Wrong bits to be corrected, where a family's distance allows it.
    pub(crate) hamming: u32,
    /// How often everything is loaded, and each list of codes looked up.
    pub(crate) rounds: usize,
    /// Codes of each family for which look-up is compared with every code.
    pub(crate) probes: u64,
    /// Another seed gives other codes.
    pub(crate) seed: u64,
}

/// What was measured.
pub(crate) struct Outcome {
    pub(super) load: Load,
    /// A random code in all families one after the other.
    pub(super) in_all: LookupNs,
    pub(super) lines: Vec<Line>,
}

impl Outcome {
    /// Probes of which look-up says something else than comparing with every code.
    pub(crate) fn disagreements(&self) -> u64 {
        self.lines.iter().map(|line| line.agreement.probes - line.agreement.same).sum()
    }
}

/// One family.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) codes: usize,
    /// Wrong bits that are corrected.
    pub(super) hamming: u32,
    /// Size of its index, by the index's own count.
    pub(super) bytes: usize,
    pub(super) random: LookupNs,
    pub(super) tags: LookupNs,
    pub(super) agreement: Agreement,
}

/// Loads all families and looks up codes in each.
pub(crate) fn run(plan: &Plan) -> Result<Outcome, UnknownFamily> {
    let (load, loaded) = load::measure(plan.hamming, plan.rounds)?;
    let bar = bar(plan.probes as usize * loaded.len(), "index");
    let line = |(number, one): (u64, &(Family, Index))| {
        let (family, index) = one;
        bar.set_message(family.name().to_owned());
        Line {
            name: family.name().to_owned(),
            codes: family.codes().len(),
            hamming: index.hamming(),
            bytes: index.size_bytes(),
            random: lookup::of_random_codes(family, index, plan.rounds, plan.seed),
            tags: lookup::of_tags(family, index, plan.rounds, plan.seed),
            agreement: agreement::measure(one, plan.probes, plan.seed ^ number << 32, &bar),
        }
    };
    let lines = (1..).zip(&loaded).map(line).collect();
    bar.finish_and_clear();
    let in_all = lookup::in_all(&loaded, plan.rounds, plan.seed);
    Ok(Outcome { load, in_all, lines })
}
