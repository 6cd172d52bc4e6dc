//! Families: a layout and the codes that are tags.

use crate::aruco::{self, Dictionary};
use crate::grid::Grid;
use crate::kalibr;
use crate::layout::Layout;
use crate::name::UnknownFamily;
use crate::published::{self, Published};
use crate::search::{Level, least_bits};
use std::fmt;

/// A layout with a list of codes; the place of a code in the list is the tag's id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    name: String,
    layout: Layout,
    codes: Vec<u64>,
    distance: u32,
}

impl Family {
    /// The names of the nine published AprilTag families.
    pub const PUBLISHED: [&'static str; 9] = published::NAMES;

    /// The names of the published families of others: ArUco as OpenCV calls them, and the tags of Kalibr's Aprilgrid.
    pub const OTHERS: [&'static str; 19] = crate::name::others();

    /// A published family by name: `tag36h11`, `36h11` or `TAG36H11`; `DICT_4X4_50`, `4x4_50` or `aruco4x4_50`;
    /// `kalibr36h11`. OpenCV's names of AprilTag families are taken too (`DICT_APRILTAG_36h11` is tag36h11; tags that
    /// OpenCV draws are turned by half a turn).
    ///
    /// tagCircle49h12 has all 65,698 codes; the AprilTag C library stops before id 65,535. DICT_ARUCO_ORIGINAL has a
    /// distance of 1, and its tag 1023 looks the same after half a turn: its id is right, but its corners may begin
    /// with either of two.
    ///
    /// # Errors
    /// [`UnknownFamily`], which names the nearest known one.
    pub fn published(name: &str) -> Result<Family, UnknownFamily> {
        let apriltag = aruco::apriltag(name);
        if let Ok(published) = published::named(apriltag.as_deref().unwrap_or(name)) {
            return Ok(Family::of_apriltag(published));
        }
        if let Some(dictionary) = aruco::named(name) {
            return Ok(Family::of_aruco(dictionary));
        }
        if name.eq_ignore_ascii_case(kalibr::NAME) {
            return Ok(Family::of_kalibr());
        }
        Err(UnknownFamily::new(name, &crate::name::KNOWN))
    }

    fn of_apriltag(published: &Published) -> Family {
        let recipe = published.recipe().expect("their layouts are valid, a test goes through all of them");
        let codes = recipe.codes(&published.numbers());
        let (name, distance) = (published.name.to_owned(), published.distance);
        Family { name, layout: recipe.layout().clone(), codes, distance }
    }

    fn of_aruco(dictionary: &Dictionary) -> Family {
        let layout = dictionary.layout().expect("their layouts are valid, a test goes through all of them");
        let codes = dictionary.rows().into_iter().map(|rows| layout.from_row_major(rows)).collect();
        Family { name: dictionary.name.to_owned(), layout, codes, distance: dictionary.distance }
    }

    fn of_kalibr() -> Family {
        let layout = kalibr::layout().expect("the layout is valid, a test makes it");
        let same_codes = published::named("tag36h11").expect("one of the nine");
        Family { name: kalibr::NAME.to_owned(), layout, ..Family::of_apriltag(same_codes) }
    }

    /// A family of one's own. `distance` is the number of bits in which any two codes differ at least, however they
    /// are turned. It is believed here, because measuring takes a second for 50,000 codes:
    /// [`Family::minimum_distance`] does that.
    ///
    /// # Errors
    /// [`FamilyError`] when there are no codes, a code does not fit the layout, two codes are the same tag, or the
    /// distance is impossible.
    pub fn new(name: &str, layout: Layout, codes: Vec<u64>, distance: u32) -> Result<Family, FamilyError> {
        let bit_count = layout.bit_count();
        if codes.is_empty() {
            return Err(FamilyError::NoCodes);
        }
        if distance == 0 || distance > bit_count {
            return Err(FamilyError::Distance { distance, bit_count });
        }
        check_width(&codes, bit_count)?;
        check_distinct(&codes, &layout)?;
        Ok(Family { name: name.to_owned(), layout, codes, distance })
    }

    /// The family's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What each cell is.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The codes by id, each with its most significant bit at the place of the first of [`Layout::bits`].
    pub fn codes(&self) -> &[u64] {
        &self.codes
    }

    /// Bits in which any two codes differ at least, however they are turned.
    pub fn distance(&self) -> u32 {
        self.distance
    }

    /// Wrong bits that are worth correcting when nobody says otherwise, at most `(distance - 1) / 2`.
    ///
    /// In general 2. Where a few wrong bits would make a tag of too large a share of all codes that background
    /// yields, fewer: 0 for families of up to 16 bits (tag16h5), 1 for those of more than 10,000 codes and for
    /// distances up to 7 (tagCircle21h7).
    pub fn default_hamming(&self) -> u32 {
        let wanted = if self.layout.bit_count() <= 16 {
            0
        } else if self.codes.len() > 10_000 || self.distance <= 7 {
            1
        } else {
            2
        };
        self.correctable().min(wanted)
    }

    /// The most wrong bits that can be corrected with a unique answer: `(distance - 1) / 2`.
    pub fn correctable(&self) -> u32 {
        (self.distance - 1) / 2
    }

    /// The chance that a quad of random bits is taken for a tag when `hamming` wrong bits are corrected, in any of the
    /// four rotations: 4 N (C(n, 0) + ... + C(n, hamming)) / 2^n for N codes of n bits, at most 1.
    ///
    /// Background is not random and is taken for complex tags less often than this.
    pub fn false_accept_chance(&self, hamming: u32) -> f64 {
        let bits = self.layout.bit_count();
        let mut ways = 1.0;
        let mut sum = 0.0;
        for wrong in 0..=hamming.min(bits) {
            sum += ways;
            ways *= f64::from(bits - wrong) / f64::from(wrong + 1);
        }
        (4.0 * self.codes.len() as f64 * sum / 2f64.powi(bits as i32)).min(1.0)
    }

    /// The tag `id`, cell by cell; `None` when the family has no such tag.
    pub fn grid(&self, id: u32) -> Option<Grid> {
        self.codes.get(id as usize).map(|&code| self.layout.draw(code))
    }

    /// Measures how far the codes are really apart, going through all pairs: a second for 50,000 codes.
    pub fn minimum_distance(&self) -> MinimumDistance {
        let level = Level::best();
        let rotated: Vec<[u64; 4]> = self.codes.iter().map(|&code| self.layout.rotations(code)).collect();
        let own = rotated
            .iter()
            .flat_map(|[code, turns @ ..]| turns.iter().map(move |turned| bits_apart(*code, *turned)));
        MinimumDistance {
            own_rotations: own.min().unwrap_or(0),
            between_codes: (1..self.codes.len())
                .filter_map(|id| least_bits(level, rotated[id], &self.codes[..id]))
                .min(),
        }
    }
}

/// How far the codes of a family are apart, in bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MinimumDistance {
    /// Between two codes, the one turned in any of four ways; `None` for a family of one code.
    pub between_codes: Option<u32>,
    /// Between a code and itself turned by 90, 180 or 270 degrees.
    pub own_rotations: u32,
}

impl MinimumDistance {
    /// The smaller of the two: the distance that the family really has.
    pub fn overall(&self) -> u32 {
        self.between_codes.map_or(self.own_rotations, |between| between.min(self.own_rotations))
    }
}

fn bits_apart(left: u64, right: u64) -> u32 {
    (left ^ right).count_ones()
}

fn check_width(codes: &[u64], bit_count: u32) -> Result<(), FamilyError> {
    let widest = u64::MAX >> (64 - bit_count);
    match codes.iter().position(|&code| code > widest) {
        Some(id) => Err(FamilyError::CodeTooWide { id, code: codes[id], bit_count }),
        None => Ok(()),
    }
}

/// Two codes that turn into each other are one tag, so the smallest of the four rotations stands for all.
fn check_distinct(codes: &[u64], layout: &Layout) -> Result<(), FamilyError> {
    let smallest = |&code: &u64| layout.rotations(code).into_iter().fold(u64::MAX, u64::min);
    let mut tags: Vec<(u64, usize)> = codes.iter().map(smallest).zip(0..).collect();
    tags.sort_unstable();
    match tags.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => {
            let (first, second) = (pair[0].1, pair[1].1);
            Err(FamilyError::SameTag { first, second, code: codes[second] })
        }
        None => Ok(()),
    }
}

