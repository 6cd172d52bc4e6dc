//! The cells around pixels as the blur mixes them.
//!
//! Along each axis a pixel sees every cell of its window by a share: what the blur leaves of it between the lines on both
//! sides. The brightness is the sum of the cells' colours, each by both of its shares.

use super::blur::normal;
use super::model::{Coordinate, Places};
use super::pattern::{CELL_BITS, colour, opposite};
use super::pixels::{BLOCK, Block, Lanes, ZERO};

/// Four times the brightness of white, as [`colour`] gives it.
const WHITE: f32 = 4.0;

/// The blurred pattern with its derivatives by place and by the blur's logarithms.
#[repr(align(64))]
pub(super) struct Blurred {
    pub(super) value: Lanes,
    pub(super) by_u: Lanes,
    pub(super) by_v: Lanes,
    pub(super) by_blur_u: Lanes,
    pub(super) by_blur_v: Lanes,
    /// How much brighter it gets when white grows across u (v) by a cell.
    pub(super) by_growth_u: Lanes,
    pub(super) by_growth_v: Lanes,
}

impl Blurred {
    pub(super) const NONE: Self = Self {
        value: ZERO,
        by_u: ZERO,
        by_v: ZERO,
        by_blur_u: ZERO,
        by_blur_v: ZERO,
        by_growth_u: ZERO,
        by_growth_v: ZERO,
    };

    /// Around pixels, by the blur `sigma` in units of the patch, where white has not grown. Cells outside of the windows have
    /// the colours of the outermost ones inside.
    #[inline(always)]
    pub(super) fn plain<const WINDOW: usize>(block: &Block, places: &Places, sigma: [f32; 2]) -> Self {
        let u = Shares::<WINDOW>::new(&places.u, &block.first_u, sigma[0]);
        let v = Shares::<WINDOW>::new(&places.v, &block.first_v, sigma[1]);
        let mut t = Self::NONE;
        let mut columns = Columns { cells: [ZERO; WINDOW], edges: [ZERO; WINDOW] };
        for j in 0..WINDOW {
            t.add_row(&block.rows[j], &u, &v, j, &mut columns);
            if j > 0 {
                t.add_growth(&block.rows[j - 1], &block.rows[j], &u, &v.density[j]);
            }
        }
        t.add_columns(&columns, &u);
        t
    }

    /// Adds the row `j` of the windows' cells.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn add_row<const WINDOW: usize>(
        &mut self,
        words: &[u32; BLOCK],
        u: &Shares<WINDOW>,
        v: &Shares<WINDOW>,
        j: usize,
        columns: &mut Columns<WINDOW>,
    ) {
        for l in 0..BLOCK {
            let (word, share) = (words[l], v.share[j][l]);
            let opposites = opposite(word, word >> CELL_BITS);
            let mut row = 0.0;
            for k in 0..WINDOW {
                let brightness = brightness(word, k);
                row += u.share[k][l] * brightness;
                columns.cells[k][l] += share * brightness;
                if k > 0 {
                    columns.edges[k][l] += share * colour(opposites, k - 1) as f32;
                }
            }
            self.by_v[l] += v.by_place[j][l] * row;
            self.by_blur_v[l] += v.by_blur[j][l] * row;
        }
    }

    /// Adds the edges between two rows, of which the blur has this density there.
    #[inline(always)]
    fn add_growth<const WINDOW: usize>(
        &mut self,
        above: &[u32; BLOCK],
        below: &[u32; BLOCK],
        u: &Shares<WINDOW>,
        density: &Lanes,
    ) {
        for l in 0..BLOCK {
            let opposites = opposite(above[l], below[l]);
            let mut edges = 0.0;
            for k in 0..WINDOW {
                edges += u.share[k][l] * colour(opposites, k) as f32;
            }
            self.by_growth_v[l] += density[l] * edges;
        }
    }

    /// Adds what all rows give along u.
    #[inline(always)]
    fn add_columns<const WINDOW: usize>(&mut self, columns: &Columns<WINDOW>, u: &Shares<WINDOW>) {
        for k in 0..WINDOW {
            for l in 0..BLOCK {
                self.value[l] += u.share[k][l] * columns.cells[k][l];
                self.by_u[l] += u.by_place[k][l] * columns.cells[k][l];
                self.by_blur_u[l] += u.by_blur[k][l] * columns.cells[k][l];
                self.by_growth_u[l] += u.density[k][l] * columns.edges[k][l];
            }
        }
    }
}

/// Sums over the rows of windows, each row by its share along v.
#[repr(align(64))]
struct Columns<const WINDOW: usize> {
    cells: [Lanes; WINDOW],
    /// Edges across u before each cell; none at the first.
    edges: [Lanes; WINDOW],
}

