//! The ArUco families, under the names that OpenCV gives them.
//!
//! The codes are facts out of the predefined dictionaries of OpenCV (Apache License 2.0, see the file `NOTICE`). A data
//! file holds them by id, each row after row from the top-left data cell with 1 for white, one directly after the
//! other and the most significant bit of a byte first. The sets of 50, 100 and 250 codes are the beginnings of those
//! of 1000. DICT_ARUCO_ORIGINAL is a formula. The tests measure every distance instead of trusting the table.

use crate::layout::Layout;
use crate::layout_error::LayoutError;

/// The names of the ArUco families.
pub const NAMES: [&str; 18] = [
    "DICT_4X4_50",
    "DICT_4X4_100",
    "DICT_4X4_250",
    "DICT_4X4_1000",
    "DICT_5X5_50",
    "DICT_5X5_100",
    "DICT_5X5_250",
    "DICT_5X5_1000",
    "DICT_6X6_50",
    "DICT_6X6_100",
    "DICT_6X6_250",
    "DICT_6X6_1000",
    "DICT_7X7_50",
    "DICT_7X7_100",
    "DICT_7X7_250",
    "DICT_7X7_1000",
    "DICT_ARUCO_MIP_36h12",
    "DICT_ARUCO_ORIGINAL",
];

const SQUARE_4: &[u8] = include_bytes!("../data/aruco4x4.bin");
const SQUARE_5: &[u8] = include_bytes!("../data/aruco5x5.bin");
const SQUARE_6: &[u8] = include_bytes!("../data/aruco6x6.bin");
const SQUARE_7: &[u8] = include_bytes!("../data/aruco7x7.bin");
const MIP: &[u8] = include_bytes!("../data/arucoMip36h12.bin");

/// An ArUco family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dictionary {
    /// The family's name.
    pub name: &'static str,
    /// Data cells along an edge; a white and a black ring surround them.
    pub data_width: usize,
    /// Number of codes.
    pub count: usize,
    /// Bits in which any two codes differ at least, however they are turned.
    pub distance: u32,
    source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Table(&'static [u8]),
    Original,
}

/// One for each of [`NAMES`], in the same order.
#[rustfmt::skip]
pub const DICTIONARIES: [Dictionary; 18] = [
    table(NAMES[ 0], 4,   50,  4, SQUARE_4),
    table(NAMES[ 1], 4,  100,  3, SQUARE_4),
    table(NAMES[ 2], 4,  250,  3, SQUARE_4),
    table(NAMES[ 3], 4, 1000,  2, SQUARE_4),
    table(NAMES[ 4], 5,   50,  8, SQUARE_5),
    table(NAMES[ 5], 5,  100,  7, SQUARE_5),
    table(NAMES[ 6], 5,  250,  6, SQUARE_5),
    table(NAMES[ 7], 5, 1000,  5, SQUARE_5),
    table(NAMES[ 8], 6,   50, 13, SQUARE_6),
    table(NAMES[ 9], 6,  100, 12, SQUARE_6),
    table(NAMES[10], 6,  250, 11, SQUARE_6),
    table(NAMES[11], 6, 1000,  9, SQUARE_6),
    table(NAMES[12], 7,   50, 19, SQUARE_7),
    table(NAMES[13], 7,  100, 18, SQUARE_7),
    table(NAMES[14], 7,  250, 17, SQUARE_7),
    table(NAMES[15], 7, 1000, 14, SQUARE_7),
    table(NAMES[16], 6,  250, 12, MIP),
    Dictionary { name: NAMES[17], data_width: 5, count: 1024, distance: 1, source: Source::Original },
];

const fn table(
    name: &'static str,
    data_width: usize,
    count: usize,
    distance: u32,
    packed: &'static [u8],
) -> Dictionary {
    Dictionary { name, data_width, count, distance, source: Source::Table(packed) }
}

