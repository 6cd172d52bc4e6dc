//! What is known of a family before any picture is seen.

use tagbus_family::{Border, Cell, Family, Found, Index};

use super::sample::LANES;

/// Families with more codes are not searched code by code.
const MOST_CODES_COUNTED: usize = 4096;

/// A family made ready for reading. Cells are counted from the top-left corner of the border edge: cell (x, y) has its
/// centre at (x + 0.5, y + 0.5) and the border edge is the square from (0, 0) to (width, width).
pub(crate) struct Reader {
    /// Place of the family in the detector's list.
    pub(crate) family: usize,
    pub(crate) border: Border,
    /// Cells along the border edge.
    pub(crate) width: f64,
    /// The data cells, most significant bit first.
    pub(crate) data: Vec<DataCell>,
    /// Cells on both sides of the border edge, side by side.
    pub(crate) sides: [Vec<SideCells>; 4],
    /// Colours of the cells that every tag of the family has the same, as places of `Reader::grid`.
    pub(crate) known: Vec<KnownCell>,
    /// The same cells as `data`, `known` and on both sides of the border, to be sampled together.
    pub(crate) lanes: CellLanes,
    /// Cells a row of the scratch grid: the print and one cell around it.
    pub(crate) grid_width: usize,
    pub(crate) index: Index,
    known_tags: Family,
    pub(crate) has_hole: bool,
    /// Whether some tag shows nothing but the border's own colour inside of it.
    pub(crate) may_be_full: bool,
    /// Fewest and most white bits of a code.
    white_bits: [u32; 2],
    /// Natural logarithm of the number of codes over the number of words: how rare a code is among random bits.
    rarity: f64,
    bits: u32,
}

/// Cells of a family, some at a time.
pub(crate) struct CellLanes {
    pub(crate) data: Vec<Cells>,
    pub(crate) white_known: Vec<Cells>,
    pub(crate) black_known: Vec<Cells>,
    /// White and black neighbours along the border edge, in the same order.
    pub(crate) white_ring: Vec<Cells>,
    pub(crate) black_ring: Vec<Cells>,
}

/// Cells whose centres are sampled together.
pub(crate) struct Cells {
    pub(crate) x: [f32; LANES],
    pub(crate) y: [f32; LANES],
    /// Places in the scratch grid; 0, where nothing is ever read, for those that fill up the last few.
    pub(crate) places: [usize; LANES],
    /// 1, and 0 for those that fill up the last few.
    pub(crate) counts: [f32; LANES],
}

impl Cells {
    fn new(cells: &[([f64; 2], usize)]) -> Self {
        let mut lanes = Self { x: [0.5; LANES], y: [0.5; LANES], places: [0; LANES], counts: [0.0; LANES] };
        for (i, ([x, y], place)) in cells.iter().enumerate() {
            (lanes.x[i], lanes.y[i], lanes.places[i]) = (*x as f32, *y as f32, *place);
            lanes.counts[i] = 1.0;
        }
        lanes
    }

    fn all(cells: impl Iterator<Item = ([f64; 2], usize)>) -> Vec<Self> {
        cells.collect::<Vec<_>>().chunks(LANES).map(Self::new).collect()
    }
}

/// Where a border has more cells than this, every second or third is sampled.
const MOST_RING_CELLS: usize = 128;

impl CellLanes {
    fn new(data: &[DataCell], known: &[KnownCell], rings: &[RingCell]) -> Self {
        let of_colour = |white: bool| {
            let cells = known.iter().filter(move |cell| cell.white == white);
            Cells::all(cells.map(|cell| (cell.centre, cell.place)))
        };
        let ring = || rings.iter().step_by(rings.len().div_ceil(MOST_RING_CELLS));
        Self {
            data: Cells::all(data.iter().map(|cell| (cell.centre, cell.place))),
            white_known: of_colour(true),
            black_known: of_colour(false),
            white_ring: Cells::all(ring().map(|cell| (cell.white, 0))),
            black_ring: Cells::all(ring().map(|cell| (cell.black, 0))),
        }
    }
}

/// A cell that carries a bit.
pub(crate) struct DataCell {
    pub(crate) centre: [f64; 2],
    /// Place in the scratch grid.
    pub(crate) place: usize,
}