/// The brightness of the cell that lies `k` further right than the first one of a word.
#[inline(always)]
fn brightness(word: u32, k: usize) -> f32 {
    colour(word, k) as f32 * (1.0 / WHITE)
}

/// How much of a pixel each cell of its window has along an axis, and how that changes with the place and with the blur's
/// logarithm.
#[repr(align(64))]
struct Shares<const WINDOW: usize> {
    share: [Lanes; WINDOW],
    by_place: [Lanes; WINDOW],
    by_blur: [Lanes; WINDOW],
    /// Of the blur at the line before each cell; none at the first.
    density: [Lanes; WINDOW],
}

impl<const WINDOW: usize> Shares<WINDOW> {
    /// `first` are the windows' first cells, `sigma` is the blur in units of the patch.
    #[inline(always)]
    fn new(coordinate: &Coordinate, first: &Lanes, sigma: f32) -> Self {
        let none = [ZERO; WINDOW];
        let mut s = Self { share: none, by_place: none, by_blur: none, density: none };
        s.share[0] = [1.0; BLOCK];
        let mut inverse = ZERO;
        for (inverse, speed) in inverse.iter_mut().zip(&coordinate.speed) {
            *inverse = 1.0 / (sigma * speed);
        }
        for k in 1..WINDOW {
            for l in 0..BLOCK {
                let z = (coordinate.place[l] - first[l] - k as f32) * inverse[l];
                let (behind, density) = normal(z);
                let (by_place, by_blur) = (density * inverse[l], -z * density);
                s.share[k - 1][l] -= behind;
                s.by_place[k - 1][l] -= by_place;
                s.by_blur[k - 1][l] -= by_blur;
                s.share[k][l] = behind;
                s.by_place[k][l] = by_place;
                s.by_blur[k][l] = by_blur;
                s.density[k][l] = by_place;
            }
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use tagbus_family::Family;

    use super::super::super::reader::Reader;
    use super::super::grown::Steps;
    use super::super::pattern::{MOST_CELLS, Pattern};
    use super::*;

    const SIGMA: f32 = 0.4;

    /// Pixels all over a tag's grid, some near cells of unknown colour, in a picture that has a unit of the patch a cell.
    fn block_on(pattern: &Pattern) -> (Block, Places) {
        let mut block = Block::EMPTY;
        let (mut u, mut v) = (ZERO, ZERO);
        for l in 0..BLOCK {
            let first = [2 + l % 11, 3 + l % 9];
            (block.first_u[l], block.first_v[l]) = (first[0] as f32, first[1] as f32);
            u[l] = first[0] as f32 + 2.0 + (l % 7) as f32 * 0.14;
            v[l] = first[1] as f32 + 2.0 + (l % 5) as f32 * 0.2;
            for (j, row) in block.rows.iter_mut().enumerate() {
                row[l] = pattern.word(first[0], first[1] + j);
            }
        }
        let places =
            Places { u: Coordinate::at_unit_speed(u), v: Coordinate::at_unit_speed(v), depth: [1.0; BLOCK] };
        (block, places)
    }

    #[test]
    fn white_that_has_not_grown_looks_as_if_it_had_grown_by_nothing() {
        let family = Family::published("tag36h11").unwrap();
        let reader = Reader::new(0, &family, None, &[]);
        let mut pattern = Pattern::default();
        pattern.paint(&reader, family.codes()[5]);
        let (block, places) = block_on(&pattern);
        let plain = Blurred::plain::<MOST_CELLS>(&block, &places, [SIGMA; 2]);
        let steps = |coordinate, first| Steps::<MOST_CELLS>::new(coordinate, first, SIGMA, 0.0);
        let (along_u, along_v) = (steps(&places.u, &block.first_u), steps(&places.v, &block.first_v));
        let grown = Blurred::grown(&block.rows, &along_u, &along_v, true);
        let all = |t: &Blurred| {
            [t.value, t.by_u, t.by_v, t.by_blur_u, t.by_blur_v, t.by_growth_u, t.by_growth_v].concat()
        };
        for (i, (plain, grown)) in all(&plain).into_iter().zip(all(&grown)).enumerate() {
            assert!(
                (plain - grown).abs() < 1e-4,
                "quantity {}, pixel {}: {plain}, not {grown}",
                i / BLOCK,
                i % BLOCK
            );
        }
        assert!(
            all(&plain)[..BLOCK].iter().any(|value| (0.3..0.7).contains(value)),
            "some pixel lies at an edge"
        );
    }
}
