//! Layouts: what each cell of the printed square is, where the border lies, and in which order the bits are read.
//!
//! Source: "Flexible Layouts for Fiducial Tags" (Krogius, Haggenmiller, Olson 2019), section III-A.

use crate::grid::{Grid, Paint};
use crate::layout_error::{LayoutError, MAX_BITS, MIN_BITS};
use crate::shape;
use crate::square::{Border, Cell, Square, check_width};

/// A valid layout: a square of cells that looks the same after a quarter turn, with a border and 4 to 64 data bits.
///
/// ```
/// use tagbus_family::{Border, Layout};
///
/// let layout = Layout::parse("wwwwww wbbbbw wbddbw wbddbw wbbbbw wwwwww")?;
/// assert_eq!((layout.total_width(), layout.width_at_border(), layout.bit_count()), (6, 4, 4));
/// assert_eq!(layout.border(), Border::Normal);
/// assert_eq!(layout, Layout::classic(6)?);
/// # Ok::<(), tagbus_family::LayoutError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    square: Square,
    margin: usize,
    border: Border,
    bits: Vec<[i32; 2]>,
}

impl Layout {
    /// Reads n * n letters `w`, `b`, `d`, `x`, row after row from the top; blanks and line breaks are skipped.
    ///
    /// # Errors
    /// Any [`LayoutError`]: the letters are checked first, then the size, symmetry, border and number of bits.
    pub fn parse(cells: &str) -> Result<Layout, LayoutError> {
        let square = Square::parse(cells)?;
        square.check_symmetry()?;
        let (margin, border) = square.find_border().ok_or(LayoutError::NoBorder)?;
        let bits = square.quadrant_order();
        match bits.len() {
            count if count < MIN_BITS => Err(LayoutError::TooFewBits { count }),
            count if count > MAX_BITS => Err(LayoutError::TooManyBits { count }),
            _ => Ok(Layout { bits: from_border(&bits, margin), square, margin, border }),
        }
    }