/// An ArUco family by name, in capitals or not: `DICT_4X4_50`, `4x4_50`, `aruco4x4_50`; `DICT_ARUCO_MIP_36h12`,
/// `mip_36h12`.
pub fn named(name: &str) -> Option<&'static Dictionary> {
    let wanted = short(name);
    DICTIONARIES.iter().find(|dictionary| short(dictionary.name) == wanted)
}

/// What is left of a name without the words that all share.
fn short(name: &str) -> String {
    let name = name.to_lowercase();
    let name = name.strip_prefix("dict_").unwrap_or(&name);
    name.strip_prefix("aruco").map_or(name, |rest| rest.strip_prefix('_').unwrap_or(rest)).to_owned()
}

/// The name that our family has which OpenCV calls `DICT_APRILTAG_36h11` and the like: `36h11`.
pub(crate) fn apriltag(name: &str) -> Option<String> {
    let name = name.to_lowercase();
    let name = name.strip_prefix("dict_").unwrap_or(&name);
    name.strip_prefix("apriltag_").map(str::to_owned)
}

impl Dictionary {
    /// The family's layout: [`Layout::classic`].
    ///
    /// # Errors
    /// [`LayoutError`], never for those of [`DICTIONARIES`].
    pub fn layout(&self) -> Result<Layout, LayoutError> {
        Layout::classic(self.data_width + 4)
    }

    /// The codes by id, with their bits row after row from the top-left data cell, as OpenCV has them.
    /// [`Layout::from_row_major`] makes the codes of [`crate::Family`] of them.
    pub fn rows(&self) -> Vec<u64> {
        let bit_count = self.data_width * self.data_width;
        match self.source {
            Source::Table(packed) => (0..self.count).map(|id| unpack(packed, id, bit_count)).collect(),
            Source::Original => (0..self.count as u64).map(original).collect(),
        }
    }
}

/// Bits `bit_count * id..bit_count * (id + 1)` of a data file.
fn unpack(packed: &[u8], id: usize, bit_count: usize) -> u64 {
    let bit = |place: usize| u64::from(packed[place / 8] >> (7 - place % 8) & 1);
    (id * bit_count..(id + 1) * bit_count).fold(0, |code, place| code << 1 | bit(place))
}