/// A cell whose colour is the same in every tag of the family.
pub(crate) struct KnownCell {
    pub(crate) centre: [f64; 2],
    pub(crate) place: usize,
    pub(crate) white: bool,
}

/// Two neighbouring cells with the border edge between them.
struct RingCell {
    white: [f64; 2],
    black: [f64; 2],
}

/// Some cells on both sides of one side of the border, whose centres are sampled together.
pub(crate) struct SideCells {
    pub(crate) white: [[f64; LANES]; 2],
    pub(crate) black: [[f64; LANES]; 2],
    /// How many there are; the others have a place on the border that is not used.
    pub(crate) count: usize,
}

impl SideCells {
    fn all(cells: &[RingCell]) -> Vec<Self> {
        cells.chunks(LANES).map(Self::new).collect()
    }

    fn new(cells: &[RingCell]) -> Self {
        let mut lanes = Self { white: [[0.0; LANES]; 2], black: [[0.0; LANES]; 2], count: cells.len() };
        for (i, RingCell { white, black }) in cells.iter().enumerate() {
            (lanes.white[0][i], lanes.white[1][i]) = (white[0], white[1]);
            (lanes.black[0][i], lanes.black[1][i]) = (black[0], black[1]);
        }
        lanes
    }
}

/// Small tags with little data inside of the border can be of one colour there. Of the published ones some of tagCircle49h12,
/// tagCustom48h12 and tagStandard41h12 are.
fn may_be_full(family: &Family) -> bool {
    let layout = family.layout();
    let inside = 0..layout.width_at_border() as i32;
    let (own, other) = match layout.border() {
        Border::Normal => (0, Cell::White),
        Border::Reversed => (u64::MAX, Cell::Black),
    };
    let is_other = |y: i32| inside.clone().any(|x| layout.cell(x, y) == other);
    if inside.clone().any(is_other) {
        return false;
    }
    let is_inside = |[x, y]: &[i32; 2]| inside.contains(x) && inside.contains(y);
    let data = layout.bits().iter().fold(0_u64, |bits, at| bits << 1 | u64::from(is_inside(at)));
    family.codes().iter().any(|code| (code ^ own) & data == 0)
}