/// Why codes and a layout make no family.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FamilyError {
    /// The list of codes is empty.
    NoCodes,
    /// A code has bits that the layout has no cells for.
    CodeTooWide {
        /// Its place in the list.
        id: usize,
        /// The code.
        code: u64,
        /// Data cells of the layout.
        bit_count: u32,
    },
    /// Two codes are the same tag, perhaps turned.
    SameTag {
        /// The place of the first in the list.
        first: usize,
        /// The place of the second.
        second: usize,
        /// The second code.
        code: u64,
    },
    /// The minimum distance is 0 or larger than the number of bits.
    Distance {
        /// The distance that was given.
        distance: u32,
        /// Data cells of the layout.
        bit_count: u32,
    },
}

impl fmt::Display for FamilyError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FamilyError::NoCodes => write!(out, "the family has no codes, give at least one"),
            FamilyError::CodeTooWide { id, code, bit_count } => write!(
                out,
                "code {id} is {code:#x}, but the layout has only {bit_count} data cells; check the layout and the \
                 order of the bits"
            ),
            FamilyError::SameTag { first, second, code } => {
                write!(
                    out,
                    "code {second} ({code:#x}) is the same tag as code {first}, perhaps turned; drop one of them"
                )
            }
            FamilyError::Distance { distance, bit_count } => {
                write!(
                    out,
                    "the minimum distance is {distance}, but it must be from 1 to the {bit_count} bits of a code"
                )
            }
        }
    }
}