    /// White ring, black ring, data inside (16h5, 25h9, 36h10, 36h11: 8, 9, 10 and 10 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits.
    pub fn classic(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::classic(total_width))
    }

    /// Data, black ring, white ring, data (41h12 and 52h13: 9 and 10 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits, or no border.
    pub fn standard(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::standard(total_width))
    }

    /// The standard order of rings cut to a disc (21h7 and 49h12: 9 and 11 cells).
    ///
    /// # Errors
    /// [`LayoutError`] when the size leaves too few or too many data bits, or no border.
    pub fn circle(total_width: usize) -> Result<Layout, LayoutError> {
        check_width(total_width)?;
        Layout::parse(&shape::circle(total_width))
    }

    /// Cells along one edge of the print.
    pub fn total_width(&self) -> usize {
        self.square.width()
    }

    /// Cells along the edge where black meets white: the tag size of pose estimation, in cells.
    pub fn width_at_border(&self) -> usize {
        self.square.width() - 2 * self.margin
    }

    /// Which side of that edge is white.
    pub fn border(&self) -> Border {
        self.border
    }

    /// Cells between the edge of the print and the border edge.
    pub fn margin(&self) -> usize {
        self.margin
    }

    /// Number of data bits, 4 to 64; 0 or 1 more than a multiple of four.
    pub fn bit_count(&self) -> u32 {
        self.bits.len() as u32
    }

    /// `[x, y]` of each data cell, counted from the top-left cell inside the border edge and therefore negative for
    /// cells outside it; most significant bit first.
    ///
    /// The order goes round by quadrants so that turning the tag is a cyclic shift of the code: first the wedge
    /// between the two diagonals at the top (row by row), then the same wedge turned to the right, bottom and left,
    /// last the centre cell if that is data.
    pub fn bits(&self) -> &[[i32; 2]] {
        &self.bits
    }

    /// The cell at `x`, `y` counted as in [`Layout::bits`]; [`Cell::Ignored`] outside the print.
    pub fn cell(&self, x: i32, y: i32) -> Cell {
        let in_print = |at: i32| usize::try_from(i64::from(at) + self.margin as i64).ok();
        match (in_print(x), in_print(y)) {
            (Some(x), Some(y)) if x.max(y) < self.square.width() => self.square.at(x, y),
            _ => Cell::Ignored,
        }
    }

    /// The code of the same tag turned counter-clockwise by 90 degrees: what was at its right is at its top.
    ///
    /// Bits of `code` beyond [`Layout::bit_count`] are dropped.
    pub fn rotate90(&self, code: u64) -> u64 {
        rotate90(code, self.bit_count())
    }

    /// The code and those of the same tag turned once, twice and three times by [`Layout::rotate90`].
    pub fn rotations(&self, code: u64) -> [u64; 4] {
        let once = self.rotate90(code);
        let twice = self.rotate90(once);
        [code, once, twice, self.rotate90(twice)]
    }

    /// Cells that belong to the tag: all but the ignored ones.
    pub fn area(&self) -> usize {
        self.square.cells().iter().filter(|&&cell| cell != Cell::Ignored).count()
    }

    /// Width of the centred square of ignored cells into which a smaller tag fits, 0 when there is none
    /// (tagCustom48h12: 2).
    pub fn hole_width(&self) -> usize {
        let smallest_margin = self.square.width().div_ceil(2);
        let ring_is_open = |ring: &usize| self.square.ring_is(*ring, Cell::Ignored);
        let open_rings = (0..smallest_margin).rev().take_while(ring_is_open).count();
        match open_rings {
            0 => 0,
            rings => self.square.width() - 2 * (smallest_margin - rings),
        }
    }

    /// The letters of the layout without blanks, as [`Layout::parse`] reads them.
    pub fn text(&self) -> String {
        self.square.cells().iter().map(|cell| cell.letter()).collect()
    }

    /// The tag with this code, cell by cell. Bits beyond [`Layout::bit_count`] are not looked at.
    pub fn draw(&self, code: u64) -> Grid {
        let mut paint: Vec<Paint> = self.square.cells().iter().map(|&cell| fixed_paint(cell)).collect();
        for (place, &[x, y]) in self.bits.iter().rev().enumerate() {
            if code >> place & 1 == 1 {
                paint[self.print_offset(x, y)] = Paint::White;
            }
        }
        Grid::new(self.square.width(), paint)
    }

    /// The code whose data cells, read row after row from the top, spell `rows` (most significant bit first).
    ///
    /// Older tables (the first AprilTag release, ArUco dictionaries) keep their codes in this order.
    pub fn from_row_major(&self, rows: u64) -> u64 {
        let places = self.row_major_places();
        self.bits.iter().fold(0, |code, &[x, y]| code << 1 | rows >> places[self.print_offset(x, y)] & 1)
    }

    /// The inverse of [`Layout::from_row_major`].
    pub fn to_row_major(&self, code: u64) -> u64 {
        let places = self.row_major_places();
        let bit = |place: usize, [x, y]: [i32; 2]| (code >> place & 1) << places[self.print_offset(x, y)];
        self.bits.iter().rev().enumerate().fold(0, |rows, (place, &at)| rows | bit(place, at))
    }

    /// For each cell of the print the place of its bit, counted from the least significant, in row-major codes.
    fn row_major_places(&self) -> Vec<u32> {
        let mut place = self.bit_count();
        let next = |&cell: &Cell| {
            place -= u32::from(cell == Cell::Data);
            place
        };
        self.square.cells().iter().map(next).collect()
    }

    fn print_offset(&self, x: i32, y: i32) -> usize {
        let margin = self.margin as i32;
        (y + margin) as usize * self.square.width() + (x + margin) as usize
    }
}

/// [`Layout::rotate90`] for codes of `bit_count` bits; the centre bit, if there is one, is the lowest and stays.
pub(crate) fn rotate90(code: u64, bit_count: u32) -> u64 {
    let centre = bit_count % 4;
    let turning = bit_count - centre;
    let quarter = turning / 4;
    let mask = u64::MAX >> (64 - turning);
    let turned = code >> centre & mask;
    let turned = (turned << quarter | turned >> (turning - quarter)) & mask;
    turned << centre | code & centre_mask(centre)
}

fn centre_mask(centre: u32) -> u64 {
    (1 << centre) - 1
}

fn fixed_paint(cell: Cell) -> Paint {
    match cell {
        Cell::White => Paint::White,
        Cell::Black | Cell::Data => Paint::Black,
        Cell::Ignored => Paint::Clear,
    }
}