impl Reader {
    /// Makes a family ready. `hamming` bits are corrected, or the family's own default; only `ids` are known unless empty.
    pub(crate) fn new(place: usize, family: &Family, hamming: Option<u32>, ids: &[u32]) -> Self {
        let layout = family.layout();
        let hamming = hamming.unwrap_or_else(|| family.default_hamming());
        let index =
            if ids.is_empty() { Index::new(family, hamming) } else { Index::for_ids(family, hamming, ids) };
        let frame = layout.margin() as i32 + 1;
        let grid_width = layout.total_width() + 2;
        let place_of = |x: i32, y: i32| (y + frame) as usize * grid_width + (x + frame) as usize;
        let centre = |x: i32, y: i32| [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let print = -frame..grid_width as i32 - frame;
        let known = print.clone().flat_map(|y| print.clone().map(move |x| (x, y))).filter_map(|(x, y)| {
            let white = match layout.cell(x, y) {
                Cell::White => true,
                Cell::Black => false,
                Cell::Data | Cell::Ignored => return None,
            };
            Some(KnownCell { centre: centre(x, y), place: place_of(x, y), white })
        });
        let data =
            layout.bits().iter().map(|[x, y]| DataCell { centre: centre(*x, *y), place: place_of(*x, *y) });
        let bits = layout.bit_count();
        let (data, known): (Vec<_>, Vec<_>) = (data.collect(), known.collect());
        let rings = ring_cells(layout.width_at_border(), layout.border());
        Self {
            lanes: CellLanes::new(&data, &known, &rings),
            family: place,
            border: layout.border(),
            width: layout.width_at_border() as f64,
            data,
            sides: std::array::from_fn(|k| {
                SideCells::all(&rings[k * rings.len() / 4..(k + 1) * rings.len() / 4])
            }),
            known,
            grid_width,
            index,
            known_tags: family.clone(),
            has_hole: layout.hole_width() > 0,
            may_be_full: may_be_full(family),
            white_bits: white_bits(family.codes()),
            rarity: (4.0 * family.codes().len() as f64).ln() - f64::from(bits) * std::f64::consts::LN_2,
            bits,
        }
    }

    /// Cells of the scratch grid before the border edge.
    pub(crate) fn grid_margin(&self) -> f64 {
        (self.grid_width as f64 - self.width) * 0.5
    }

    /// Whether bits with so many errors, and no more, can be those of a tag, judged by the number of white ones: a black
    /// square or a window is refused before anything is done to read it better.
    pub(crate) fn may_hold(&self, code: u64, errors: u32) -> bool {
        let white = code.count_ones();
        let [fewest, most] = self.white_bits;
        white + errors >= fewest && white <= most + errors
    }

    /// Bits in which `code` differs from the nearest tag, whatever way that is turned. 0 for large families, where counting
    /// would cost more than it saves.
    #[inline(always)]
    pub(crate) fn bits_from_nearest(&self, code: u64) -> u32 {
        let codes = self.known_tags.codes();
        if codes.len() > MOST_CODES_COUNTED {
            return 0;
        }
        let mut turned = [code; 4];
        for k in 1..4 {
            turned[k] = self.known_tags.layout().rotate90(turned[k - 1]);
        }
        let mut least = u64::BITS;
        for known in codes {
            for word in turned {
                least = least.min((known ^ word).count_ones());
            }
        }
        least
    }

    /// The code of a tag, turned as it was read.
    pub(crate) fn code_as_read(&self, found: &Found) -> u64 {
        let upright = self.known_tags.codes()[found.id as usize];
        (found.rotation..4).fold(upright, |code, _| self.known_tags.layout().rotate90(code))
    }

    /// Logarithm of the number of tags that random bits are expected to be taken for, with so many corrected bits:
    /// 4 N C(n, h) / 2^n. The smaller, the surer a reading.
    pub(crate) fn chance(&self, hamming: u32) -> f64 {
        let choices: f64 = (0..hamming).map(|k| (f64::from(self.bits - k) / f64::from(k + 1)).ln()).sum();
        self.rarity + choices
    }
}

fn white_bits(codes: &[u64]) -> [u32; 2] {
    let counts = || codes.iter().map(|code| code.count_ones());
    [counts().min().unwrap_or(0), counts().max().unwrap_or(64)]
}

/// The cells along the border edge, clockwise from the top left.
fn ring_cells(width: usize, border: Border) -> Vec<RingCell> {
    let side = width as f64;
    let sides = (0..4).flat_map(|side| (0..width).map(move |i| (side, i as f64 + 0.5)));
    sides
        .map(|(k, along)| {
            let at = |depth: f64| match k {
                0 => [along, depth],
                1 => [side - depth, along],
                2 => [side - along, side - depth],
                _ => [depth, side - along],
            };
            let (outside, inside) = (at(-0.5), at(0.5));
            match border {
                Border::Normal => RingCell { white: outside, black: inside },
                Border::Reversed => RingCell { white: inside, black: outside },
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Layout;

    #[test]
    fn only_families_with_a_tag_of_one_colour_inside_may_be_full() {
        let family = |cells: &str, codes: &[u64]| {
            Family::new("mine", Layout::parse(cells).unwrap(), codes.to_vec(), 1).unwrap()
        };
        let full =
            Family::PUBLISHED.map(|name| may_be_full(&Family::published(name).unwrap()).then_some(name));
        assert_eq!(
            full.into_iter().flatten().collect::<Vec<_>>(),
            ["tagCircle49h12", "tagCustom48h12", "tagStandard41h12"]
        );
        // One bit inside, the lowest, and data outside of a white ring.
        let around = "xdddddx dwwwwwd dwbbbwd dwbdbwd dwbbbwd dwwwwwd xdddddx";
        assert!(may_be_full(&family(around, &[0b1011, 0b110])));
        assert!(!may_be_full(&family(around, &[0b1011, 0b111])));
        let alone = "ddddd dbbbd dbwbd dbbbd ddddd";
        assert!(may_be_full(&family(alone, &[1])), "nothing but the border lies inside");
    }
}
