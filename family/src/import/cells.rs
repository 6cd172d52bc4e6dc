//! A layout out of the places of its bits, which is all that C tables have.

use super::error::{ImportError, Problem};
use crate::layout::Layout;
use crate::square::{Border, Cell};
use crate::{aruco, kalibr, published};

/// What a table says about the cells.
pub(super) struct Places {
    pub total_width: usize,
    pub width_at_border: usize,
    pub border: Border,
    /// Column and row of each bit, counted from the first cell inside the border edge; most significant bit first.
    pub bits: Vec<[i64; 2]>,
    /// The line that the layout as a whole is blamed on.
    pub line: usize,
}

/// A layout, and how many of its cells the table says nothing about.
pub(super) struct Cells {
    pub layout: Layout,
    pub guessed: usize,
}

impl Places {
    /// The layout: the known one with the same bits and border, if there is one.
    pub(super) fn cells(&self) -> Result<Cells, ImportError> {
        let letters = self.letters()?;
        if let Some(layout) = known_layouts().find(|layout| self.describes(layout)) {
            return Ok(Cells { layout, guessed: 0 });
        }
        let guessed = letters.iter().filter(|&&letter| letter == UNKNOWN).count();
        let text: String = self.guess(letters).into_iter().collect();
        let layout = Layout::parse(&text).map_err(|error| Problem::Layout(error).at(self.line))?;
        Ok(Cells { layout, guessed })
    }

    fn margin(&self) -> usize {
        (self.total_width - self.width_at_border) / 2
    }

    /// Cells outside the border edge and inside it.
    fn border_letters(&self) -> [char; 2] {
        match self.border {
            Border::Normal => ['w', 'b'],
            Border::Reversed => ['b', 'w'],
        }
    }

    /// The ring of a cell: 0 is the outermost.
    fn ring(&self, x: usize, y: usize) -> usize {
        let last = self.total_width - 1;
        x.min(y).min(last - x).min(last - y)
    }

    /// What the table tells: the two rings of the border and the bits.
    fn letters(&self) -> Result<Vec<char>, ImportError> {
        let width = self.total_width;
        let [outside, inside] = self.border_letters();
        let mut letters = vec![UNKNOWN; width * width];
        for (place, letter) in letters.iter_mut().enumerate() {
            match self.ring(place % width, place / width) + 1 {
                ring if ring == self.margin() => *letter = outside,
                ring if ring == self.margin() + 1 => *letter = inside,
                _ => {}
            }
        }
        for (bit, &at) in self.bits.iter().enumerate() {
            let refuse = |why| Problem::BitPlace { bit, at, why }.at(self.line);
            let place = self.print_place(at).ok_or_else(|| refuse("outside of the tag"))?;
            match letters[place] {
                UNKNOWN => letters[place] = 'd',
                'd' => return Err(refuse("where another bit lies")),
                _ => return Err(refuse("on the border")),
            }
        }
        Ok(letters)
    }

    fn print_place(&self, [x, y]: [i64; 2]) -> Option<usize> {
        let in_print = |at: i64| {
            let at = usize::try_from(at.checked_add(self.margin() as i64)?).ok()?;
            (at < self.total_width).then_some(at)
        };
        Some(in_print(y)? * self.total_width + in_print(x)?)
    }

    fn describes(&self, layout: &Layout) -> bool {
        let is_data = |&[x, y]: &[i64; 2]| layout.cell(x as i32, y as i32) == Cell::Data;
        let sizes = (layout.total_width(), layout.width_at_border(), layout.border());
        // As many bits, all of which are data: bits that lie in the same place twice were refused before.
        sizes == (self.total_width, self.width_at_border, self.border)
            && layout.bit_count() as usize == self.bits.len()
            && self.bits.iter().all(is_data)
    }