impl std::error::Error for FamilyError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Paint;

    fn small(codes: Vec<u64>, distance: u32) -> Result<Family, FamilyError> {
        Family::new("small", Layout::classic(8).unwrap(), codes, distance)
    }

    #[test]
    fn a_family_of_ones_own_keeps_what_it_was_given() {
        let family = small(vec![0x27c8, 0x31b6], 5).unwrap();
        assert_eq!(
            (family.name(), family.codes(), family.distance()),
            ("small", [0x27c8, 0x31b6].as_slice(), 5)
        );
        assert_eq!(family.layout(), &Layout::classic(8).unwrap());
    }

    #[test]
    fn impossible_families_are_refused_with_the_reason() {
        let refused = |codes, distance| small(codes, distance).unwrap_err();
        assert_eq!(refused(vec![], 5), FamilyError::NoCodes);
        assert_eq!(
            refused(vec![1, 0x1_0000], 1),
            FamilyError::CodeTooWide { id: 1, code: 0x1_0000, bit_count: 16 }
        );
        assert_eq!(refused(vec![1, 2, 1], 1), FamilyError::SameTag { first: 0, second: 2, code: 1 });
        assert_eq!(refused(vec![1], 0), FamilyError::Distance { distance: 0, bit_count: 16 });
        assert_eq!(refused(vec![1], 17), FamilyError::Distance { distance: 17, bit_count: 16 });
        let message = refused(vec![7, 0x1_0000], 1).to_string();
        assert!(message.contains("code 1 is 0x10000") && message.contains("16 data cells"), "{message}");
    }

    #[test]
    fn a_turned_tag_is_the_same_tag() {
        let turned = Layout::classic(8).unwrap().rotate90(0x27c8);
        assert_eq!(
            small(vec![0x27c8, turned], 1),
            Err(FamilyError::SameTag { first: 0, second: 1, code: turned })
        );
    }

    #[test]
    fn distances_are_measured_over_all_rotations() {
        let family = Family::published("tag16h5").unwrap();
        let turned_and_one_off = family.layout().rotate90(family.codes()[3]) ^ 1;
        let mut codes = family.codes().to_vec();
        codes.push(turned_and_one_off);
        let stretched = Family::new("stretched", family.layout().clone(), codes, 5).unwrap();
        assert_eq!(family.minimum_distance().overall(), 5);
        assert_eq!(stretched.minimum_distance().between_codes, Some(1));
        assert_eq!(small(vec![0x27c8], 5).unwrap().minimum_distance().between_codes, None);
        assert_eq!(small(vec![0xffff], 5).unwrap().minimum_distance().overall(), 0);
    }

    #[test]
    fn false_accepts_are_those_that_all_codes_give() {
        let family = Family::published("tag16h5").unwrap();
        for hamming in 0..=2 {
            let index = crate::Index::new(&family, hamming);
            let accepted = (0..1 << 16).filter(|&code| index.lookup(code).is_some()).count();
            let expected = family.false_accept_chance(hamming) * 65_536.0;
            assert!((accepted as f64 - expected).abs() < 0.5, "{hamming} bits: {accepted}, not {expected}");
        }
        assert_eq!(family.false_accept_chance(16), 1.0);
    }

    #[test]
    fn default_corrections_are_fewer_where_chance_finds_are_likely() {
        let bits = |name| Family::published(name).unwrap().default_hamming();
        assert_eq!(Family::PUBLISHED.map(bits), [0, 2, 2, 2, 1, 1, 1, 2, 1]);
        assert_eq!(
            Family::new("d", Layout::classic(10).unwrap(), vec![5, 6], 2).unwrap().default_hamming(),
            0
        );
    }

    #[test]
    fn a_tag_is_drawn_for_each_id_and_for_no_other() {
        let family = Family::published("tag25h9").unwrap();
        assert_eq!(family.grid(34), Some(family.layout().draw(family.codes()[34])));
        assert_eq!(family.grid(35), None);
        assert_eq!(family.grid(u32::MAX), None);
    }

    #[test]
    fn tag36h11_id_0_looks_as_in_the_first_page_of_the_documentation() {
        let documentation = include_str!("lib.rs");
        let grid = Family::published("tag36h11").unwrap().grid(0).unwrap();
        for row in grid.rows() {
            let drawn: String =
                row.iter().map(|paint| if *paint == Paint::Black { "##" } else { " ." }).collect();
            assert!(documentation.contains(&format!("//!    {drawn}")), "{drawn}");
        }
    }
}