/// The first ArUco tags: two bits of the id a row, the most significant ones at the top.
fn original(id: u64) -> u64 {
    const ROWS: [u64; 4] = [0b10000, 0b10111, 0b01001, 0b01110];
    (0..5).fold(0, |code, row| code << 5 | ROWS[(id >> (8 - 2 * row) & 0b11) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Family, Index, Paint};

    /// A tag as text, `#` for black.
    fn drawn(name: &str, id: u32) -> Vec<String> {
        let letter = |paint: &Paint| if *paint == Paint::Black { '#' } else { '.' };
        let grid = Family::published(name).unwrap().grid(id).unwrap();
        grid.rows().map(|row| row.iter().map(letter).collect()).collect()
    }

    #[test]
    fn tags_look_as_opencv_draws_them() {
        let first =
            ["........", ".######.", ".#.#..#.", ".##.#.#.", ".###..#.", ".###.##.", ".######.", "........"];
        for name in ["DICT_4X4_50", "DICT_4X4_1000"] {
            assert_eq!(drawn(name, 0), first, "{name}");
        }
        let inside =
            |name, id| drawn(name, id)[2..].iter().map(|row| row[2..].to_owned()).collect::<Vec<_>>();
        assert_eq!(
            inside("DICT_ARUCO_ORIGINAL", 6)[..5],
            [".####", ".####", ".####", ".#...", "#.##."].map(|row| row.to_owned() + "#.")
        );
        assert_eq!(inside("DICT_ARUCO_ORIGINAL", 6).len(), 7);
    }

    #[test]
    fn codes_row_by_row_are_those_of_opencv() {
        for (name, id, rows) in [
            ("DICT_4X4_50", 7, 0b1100_0100_1111_0010),
            ("DICT_5X5_50", 0, 0b10100_01011_01100_10101_11100),
            ("DICT_6X6_250", 1, 0b000011_101111_101110_100011_100010_010001),
            ("DICT_7X7_1000", 0, 0b1101110_1010111_0001101_1001010_0101110_0101000_0010101),
            ("DICT_ARUCO_MIP_36h12", 2, 0b000100_100000_011011_111011_111001_110010),
        ] {
            assert_eq!(named(name).unwrap().rows()[id], rows, "{name} {id}");
        }
    }

    #[test]
    fn distances_are_what_all_pairs_of_codes_have() {
        for name in NAMES {
            let family = Family::published(name).unwrap();
            let measured = family.minimum_distance();
            let between = measured.between_codes.unwrap();
            // One tag of the original ones looks the same after half a turn, see below.
            let least = if name == "DICT_ARUCO_ORIGINAL" { between } else { measured.overall() };
            assert_eq!(family.distance(), least, "{name}");
        }
    }

    #[test]
    fn the_original_tags_that_hardly_change_when_they_are_turned_are_these() {
        let family = Family::published("DICT_ARUCO_ORIGINAL").unwrap();
        let own = |code: u64| {
            let turns = std::iter::successors(Some(code), |&code| Some(family.layout().rotate90(code)));
            turns.skip(1).take(3).map(|turned| (turned ^ code).count_ones()).min().unwrap()
        };
        let with = |distance| (0..1024).filter(|&id| own(family.codes()[id]) == distance).collect::<Vec<_>>();
        assert_eq!(with(0), [1023]);
        assert_eq!((with(1).len(), with(2).len()), (0, 7), "{:?}", with(2));
    }

    #[test]
    fn wrong_bits_are_corrected_as_far_as_the_distance_bears() {
        let most = |name| Index::new(&Family::published(name).unwrap(), 9).hamming();
        assert_eq!(NAMES.map(most), [1, 1, 1, 0, 3, 3, 2, 2, 6, 5, 5, 4, 9, 8, 8, 6, 5, 0],);
    }

    #[test]
    fn small_sets_are_the_beginnings_of_large_ones() {
        for width in 4..=7 {
            let all = named(&format!("{width}x{width}_1000")).unwrap().rows();
            for count in [50, 100, 250] {
                let some = named(&format!("{width}x{width}_{count}")).unwrap();
                assert_eq!(some.rows(), all[..count]);
                assert_eq!((some.data_width, some.count), (width, count));
            }
        }
    }

    #[test]
    fn names_are_taken_in_any_of_their_spellings() {
        let name = |spelling| Family::published(spelling).map(|family| family.name().to_owned()).ok();
        for spelling in ["DICT_4X4_50", "dict_4x4_50", "4x4_50", "4X4_50", "aruco4x4_50", "ARUCO_4X4_50"] {
            assert_eq!(name(spelling).as_deref(), Some("DICT_4X4_50"), "{spelling}");
        }
        for spelling in ["DICT_ARUCO_MIP_36h12", "DICT_ARUCO_MIP_36H12", "aruco_mip_36h12", "mip_36h12"] {
            assert_eq!(name(spelling).as_deref(), Some("DICT_ARUCO_MIP_36h12"), "{spelling}");
        }
        for spelling in ["DICT_ARUCO_ORIGINAL", "aruco_original"] {
            assert_eq!(name(spelling).as_deref(), Some("DICT_ARUCO_ORIGINAL"), "{spelling}");
        }
        for spelling in ["DICT_APRILTAG_36h11", "DICT_APRILTAG_36H11", "apriltag_36h11"] {
            assert_eq!(name(spelling).as_deref(), Some("tag36h11"), "{spelling}");
        }
        for spelling in ["4x4", "4x4_51", "DICT_", "aruco", "dict_36h11", "36h12"] {
            assert_eq!(name(spelling), None, "{spelling}");
        }
    }
}
