//! Whether look-up finds what comparing with every code in every rotation finds.

use indicatif::ProgressBar;
use tagbus_family::search::{Kernel, Level};
use tagbus_family::{Family, Found, Index};
use tagbus_scene::Stream;

use super::probe::either;
use crate::clock::cpu_us;

/// Probes between two steps of the bar.
const STEP: u64 = 1000;
/// Codes that are compared side by side: a vector of AVX-512.
const LANES: usize = 8;

/// What the comparison of one family came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Agreement {
    pub(super) probes: u64,
    /// Probes that lie within reach of a tag.
    pub(super) tags: u64,
    /// Probes of which look-up and comparison say the same: tag or not, id, wrong bits and rotation.
    pub(super) same: u64,
    /// CPU time of comparing, seconds.
    pub(super) cpu_s: f64,
}

impl Agreement {
    fn add(&mut self, expected: Option<Found>, found: Option<Found>) {
        self.probes += 1;
        self.tags += u64::from(expected.is_some());
        self.same += u64::from(found == expected);
    }
}

/// Compares so many probes of one family.
pub(super) fn measure(
    (family, index): &(Family, Index),
    probes: u64,
    seed: u64,
    bar: &ProgressBar,
) -> Agreement {
    let mut random = Stream::new(seed);
    let level = Level::best();
    let mut agreement = Agreement::default();
    for _ in 0..probes {
        let code = either(family, &mut random);
        let (us, nearest) = cpu_us(|| nearest(level, family, code));
        agreement.cpu_s += us * 1e-6;
        let expected = (nearest.hamming <= index.hamming()).then_some(nearest);
        agreement.add(expected, index.lookup(code));
        if agreement.probes.is_multiple_of(STEP) {
            bar.inc(STEP);
        }
    }
    agreement
}

/// The tag nearest to `code` over all rotations, however far; of several the one with the smallest id.
fn nearest(level: Level, family: &Family, code: u64) -> Found {
    let rotations = family.layout().rotations(code);
    let key = level.run(Nearest { codes: family.codes(), rotations });
    Found { hamming: (key >> HAMMING_AT) as u32, id: (key >> ID_AT) as u32, rotation: key as u32 & 0b11 }
}

/// Wrong bits, id and rotation in one number: the smallest is the best.
const HAMMING_AT: u32 = 34;
const ID_AT: u32 = 2;

/// Compares each code with all rotations, with no short cut: eight codes side by side, of which a compiler makes vectors.
struct Nearest<'a> {
    codes: &'a [u64],
    rotations: [u64; 4],
}

impl Kernel for Nearest<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let (groups, rest) = self.codes.as_chunks::<LANES>();
        let mut best = [u64::MAX; LANES];
        let mut ids: [u64; LANES] = std::array::from_fn(|lane| (lane as u64) << ID_AT);
        for group in groups {
            for (rotation, turned) in (0..).zip(self.rotations) {
                for lane in 0..LANES {
                    best[lane] = best[lane].min(key(group[lane], turned, ids[lane] | rotation));
                }
            }
            ids = ids.map(|id| id + ((LANES as u64) << ID_AT));
        }
        for (rotation, turned) in (0..).zip(self.rotations) {
            for (code, id) in rest.iter().zip(ids) {
                best[0] = best[0].min(key(*code, turned, id | rotation));
            }
        }
        best.into_iter().fold(u64::MAX, u64::min)
    }
}

#[inline(always)]
fn key(code: u64, turned: u64, id_and_rotation: u64) -> u64 {
    u64::from((code ^ turned).count_ones()) << HAMMING_AT | id_and_rotation
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same, written to be obviously right.
    fn plainly(family: &Family, code: u64) -> Found {
        let rotations = (0..).zip(family.layout().rotations(code));
        let all = rotations.flat_map(|(rotation, turned)| {
            let of =
                move |(id, tag): (u32, &u64)| Found { id, hamming: (tag ^ turned).count_ones(), rotation };
            (0..).zip(family.codes()).map(of)
        });
        all.min_by_key(|found| (found.hamming, found.id, found.rotation)).unwrap()
    }

    #[test]
    fn the_nearest_is_what_a_plain_comparison_finds_at_every_level() {
        for name in ["tag16h5", "tag25h9", "tag36h11", "tagStandard41h12"] {
            let family = Family::published(name).unwrap();
            let mut random = Stream::new(3);
            for _ in 0..200 {
                let code = either(&family, &mut random);
                for level in Level::available() {
                    assert_eq!(
                        nearest(level, &family, code),
                        plainly(&family, code),
                        "{name}, {level}, {code:#x}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_index_that_misses_tags_does_not_agree() {
        let family = Family::published("tag36h11").unwrap();
        let bar = ProgressBar::hidden();
        let whole = Index::new(&family, 3);
        let without_one = Index::for_ids(&family, 3, &Vec::from_iter(1..587));
        let good = measure(&(family.clone(), whole), 5000, 1, &bar);
        assert_eq!((good.probes, good.same), (5000, 5000));
        // Four of five tags that are probed lie within reach of three bits.
        assert!((1800..2200).contains(&good.tags), "{good:?}");
        let bad = measure(&(family, without_one), 5000, 1, &bar);
        assert!((4950..5000).contains(&bad.same), "{bad:?}");
    }
}
