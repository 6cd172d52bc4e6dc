//! What a candidate has to pass beside being far from the codes before: it must be far from itself turned, and complex.

use crate::complexity::{Metric, RectanglePainter};
use crate::grid::Paint;
use crate::layout::Layout;
use crate::recipe::{BitOrder, Recipe};

/// Judges single candidates of a recipe. Candidates are what the sequence yields: their bits may lie in another order
/// than those of codes.
pub(super) struct Judge {
    recipe: Recipe,
    turned: ByteTables<u64>,
    energy: Option<Energy>,
    painter: Option<RectanglePainter>,
}

impl Judge {
    pub(super) fn new(recipe: &Recipe) -> Judge {
        let layout = recipe.layout();
        let turned = |bit: u32| recipe.to_candidate(layout.rotate90(recipe.from_candidate(1 << bit)));
        let metric = recipe.rule().metric;
        let is_fast_ising = metric == Metric::Ising && recipe.order() == BitOrder::Quadrants;
        let is_painted = metric == Metric::DataRectangles && recipe.order() == BitOrder::Rows;
        Judge {
            turned: ByteTables::new(layout.bit_count(), turned),
            energy: is_fast_ising.then(|| Energy::of(layout)).flatten(),
            painter: is_painted.then(|| RectanglePainter::new(layout.bit_count().isqrt())),
            recipe: recipe.clone(),
        }
    }

    /// The candidate and what it is when its tag is turned by one, two and three quarters.
    pub(super) fn rotations(&self, candidate: u64) -> [u64; 4] {
        let once = self.turned.of(candidate);
        let twice = self.turned.of(once);
        [candidate, once, twice, self.turned.of(twice)]
    }

    /// Whether the tag can be told from itself turned and is complex enough.
    pub(super) fn allows(&self, candidate: u64) -> bool {
        let [_, once, twice, _] = self.rotations(candidate);
        let far = |turned: u64| (candidate ^ turned).count_ones() >= self.recipe.distance();
        far(once) && far(twice) && self.is_complex(candidate)
    }

    fn is_complex(&self, candidate: u64) -> bool {
        let rule = self.recipe.rule();
        match (&self.energy, &self.painter) {
            (Some(energy), _) => energy.of_code(candidate) >= rule.least,
            (_, Some(painter)) => painter.count(candidate, rule.least) >= rule.least,
            _ => rule.allows(self.recipe.layout(), self.recipe.from_candidate(candidate)),
        }
    }
}

/// A function of codes whose value is the union of its values for the single bits, byte by byte in tables.
struct ByteTables<T>(Vec<[T; 256]>);

impl<T: Copy + Default + std::ops::BitOr<Output = T>> ByteTables<T> {
    fn new(bit_count: u32, of_bit: impl Fn(u32) -> T) -> ByteTables<T> {
        let table = |byte: u32| {
            let bits =
                |value: usize| (0..8).filter(move |bit| value >> bit & 1 == 1).map(move |bit| byte * 8 + bit);
            let union = |value| {
                bits(value).filter(|bit| *bit < bit_count).fold(T::default(), |all, bit| all | of_bit(bit))
            };
            std::array::from_fn(union)
        };
        ByteTables((0..bit_count.div_ceil(8)).map(table).collect())
    }

    fn of(&self, code: u64) -> T {
        let bytes = code.to_le_bytes();
        self.0.iter().zip(bytes).fold(T::default(), |all, (table, byte)| all | table[usize::from(byte)])
    }
}

/// The Ising energy of tags of up to 128 cells, all pairs of neighbours at once (see
/// [`crate::complexity::ising_energy`]).
struct Energy {
    width: usize,
    /// Bit `y * width + x` is a white cell.
    fixed: u128,
    data: ByteTables<u128>,
    /// Cells that have a neighbour to their right.
    across: u128,
    /// Cells that have a neighbour below.
    down: u128,
}

