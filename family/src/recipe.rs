//! How a family is made: everything that decides which codes it has.

use crate::candidates::Candidates;
use crate::complexity::Rule;
use crate::layout::Layout;
use std::fmt;

/// In which order the bits of a candidate lie in the tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitOrder {
    /// As [`Layout::bits`] says.
    Quadrants,
    /// Row after row from the top: the families of the first AprilTag releases.
    Rows,
}

impl BitOrder {
    /// Both.
    pub const ALL: [BitOrder; 2] = [BitOrder::Quadrants, BitOrder::Rows];

    /// `quadrants` or `rows`.
    pub fn name(self) -> &'static str {
        match self {
            BitOrder::Quadrants => "quadrants",
            BitOrder::Rows => "rows",
        }
    }

    /// The order of this name.
    pub fn named(name: &str) -> Option<BitOrder> {
        BitOrder::ALL.into_iter().find(|order| order.name() == name)
    }
}

/// The recipe of a family: a greedy search through the candidate sequence keeps every code that is complex enough and
/// far enough from its own rotations and from all codes before.
///
/// Source: "Flexible Layouts for Fiducial Tags", section III-B.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    layout: Layout,
    distance: u32,
    seed_complexity: u32,
    rule: Rule,
    order: BitOrder,
}

impl Recipe {
    /// A recipe whose candidates have their bits in the order of [`Layout::bits`]. `distance` is the number of bits in
    /// which any two codes have to differ, however they are turned; `seed_complexity` is a number that only chooses
    /// the candidate sequence.
    ///
    /// # Errors
    /// [`RecipeError`] when no code of the layout is `distance` bits away from its own rotations.
    pub fn new(
        layout: Layout,
        distance: u32,
        seed_complexity: u32,
        rule: Rule,
    ) -> Result<Recipe, RecipeError> {
        let largest = largest_distance(layout.bit_count());
        if !(1..=largest).contains(&distance) {
            return Err(RecipeError::Distance { distance, largest, bit_count: layout.bit_count() });
        }
        Ok(Recipe { layout, distance, seed_complexity, rule, order: BitOrder::Quadrants })
    }

    /// The same with candidates whose bits lie in another order.
    #[must_use]
    pub fn with_order(self, order: BitOrder) -> Recipe {
        Recipe { order, ..self }
    }

    /// What each cell is.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Bits in which any two codes differ at least, however they are turned.
    pub fn distance(&self) -> u32 {
        self.distance
    }

    /// The number that went into the seed beside the bits and the distance.
    pub fn seed_complexity(&self) -> u32 {
        self.seed_complexity
    }

    /// Which codes are complex enough.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// The order of the candidates' bits.
    pub fn order(&self) -> BitOrder {
        self.order
    }

    /// The candidate sequence in which the codes are searched.
    pub fn candidates(&self) -> Candidates {
        Candidates::new(self.layout.bit_count(), self.distance, self.seed_complexity)
    }

    /// The number of candidates: of all codes, 2^bits (one less for 64 bits).
    pub fn candidate_count(&self) -> u64 {
        1_u64.checked_shl(self.layout.bit_count()).unwrap_or(u64::MAX)
    }

    /// The candidate from which the tag with this code is made.
    pub fn to_candidate(&self, code: u64) -> u64 {
        match self.order {
            BitOrder::Quadrants => code,
            BitOrder::Rows => self.layout.to_row_major(code),
        }
    }

    /// The code of the tag that is made from a candidate: the inverse of [`Recipe::to_candidate`].
    pub fn from_candidate(&self, candidate: u64) -> u64 {
        match self.order {
            BitOrder::Quadrants => candidate,
            BitOrder::Rows => self.layout.from_row_major(candidate),
        }
    }

    /// The codes of these candidates, by their numbers in the sequence.
    pub fn codes(&self, numbers: &[u64]) -> Vec<u64> {
        let candidates = self.candidates();
        numbers.iter().map(|&number| self.from_candidate(candidates.code(number))).collect()
    }
}

/// The largest number of bits in which a code can differ from itself turned, by a quarter and by half a turn.
///
/// The bits come in fours that change places when the tag is turned. Of each four, (quarter turn, half turn) can change
/// (4, 0), (2, 4) or (2, 2) bits; the third is never better than the second.
pub fn largest_distance(bit_count: u32) -> u32 {
    let fours = bit_count / 4;
    let both = |striped: u32| (4 * striped + 2 * (fours - striped)).min(4 * (fours - striped));
    (0..=fours).map(both).max().unwrap_or(0)
}

/// Why a family cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecipeError {
    /// No code is that far from its own rotations.
    Distance {
        /// The distance that was asked for.
        distance: u32,
        /// The largest that a code of the layout can have.
        largest: u32,
        /// Data cells of the layout.
        bit_count: u32,
    },
}

impl fmt::Display for RecipeError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RecipeError::Distance { distance, largest, bit_count } = self;
        write!(
            out,
            "no code has a distance of {distance}: with {bit_count} bits a code differs from itself turned in at most {largest}; \
             ask for 1 to {largest}"
        )
    }
}

impl std::error::Error for RecipeError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complexity::Metric;

    #[test]
    fn the_largest_distance_is_that_of_the_best_of_all_codes() {
        for layout in [Layout::classic(6), Layout::classic(7), Layout::classic(8)].map(Result::unwrap) {
            let own = |code: u64| {
                let once = layout.rotate90(code);
                let twice = layout.rotate90(once);
                (code ^ once).count_ones().min((code ^ twice).count_ones())
            };
            let best = (0..1 << layout.bit_count()).map(own).max();
            assert_eq!(best, Some(largest_distance(layout.bit_count())), "{} bits", layout.bit_count());
        }
    }

    #[test]
    fn distances_that_no_code_has_are_refused() {
        let recipe = |distance| {
            let rule = Rule { metric: Metric::Ising, least: 0 };
            Recipe::new(Layout::classic(8).unwrap(), distance, 10, rule)
        };
        assert!(recipe(10).is_ok());
        assert_eq!(recipe(11), Err(RecipeError::Distance { distance: 11, largest: 10, bit_count: 16 }));
        assert!(recipe(0).unwrap_err().to_string().contains("ask for 1 to 10"));
    }
}
