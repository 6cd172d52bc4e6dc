//! Families that are not ours: their tags are drawn, read with wrong bits in any rotation, and recognised.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use tagbus_family::{Family, Found, Grid, Index, Layout, Paint};

/// Splitmix64: enough to spread test cases.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % end
    }

    fn distinct_bits(&mut self, count: u32, bit_count: u32) -> u64 {
        let mut bits = 0_u64;
        while bits.count_ones() < count {
            bits |= 1 << self.below(u64::from(bit_count));
        }
        bits
    }
}

/// What a perfect camera reads from a drawn tag.
fn read(layout: &Layout, grid: &Grid) -> u64 {
    let white = |[x, y]: [i32; 2]| {
        let [x, y] = [x, y].map(|at| (at + layout.margin() as i32) as usize);
        u64::from(grid.get(x, y) == Paint::White)
    };
    layout.bits().iter().fold(0, |code, &at| code << 1 | white(at))
}

#[test]
fn drawn_tags_are_recognised_with_as_many_wrong_bits_as_the_family_bears() {
    for (seed, name) in (1..).zip(Family::OTHERS) {
        let mut random = Random(seed);
        let family = Family::published(name).unwrap();
        let (layout, index) = (family.layout(), Index::new(&family, 64));
        assert_eq!(index.hamming(), (family.distance() - 1) / 2, "{name}");
        for _ in 0..20 {
            // The tag that looks the same after half a turn is the last of its family, and not drawn here.
            let id = random.below(family.codes().len().min(1023) as u64) as u32;
            let rotation = random.below(4) as u32;
            let code = read(layout, &family.grid(id).unwrap());
            let turned = (rotation..4).fold(code, |code, _| layout.rotate90(code));
            let wrong = random.distinct_bits(index.hamming(), layout.bit_count());
            let found = Found { id, hamming: index.hamming(), rotation };
            assert_eq!(index.lookup(turned ^ wrong), Some(found), "{name} {id}, seed {seed}");
        }
    }
}

#[test]
fn the_original_tag_that_looks_the_same_after_half_a_turn_is_recognised_all_the_same() {
    let family = Family::published("DICT_ARUCO_ORIGINAL").unwrap();
    let index = Index::new(&family, 0);
    let found = index.lookup(family.codes()[1023]).unwrap();
    assert_eq!((found.id, found.hamming, found.rotation), (1023, 0, 0));
}
