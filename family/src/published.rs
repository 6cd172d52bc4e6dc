//! The nine published AprilTag families: a recipe each, and the codes as embedded data.
//!
//! A data file holds the candidate numbers of the codes (see [`crate::candidates`]) as differences to the number
//! before, in the variable-length form of LEB128: seven bits a byte, lowest first, the high bit set on all but the
//! last. `cargo run --example pack` writes such files. The tests measure every code instead of trusting the table.

use crate::complexity::{Metric, Rule};
use crate::layout::Layout;
use crate::layout_error::LayoutError;
use crate::name::UnknownFamily;
use crate::recipe::{BitOrder, Recipe};

/// The names of the published families.
pub const NAMES: [&str; 9] = [
    "tag16h5",
    "tag25h9",
    "tag36h10",
    "tag36h11",
    "tagCircle21h7",
    "tagCircle49h12",
    "tagCustom48h12",
    "tagStandard41h12",
    "tagStandard52h13",
];

/// The cells of a published family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// [`Layout::classic`] of this total width.
    Classic(usize),
    /// [`Layout::standard`] of this total width.
    Standard(usize),
    /// [`Layout::circle`] of this total width.
    Circle(usize),
    /// [`Layout::parse`] of these letters.
    Letters(&'static str),
}

/// A published family: how it was made, and what came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Published {
    /// The family's name.
    pub name: &'static str,
    /// Its cells.
    pub shape: Shape,
    /// Bits in which any two codes differ at least, however they are turned.
    pub distance: u32,
    /// The complexity number that went into the seed; for [`BitOrder::Rows`] also the least number of rectangles.
    pub complexity: u32,
    /// The order of the candidates' bits.
    pub order: BitOrder,
    /// Number of codes. Some searches were stopped before the end, so it cannot be derived.
    pub count: usize,
    packed: &'static [u8],
}

/// The standard shape of ten cells with a hole of 2 x 2 cells, into which a smaller tag fits.
const CUSTOM_48: &str = "dddddddddd dbbbbbbbbd dbwwwwwwbd dbwddddwbd dbwdxxdwbd \
                         dbwdxxdwbd dbwddddwbd dbwwwwwwbd dbbbbbbbbd dddddddddd";

/// One for each of [`NAMES`], in the same order.
#[rustfmt::skip]
pub const FAMILIES: [Published; 9] = [
    classic(NAMES[0],  8,  5,  5,   30, include_bytes!("../data/tag16h5.bin")),
    classic(NAMES[1],  9,  9,  8,   35, include_bytes!("../data/tag25h9.bin")),
    classic(NAMES[2], 10, 10, 10, 2320, include_bytes!("../data/tag36h10.bin")),
    classic(NAMES[3], 10, 11, 10,  587, include_bytes!("../data/tag36h11.bin")),
    flexible(NAMES[4], Shape::Circle(9),           7, 10,     38, include_bytes!("../data/tagCircle21h7.bin")),
    flexible(NAMES[5], Shape::Circle(11),         12, 15, 65_698, include_bytes!("../data/tagCircle49h12.bin")),
    flexible(NAMES[6], Shape::Letters(CUSTOM_48), 12, 12, 42_211, include_bytes!("../data/tagCustom48h12.bin")),
    flexible(NAMES[7], Shape::Standard(9),        12, 10,  2_115, include_bytes!("../data/tagStandard41h12.bin")),
    flexible(NAMES[8], Shape::Standard(10),       13, 12, 48_714, include_bytes!("../data/tagStandard52h13.bin")),
];

const fn classic(
    name: &'static str,
    total_width: usize,
    distance: u32,
    complexity: u32,
    count: usize,
    packed: &'static [u8],
) -> Published {
    let shape = Shape::Classic(total_width);
    Published { name, shape, distance, complexity, order: BitOrder::Rows, count, packed }
}

const fn flexible(
    name: &'static str,
    shape: Shape,
    distance: u32,
    complexity: u32,
    count: usize,
    packed: &'static [u8],
) -> Published {
    Published { name, shape, distance, complexity, order: BitOrder::Quadrants, count, packed }
}

/// A published family. Takes the full name, the name without `tag`, or only its numbers (`41h12`),
/// in capitals or not.
///
/// # Errors
/// [`UnknownFamily`], which names the nearest published one.
pub fn named(name: &str) -> Result<&'static Published, UnknownFamily> {
    let wanted = name.to_lowercase();
    let is_wanted = |family: &&Published| spellings(family.name).contains(&wanted);
    FAMILIES.iter().find(is_wanted).ok_or_else(|| UnknownFamily::new(name, &NAMES))
}