fn from_border(bits: &[[usize; 2]], margin: usize) -> Vec<[i32; 2]> {
    bits.iter().map(|at| at.map(|print| print as i32 - margin as i32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const CUSTOM: &str = "dddddddddd dbbbbbbbbd dbwwwwwwbd dbwddddwbd dbwdxxdwbd
                          dbwdxxdwbd dbwddddwbd dbwwwwwwbd dbbbbbbbbd dddddddddd";

    fn named() -> Vec<Layout> {
        let named = [
            Layout::classic(8),
            Layout::classic(9),
            Layout::classic(10),
            Layout::standard(9),
            Layout::standard(10),
            Layout::circle(9),
            Layout::circle(11),
            Layout::parse(CUSTOM),
        ];
        named.map(Result::unwrap).to_vec()
    }

    /// The letters of a random square that looks the same after a quarter turn and has a border somewhere.
    fn random_letters(random: &mut Random) -> String {
        let width = 4 + random.below(8);
        let edge = random.below(width.div_ceil(2) - 1);
        let rings = if random.below(2) == 0 { ['w', 'b'] } else { ['b', 'w'] };
        let mut letters = vec![' '; width * width];
        for y in 0..width {
            for x in 0..width {
                let ring = x.min(y).min(width - 1 - x).min(width - 1 - y);
                let free = ['w', 'b', 'd', 'd', 'd', 'x'][random.below(6)];
                let letter = if ring == edge || ring == edge + 1 { rings[ring - edge] } else { free };
                let [mut x, mut y] = [x, y];
                for _ in 0..4 {
                    letters[y * width + x] = letter;
                    [x, y] = [width - 1 - y, x];
                }
            }
        }
        letters.into_iter().collect()
    }

    fn random_layouts(seed: u64, count: usize) -> Vec<Layout> {
        let mut random = Random::new(seed);
        std::iter::repeat_with(|| Layout::parse(&random_letters(&mut random))).flatten().take(count).collect()
    }

    fn all(seed: u64) -> Vec<Layout> {
        named().into_iter().chain(random_layouts(seed, 200)).collect()
    }

    fn random_code(layout: &Layout, random: &mut Random) -> u64 {
        random.next() >> (64 - layout.bit_count())
    }

    #[test]
    fn a_layout_is_read_back_from_its_text() {
        for layout in all(1) {
            assert_eq!(Layout::parse(&layout.text()), Ok(layout));
        }
    }

    #[test]
    fn four_quarter_turns_change_nothing() {
        let mut random = Random::new(2);
        for layout in all(2) {
            let code = random_code(&layout, &mut random);
            let turned = (0..4).fold(code, |code, _| layout.rotate90(code));
            assert_eq!(turned, code, "{}", layout.text());
        }
    }

    #[test]
    fn rotate90_turns_the_drawn_tag_counter_clockwise() {
        let mut random = Random::new(3);
        for layout in all(3) {
            let code = random_code(&layout, &mut random);
            let (before, after) = (layout.draw(code), layout.draw(layout.rotate90(code)));
            let last = layout.total_width() - 1;
            for y in 0..=last {
                for x in 0..=last {
                    assert_eq!(after.get(x, y), before.get(last - y, x), "{} {code:#x}", layout.text());
                }
            }
        }
    }

    #[test]
    fn rotate90_works_on_codes_of_64_bits() {
        let layout = Layout::classic(12).unwrap();
        assert_eq!(layout.bit_count(), 64);
        assert_eq!(layout.rotate90(0xffff_0000_1234_0001), 0x0000_1234_0001_ffff);
    }

    #[test]
    fn the_centre_bit_stays_where_it_is() {
        let layout = Layout::classic(9).unwrap();
        assert_eq!(layout.rotate90(1), 1);
        assert_eq!(layout.bits().last(), Some(&[3, 3]));
    }

    #[test]
    fn each_data_cell_has_exactly_one_bit() {
        for layout in all(4) {
            let width = layout.total_width() as i32;
            let mut bits = layout.bits().to_vec();
            bits.sort_unstable();
            let margin = layout.margin() as i32;
            let cells =
                (-margin..width - margin).flat_map(|x| (-margin..width - margin).map(move |y| [x, y]));
            let data: Vec<[i32; 2]> = cells.filter(|&[x, y]| layout.cell(x, y) == Cell::Data).collect();
            assert_eq!(bits, data, "{}", layout.text());
            assert_eq!(layout.bit_count() as usize, bits.len());
        }
    }

    #[test]
    fn a_one_is_white_and_a_zero_is_black_at_the_place_of_its_bit() {
        for layout in all(5) {
            let margin = layout.margin() as i32;
            for (place, &[x, y]) in layout.bits().iter().rev().enumerate() {
                let [x, y] = [x, y].map(|at| (at + margin) as usize);
                assert_eq!(layout.draw(1 << place).get(x, y), Paint::White);
                assert_eq!(layout.draw(!(1 << place)).get(x, y), Paint::Black);
            }
        }
    }

    #[test]
    fn the_border_edge_lies_between_a_white_and_a_black_ring() {
        for layout in all(6) {
            let (outside, inside) = match layout.border() {
                Border::Normal => (Cell::White, Cell::Black),
                Border::Reversed => (Cell::Black, Cell::White),
            };
            let end = layout.width_at_border() as i32;
            for along in 0..end {
                for [x, y] in [[along, 0], [along, end - 1], [0, along], [end - 1, along]] {
                    assert_eq!(layout.cell(x, y), inside, "{}", layout.text());
                }
            }
            for along in -1..=end {
                for [x, y] in [[along, -1], [along, end], [-1, along], [end, along]] {
                    assert_eq!(layout.cell(x, y), outside, "{}", layout.text());
                }
            }
        }
    }

    #[test]
    fn row_major_codes_are_converted_both_ways() {
        let mut random = Random::new(7);
        for layout in all(7) {
            let code = random_code(&layout, &mut random);
            assert_eq!(layout.from_row_major(layout.to_row_major(code)), code);
            assert_eq!(layout.to_row_major(layout.from_row_major(code)), code);
        }
    }

    #[test]
    fn row_major_codes_spell_the_rows() {
        let layout = Layout::classic(8).unwrap();
        let drawn = layout.draw(layout.from_row_major(0b1000_0110_0000_0001));
        let white = |x: usize, y: usize| drawn.get(x + 2, y + 2) == Paint::White;
        let cells = (0..16).filter(|cell| white(cell % 4, cell / 4));
        assert_eq!(cells.collect::<Vec<_>>(), [0, 5, 6, 15]);
    }

    #[test]
    fn sizes_of_the_published_layouts() {
        let facts = |layout: &Layout| {
            (
                layout.bit_count(),
                layout.total_width(),
                layout.width_at_border(),
                layout.margin(),
                layout.area(),
            )
        };
        let expected = [
            (16, 8, 6, 1, 64),
            (25, 9, 7, 1, 81),
            (36, 10, 8, 1, 100),
            (41, 9, 5, 2, 81),
            (52, 10, 6, 2, 100),
            (21, 9, 5, 2, 61),
            (49, 11, 5, 3, 89),
            (48, 10, 6, 2, 96),
        ];
        assert_eq!(named().iter().map(facts).collect::<Vec<_>>(), expected);
        let normal = named().iter().filter(|layout| layout.border() == Border::Normal).count();
        assert_eq!(normal, 3);
    }

    #[test]
    fn the_hole_is_the_centred_square_of_ignored_cells() {
        assert_eq!(named().iter().map(Layout::hole_width).collect::<Vec<_>>(), [0, 0, 0, 0, 0, 0, 0, 2]);
        let odd = Layout::parse("ddddddd dbbbbbd dbwwwbd dbwxwbd dbwwwbd dbbbbbd ddddddd").unwrap();
        assert_eq!(odd.hole_width(), 1);
        // Ignored cells around the tag are no hole.
        let loose =
            Layout::parse("xxxxxxxx xwwwwwwx xwbbbbwx xwbddbwx xwbddbwx xwbbbbwx xwwwwwwx xxxxxxxx").unwrap();
        assert_eq!((loose.hole_width(), loose.margin(), loose.area()), (0, 2, 36));
    }

    #[test]
    fn outside_the_print_nothing_belongs_to_the_tag() {
        let layout = Layout::standard(9).unwrap();
        for (x, y) in [(-3, 0), (0, -3), (7, 0), (0, 7), (i32::MIN, 0), (0, i32::MAX), (i32::MAX, i32::MIN)] {
            assert_eq!(layout.cell(x, y), Cell::Ignored);
        }
        assert_eq!(layout.cell(-2, 6), Cell::Data);
    }

    #[test]
    fn the_outermost_border_counts() {
        let double =
            Layout::parse("bbbbbbbb bwwwwwwb bwbbbbwb bwbddbwb bwbddbwb bwbbbbwb bwwwwwwb bbbbbbbb").unwrap();
        assert_eq!((double.border(), double.width_at_border()), (Border::Reversed, 6));
    }

    #[test]
    fn letters_other_than_the_four_are_refused() {
        let error = Layout::parse("wwww\nwb r").unwrap_err();
        assert_eq!(error, LayoutError::UnknownLetter { letter: 'r', position: 6 });
        assert!(error.to_string().starts_with("cell 6 of the layout is 'r'"), "{error}");
    }

    #[test]
    fn numbers_of_cells_that_are_no_square_are_refused() {
        let error = Layout::parse(&"d".repeat(82)).unwrap_err();
        assert_eq!(error, LayoutError::NotSquare { cells: 82 });
        assert!(error.to_string().ends_with("the next squares are 81 and 100"), "{error}");
        assert_eq!(Layout::parse(" \n"), Err(LayoutError::NotSquare { cells: 0 }));
        assert_eq!(Layout::classic(0), Err(LayoutError::NotSquare { cells: 0 }));
    }

    #[test]
    fn huge_sizes_are_refused_before_anything_is_drawn() {
        for total_width in [65, 1 << 40, usize::MAX] {
            for layout in
                [Layout::classic(total_width), Layout::standard(total_width), Layout::circle(total_width)]
            {
                assert_eq!(layout, Err(LayoutError::TooWide { total_width }));
            }
        }
    }

    #[test]
    fn a_single_changed_cell_breaks_the_symmetry_and_is_named() {
        for layout in named() {
            let text = layout.text();
            for offset in 0..text.len() {
                let centre = text.len() % 2 == 1 && offset == text.len() / 2;
                let other = if &text[offset..=offset] == "x" { "d" } else { "x" };
                let mut changed = text.clone();
                changed.replace_range(offset..=offset, other);
                let at = [offset % layout.total_width(), offset / layout.total_width()];
                match Layout::parse(&changed) {
                    Err(LayoutError::NotSymmetric { cell, turned_cell, .. }) => {
                        assert!(cell == at || turned_cell == at, "{changed}");
                    }
                    other => assert!(centre, "{changed}: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn mirrored_halves_may_differ() {
        // Turned by 90 degrees it is the same, mirrored it is not: the x cells go round like a pinwheel.
        let pinwheel = "wwwwwwww wbbbbbbw wbxdddbw wbdddddw wbdddddw wbdddxbw wbbbbbbw wwwwwwww";
        assert!(matches!(Layout::parse(pinwheel), Err(LayoutError::NotSymmetric { .. })));
        let pinwheel = "wwwwwwww wbbbbbbw wbdxddbw wbdddxbw wbxdddbw wbddxdbw wbbbbbbw wwwwwwww";
        assert_eq!(Layout::parse(pinwheel).unwrap().bit_count(), 12);
    }

    #[test]
    fn layouts_without_a_closed_border_are_refused() {
        let no_rings = "d".repeat(64);
        // Every ring pair has gaps at the corners only, so that the sides alone would pass.
        let open_corners = "wwwwwwww wxbbbbxw wbwwwwbw wbwddwbw wbwddwbw wbwwwwbw wxbbbbxw wwwwwwww";
        let open_corners = open_corners.replacen("wbwwwwbw", "wbxwwxbw", 2);
        for letters in [no_rings, open_corners] {
            assert_eq!(Layout::parse(&letters), Err(LayoutError::NoBorder), "{letters}");
        }
    }

    #[test]
    fn too_few_and_too_many_bits_are_refused() {
        assert_eq!(Layout::classic(5), Err(LayoutError::TooFewBits { count: 1 }));
        assert_eq!(Layout::classic(13), Err(LayoutError::TooManyBits { count: 81 }));
        assert_eq!(Layout::classic(6).map(|layout| layout.bit_count()), Ok(4));
        assert_eq!(Layout::classic(4), Err(LayoutError::TooFewBits { count: 0 }));
        assert_eq!(Layout::classic(2), Err(LayoutError::NoBorder));
    }
}
