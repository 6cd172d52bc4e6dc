//! Families that differ in nothing but what chose their codes, and in the seed.

use std::ops::ControlFlow;

use tagbus_family::search::{Limits, Search, State};
use tagbus_family::{Layout, Recipe};

use super::contenders::Contender;

type Failure = Box<dyn std::error::Error>;

/// A search that needs more candidates than this is none that ends in seconds.
const MOST_CANDIDATES: u64 = 1 << 33;

/// What all families of one table have in common.
pub(super) struct Kind {
    pub(super) name: &'static str,
    /// The published family with this layout and distance.
    pub(super) family: &'static str,
    /// How many codes, the first that are found.
    pub(super) codes: usize,
    pub(super) paper: Printed,
}

/// What the paper prints.
pub(super) struct Printed {
    pub(super) quads: usize,
    /// False positives by rectangles, components and Ising energy, for 0 to 3 corrected bits.
    pub(super) counts: [[u32; 4]; 3],
}

/// Tables II and I of the paper.
pub(super) const KINDS: [Kind; 2] = [
    Kind {
        name: "21h7",
        family: "tagCircle21h7",
        codes: 35,
        paper: Printed {
            quads: 6_128_551,
            counts: [[152, 3273, 40_462, 303_028], [131, 3600, 45_052, 320_174], [85, 1867, 22_266, 165_862]],
        },
    },
    Kind {
        name: "41h12",
        family: "tagStandard41h12",
        codes: 1500,
        paper: Printed { quads: 6_090_028, counts: [[0, 1, 8, 99], [0, 0, 11, 105], [0, 0, 4, 44]] },
    },
];

/// Families of one layout, distance and size.
pub(super) struct Maker<'a> {
    pub(super) layout: &'a Layout,
    pub(super) distance: u32,
    pub(super) codes: usize,
    /// The codes do not depend on it.
    pub(super) threads: usize,
}

impl Maker<'_> {
    /// The family of each contender, all with this seed: its first codes, each in its four turns. `None` when a contender
    /// finds too few.
    ///
    /// # Errors
    /// A distance that no code of the layout has.
    pub(super) fn families(
        &self,
        contenders: &[Contender],
        seed: u32,
    ) -> Result<Option<Vec<Vec<u64>>>, Failure> {
        let mut families = Vec::new();
        for contender in contenders {
            let recipe = Recipe::new(self.layout.clone(), self.distance, seed, contender.rule())?;
            let Some(codes) = self.first_codes(&recipe) else { return Ok(None) };
            families.push(codes.into_iter().flat_map(|code| turns(self.layout, code)).collect());
        }
        Ok(Some(families))
    }

    fn first_codes(&self, recipe: &Recipe) -> Option<Vec<u64>> {
        let limits = Limits { codes: Some(self.codes), candidates: Some(MOST_CANDIDATES) };
        let mut state = State::default();
        let search = Search::new(recipe.clone()).with_limits(limits).with_threads(self.threads);
        search.run(&mut state, &mut |_, _| ControlFlow::Continue(()));
        (state.found.len() == self.codes).then(|| recipe.codes(&state.found))
    }
}

fn turns(layout: &Layout, code: u64) -> [u64; 4] {
    let once = layout.rotate90(code);
    let twice = layout.rotate90(once);
    [code, once, twice, layout.rotate90(twice)]
}

#[cfg(test)]
mod tests {
    use super::super::contenders::{DEFAULTS, Field};
    use super::*;
    use tagbus_family::Family;

    fn maker(layout: &Layout, codes: usize) -> Maker<'_> {
        Maker { layout, distance: 7, codes, threads: 1 }
    }

    #[test]
    fn codes_come_in_their_four_turns_keep_their_distance_and_pass() {
        let layout = Layout::circle(9).unwrap();
        let contenders = Field::new(&layout, 100).contenders;
        let families = maker(&layout, 20).families(&contenders, 3).unwrap().unwrap();
        assert_eq!(families.len(), contenders.len());
        for (contender, codes) in contenders.iter().zip(&families) {
            assert_eq!(codes.len(), 80);
            assert!(codes.iter().all(|&code| contender.rule().allows(&layout, code)));
            for (place, code) in codes.iter().enumerate() {
                assert!(codes[..place].iter().all(|other| (other ^ code).count_ones() >= 7));
            }
        }
    }

    #[test]
    fn with_the_published_seed_ising_gives_the_first_published_codes() {
        let published = Family::published("tagCircle21h7").unwrap();
        let recipe = tagbus_family::published::named("tagCircle21h7").unwrap().recipe().unwrap();
        let contenders = Field::new(published.layout(), 100).contenders;
        let families = maker(published.layout(), 35).families(&contenders, recipe.seed_complexity());
        let families = families.unwrap().unwrap();
        let ours: Vec<u64> = families[DEFAULTS.end - 1].iter().copied().step_by(4).collect();
        assert_eq!(ours, published.codes()[..35]);
    }

    #[test]
    fn a_seed_that_gives_one_contender_too_few_codes_gives_none_a_family() {
        let layout = Layout::circle(9).unwrap();
        let contenders = Field::new(&layout, 100).contenders;
        assert!(maker(&layout, 500).families(&contenders, 3).unwrap().is_none());
    }
}