fn spellings(name: &str) -> [String; 3] {
    let full = name.to_lowercase();
    let short = full.trim_start_matches("tag").to_owned();
    let numbers = short.trim_start_matches(|letter: char| !letter.is_ascii_digit()).to_owned();
    [full, short, numbers]
}

impl Published {
    /// The family's layout.
    ///
    /// # Errors
    /// [`LayoutError`], never for those of [`FAMILIES`].
    pub fn layout(&self) -> Result<Layout, LayoutError> {
        match self.shape {
            Shape::Classic(total_width) => Layout::classic(total_width),
            Shape::Standard(total_width) => Layout::standard(total_width),
            Shape::Circle(total_width) => Layout::circle(total_width),
            Shape::Letters(letters) => Layout::parse(letters),
        }
    }

    /// How the codes were searched.
    ///
    /// # Errors
    /// [`LayoutError`], never for those of [`FAMILIES`].
    pub fn recipe(&self) -> Result<Recipe, LayoutError> {
        let layout = self.layout()?;
        let rule = match self.order {
            BitOrder::Rows => Rule { metric: Metric::DataRectangles, least: self.complexity },
            BitOrder::Quadrants => {
                Rule { metric: Metric::Ising, least: Metric::Ising.default_least(&layout) }
            }
        };
        let recipe = Recipe::new(layout, self.distance, self.complexity, rule);
        Ok(recipe.expect("published distances exist, a test goes through all of them").with_order(self.order))
    }

    /// The numbers of the codes in the candidate sequence, in the order of their ids.
    pub fn numbers(&self) -> Vec<u64> {
        unpack(self.packed).collect()
    }
}

/// Numbers in the form of a data file, compact when each is a little larger than the one before.
/// [`crate::Family::published`] undoes it.
pub fn pack(numbers: &[u64]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut last = 0;
    for &number in numbers {
        let mut rest = number.wrapping_sub(last);
        while rest >= 0x80 {
            packed.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        packed.push(rest as u8);
        last = number;
    }
    packed
}

fn unpack(packed: &[u8]) -> impl Iterator<Item = u64> {
    let (mut number, mut difference, mut shift) = (0_u64, 0, 0);
    packed.iter().filter_map(move |&byte| {
        difference |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 != 0 {
            return None;
        }
        number = number.wrapping_add(difference);
        (difference, shift) = (0, 0);
        Some(number)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unpacking_gives_what_was_packed() {
        let mut numbers =
            vec![0, 1, 127, 128, 129, 255, 256, 16_383, 16_384, 1 << 35, (1 << 35) + 1, 1 << 62];
        assert_eq!(unpack(&pack(&numbers)).collect::<Vec<_>>(), numbers);
        numbers.reverse();
        assert_eq!(unpack(&pack(&numbers)).collect::<Vec<_>>(), numbers, "numbers that fall");
        assert_eq!(pack(&numbers[10..]), [1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1]);
    }

    #[test]
    fn families_stand_in_the_order_of_the_names() {
        for (family, name) in FAMILIES.iter().zip(NAMES) {
            assert_eq!(family.name, name);
        }
    }

    #[test]
    fn names_are_taken_with_or_without_prefix_and_in_any_case() {
        for spelling in ["tagStandard41h12", "TAGSTANDARD41H12", "standard41h12", "41h12"] {
            assert_eq!(named(spelling).map(|family| family.name), Ok("tagStandard41h12"), "{spelling}");
        }
        for spelling in ["tag36h11", "36h11", "36H11"] {
            assert_eq!(named(spelling).map(|family| family.name), Ok("tag36h11"), "{spelling}");
        }
        for spelling in ["", "tag", "h11", "36", "tagtag36h11 "] {
            assert!(named(spelling).is_err(), "{spelling}");
        }
    }

    #[test]
    fn a_tag_and_its_candidate_are_found_from_each_other() {
        for family in &FAMILIES {
            let recipe = family.recipe().unwrap();
            let candidates = recipe.candidates();
            for candidate in (1..1000).map(|k| candidates.code(k)) {
                let code = recipe.from_candidate(candidate);
                assert_eq!(recipe.to_candidate(code), candidate, "{}", family.name);
            }
        }
    }
}