    /// Rings without bits that follow the border inwards have its colour; anything else is no part of the tag.
    fn guess(&self, mut letters: Vec<char>) -> Vec<char> {
        let width = self.total_width;
        let [_, inside] = self.border_letters();
        let ring_of = |place: usize| self.ring(place % width, place / width);
        let is_free = |ring: &usize| {
            (0..width * width).filter(|&place| ring_of(place) == *ring).all(|place| letters[place] == UNKNOWN)
        };
        let thick = (self.margin() + 1..width.div_ceil(2)).take_while(is_free).last();
        // Free rings all the way to the middle are a hole rather than a border.
        let thick = thick.filter(|ring| ring + 1 < width.div_ceil(2)).unwrap_or(0);
        for (place, letter) in letters.iter_mut().enumerate().filter(|(_, letter)| **letter == UNKNOWN) {
            let continues_border = (self.margin() + 1..=thick).contains(&ring_of(place));
            *letter = if continues_border { inside } else { 'x' };
        }
        letters
    }
}

/// A cell about which a table says nothing.
const UNKNOWN: char = '?';

fn known_layouts() -> impl Iterator<Item = Layout> {
    let published = published::FAMILIES.iter().flat_map(published::Published::layout);
    let aruco = aruco::DICTIONARIES.iter().flat_map(aruco::Dictionary::layout);
    published.chain(aruco).chain(kalibr::layout())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(layout: &Layout) -> Places {
        Places {
            total_width: layout.total_width(),
            width_at_border: layout.width_at_border(),
            border: layout.border(),
            bits: layout.bits().iter().map(|at| at.map(i64::from)).collect(),
            line: 7,
        }
    }

    #[test]
    fn known_layouts_are_recognised_by_their_bits_in_any_order() {
        for layout in known_layouts() {
            let mut places = places(&layout);
            places.bits.reverse();
            let cells = places.cells().unwrap();
            assert_eq!((cells.layout, cells.guessed), (layout, 0));
        }
    }

    #[test]
    fn cells_that_the_table_says_nothing_about_continue_the_border_or_are_no_part_of_the_tag() {
        for (letters, expected, guessed) in [
            // A border of two cells.
            ("wwwwwwww wbbbbbbw wbbbbbbw wbbddbbw wbbddbbw wbbbbbbw wbbbbbbw wwwwwwww", None, 12),
            // A hole.
            ("wwwwwwww wbbbbbbw wbddddbw wbdxxdbw wbdxxdbw wbddddbw wbbbbbbw wwwwwwww", None, 4),
            // A second white ring outside cannot be told from paper.
            (
                "wwwwwwww wwwwwwww wwbbbbww wwbddbww wwbddbww wwbbbbww wwwwwwww wwwwwwww",
                Some("xxxxxxxx xwwwwwwx xwbbbbwx xwbddbwx xwbddbwx xwbbbbwx xwwwwwwx xxxxxxxx"),
                28,
            ),
        ] {
            let layout = Layout::parse(letters).unwrap();
            let cells = places(&layout).cells().unwrap();
            assert_eq!(cells.layout, Layout::parse(expected.unwrap_or(letters)).unwrap());
            assert_eq!(cells.guessed, guessed, "{letters}");
        }
    }

    #[test]
    fn bits_that_lie_where_none_can_are_refused() {
        let refused = |change: fn(&mut Places)| {
            let mut places = places(&Layout::classic(8).unwrap());
            change(&mut places);
            places.cells().err().unwrap()
        };
        let place = |bit, at, why| Problem::BitPlace { bit, at, why }.at(7);
        assert_eq!(refused(|it| it.bits[3] = it.bits[2]), place(3, [3, 1], "where another bit lies"));
        assert_eq!(refused(|it| it.bits[0] = [0, 3]), place(0, [0, 3], "on the border"));
        assert_eq!(refused(|it| it.bits[15] = [-1, 3]), place(15, [-1, 3], "on the border"));
        assert_eq!(refused(|it| it.bits[1] = [3, 7]), place(1, [3, 7], "outside of the tag"));
        assert_eq!(refused(|it| it.bits[1] = [3, i64::MAX]), place(1, [3, i64::MAX], "outside of the tag"));
        let asymmetric = refused(|it| it.bits.truncate(15));
        assert!(matches!(asymmetric.problem, Problem::Layout(_)), "{asymmetric}");
    }
}