impl Energy {
    fn of(layout: &Layout) -> Option<Energy> {
        let width = layout.total_width();
        if width * width > 128 {
            return None;
        }
        let black = layout.draw(0);
        let cells = |is: &dyn Fn(usize, usize) -> bool| {
            let place = |cell: usize| u128::from(is(cell % width, cell / width)) << cell;
            (0..width * width).fold(0, |all, cell| all | place(cell))
        };
        let in_tag = |x: usize, y: usize| x < width && y < width && black.get(x, y) != Paint::Clear;
        let margin = layout.margin() as i32;
        let place = |bit: u32| {
            let [x, y] = layout.bits()[(layout.bit_count() - 1 - bit) as usize];
            1 << ((y + margin) as usize * width + (x + margin) as usize)
        };
        Some(Energy {
            width,
            fixed: cells(&|x, y| black.get(x, y) == Paint::White),
            data: ByteTables::new(layout.bit_count(), place),
            across: cells(&|x, y| in_tag(x, y) && in_tag(x + 1, y)),
            down: cells(&|x, y| in_tag(x, y) && in_tag(x, y + 1)),
        })
    }

    fn of_code(&self, code: u64) -> u32 {
        let white = self.fixed | self.data.of(code);
        let across = (white ^ white >> 1) & self.across;
        let down = (white ^ white >> self.width) & self.down;
        across.count_ones() + down.count_ones()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complexity::{ising_energy, rectangle_count};
    use crate::published::FAMILIES;
    use crate::random::Random;

    #[test]
    fn candidates_turn_as_their_tags_do() {
        let mut random = Random::new(1);
        for recipe in FAMILIES.iter().map(|family| family.recipe().unwrap()) {
            let judge = Judge::new(&recipe);
            for _ in 0..100 {
                let code = random.next() >> (64 - recipe.layout().bit_count());
                let turned = judge
                    .rotations(recipe.to_candidate(code))
                    .map(|candidate| recipe.from_candidate(candidate));
                assert_eq!(turned[0], code);
                assert_eq!(turned[1], recipe.layout().rotate90(code));
                assert_eq!(recipe.layout().rotate90(turned[3]), code);
            }
        }
    }

    #[test]
    fn the_quick_energy_is_the_energy() {
        let mut random = Random::new(2);
        for layout in [Layout::circle(9), Layout::standard(10), Layout::classic(11), Layout::circle(11)]
            .map(Result::unwrap)
        {
            let energy = Energy::of(&layout).unwrap();
            for _ in 0..200 {
                let code = random.next() >> (64 - layout.bit_count());
                assert_eq!(energy.of_code(code), ising_energy(&layout.draw(code)), "{code:#x}");
            }
        }
        assert!(Energy::of(&Layout::classic(12).unwrap()).is_none(), "144 cells");
    }

    #[test]
    fn what_is_judged_quickly_is_judged_as_the_rule_says() {
        let mut random = Random::new(3);
        for recipe in FAMILIES.iter().map(|family| family.recipe().unwrap()) {
            let judge = Judge::new(&recipe);
            let mut allowed = 0;
            for _ in 0..300 {
                let candidate = random.next() >> (64 - recipe.layout().bit_count());
                let code = recipe.from_candidate(candidate);
                let allows = recipe.rule().allows(recipe.layout(), code);
                assert_eq!(judge.is_complex(candidate), allows, "{code:#x}");
                allowed += u32::from(allows);
            }
            assert!(allowed > 0, "{} bits: nothing is complex enough", recipe.layout().bit_count());
        }
    }

    #[test]
    fn the_painter_stops_when_it_has_seen_enough() {
        let painter = RectanglePainter::new(4);
        assert_eq!(painter.count(0b0101_1010_0101_1010, 99), rectangle_count(0b0101_1010_0101_1010, 4));
        assert_eq!(painter.count(0b0101_1010_0101_1010, 3), 3);
    }
}
