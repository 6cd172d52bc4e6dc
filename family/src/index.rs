//! From a code that was read in a picture to the nearest tag.
//!
//! A code with at most k wrong bits, cut into k + 1 chunks, has at least one chunk without any. So for each chunk
//! all codes are sorted into buckets by (the low bits of) that chunk, and a look-up visits one bucket a chunk. Most
//! look-ups are of background that is no tag at all: of each code a bucket keeps 32 other bits, so that wrong codes are
//! dropped, several at a time, without a jump to the table of codes.

use crate::family::Family;
use crate::layout::rotate90;
use std::mem::size_of;

/// Up to this many codes it is quicker to compare with every one.
const SCAN_AT_MOST: usize = 64;
/// 2^16 offsets a chunk, 256 KiB: more would push the buckets out of the caches of a small board.
const MAX_KEY_BITS: u32 = 16;
/// Fingerprints that are compared at a time: a vector of 128 bits.
const BLOCK: usize = 4;

/// A code recognised as a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// The tag's id.
    pub id: u32,
    /// Wrong bits in the code that was read.
    pub hamming: u32,
    /// How often the code that was read must be turned by [`crate::Layout::rotate90`] to give the tag's code, 0 to 3.
    pub rotation: u32,
}

impl Found {
    /// Fewer wrong bits win; the rest only makes the answer independent of the way in which it was searched.
    fn rank(&self) -> (u32, u32, u32) {
        (self.hamming, self.id, self.rotation)
    }
}

/// The tags of a family, or some of them, arranged for quick look-up. A few megabytes for 65,000 codes.
#[derive(Clone, Debug)]
pub struct Index {
    bit_count: u32,
    hamming: u32,
    codes: Vec<u64>,
    /// Parallel to `codes`.
    ids: Vec<u32>,
    /// Empty when there are so few codes that all are compared.
    chunks: Vec<Chunk>,
}

impl Index {
    /// An index of all codes that corrects up to `hamming` wrong bits, at most `(distance - 1) / 2`: beyond that the
    /// nearest code need not be the right one.
    pub fn new(family: &Family, hamming: u32) -> Index {
        Index::build(family, hamming, (0..family.codes().len() as u32).collect())
    }

    /// As [`Index::new`], but only the `allowed` ids are ever found. Ids that the family does not have are skipped.
    ///
    /// Fewer codes mean fewer false detections, in proportion.
    pub fn for_ids(family: &Family, hamming: u32, allowed: &[u32]) -> Index {
        let known = |id: &u32| (*id as usize) < family.codes().len();
        let mut ids: Vec<u32> = allowed.iter().copied().filter(known).collect();
        ids.sort_unstable();
        ids.dedup();
        Index::build(family, hamming, ids)
    }

    fn build(family: &Family, hamming: u32, ids: Vec<u32>) -> Index {
        let bit_count = family.layout().bit_count();
        let hamming = hamming.min(family.correctable());
        let codes: Vec<u64> = ids.iter().map(|&id| family.codes()[id as usize]).collect();
        let chunk_count = if codes.len() <= SCAN_AT_MOST { 0 } else { hamming + 1 };
        let chunk = |number| Chunk::new(&codes, bit_count, number, chunk_count);
        let chunks = (0..chunk_count).map(chunk).collect();
        Index { bit_count, hamming, codes, ids, chunks }
    }

    /// Wrong bits that are corrected.
    pub fn hamming(&self) -> u32 {
        self.hamming
    }

    /// Bytes that this index occupies, those on the heap included.
    pub fn size_bytes(&self) -> usize {
        let heap = self.codes.capacity() * size_of::<u64>()
            + self.ids.capacity() * size_of::<u32>()
            + self.chunks.capacity() * size_of::<Chunk>();
        size_of::<Index>() + heap + self.chunks.iter().map(Chunk::heap_bytes).sum::<usize>()
    }

    /// The tag whose code is nearest to `code` over its four rotations, if that is at most [`Index::hamming`] bits
    /// away. Does not allocate.
    ///
    /// Only a tag without wrong bits ends the search early. A single wrong bit would do as well if the family's
    /// stated distance could be relied on, but families of users may state too much, and what is gained is a
    /// fraction of the little time that true tags take.
    pub fn lookup(&self, code: u64) -> Option<Found> {
        let mut best = None;
        let mut turned = code & (u64::MAX >> (64 - self.bit_count));
        for rotation in 0..4 {
            self.improve(&mut best, turned, rotation);
            if best.is_some_and(|found| found.hamming == 0) {
                break;
            }
            turned = rotate90(turned, self.bit_count);
        }
        best
    }

    fn improve(&self, best: &mut Option<Found>, turned: u64, rotation: u32) {
        if self.chunks.is_empty() && self.any_is_near(turned) {
            (0..self.codes.len()).for_each(|place| self.compare(best, turned, rotation, place));
        }
        for chunk in &self.chunks {
            chunk.visit_near(turned, self.hamming, |place| self.compare(best, turned, rotation, place));
        }
    }

    /// Says quickly, for a few codes, that none is within reach: a loop without branches, many codes at once.
    fn any_is_near(&self, turned: u64) -> bool {
        let nearest = self.codes.iter().map(|code| (code ^ turned).count_ones()).fold(u32::MAX, u32::min);
        nearest <= self.hamming
    }

    fn compare(&self, best: &mut Option<Found>, turned: u64, rotation: u32, place: usize) {
        let hamming = (self.codes[place] ^ turned).count_ones();
        if hamming > self.hamming {
            return;
        }
        let found = Found { id: self.ids[place], hamming, rotation };
        if best.is_none_or(|best| found.rank() < best.rank()) {
            *best = Some(found);
        }
    }
}

/// All codes in buckets by some of their bits, the key.
#[derive(Clone, Debug)]
struct Chunk {
    cut: Cut,
    /// The bucket of key `i` is the range `offsets[i]..offsets[i + 1]` of the next two.
    offsets: Vec<u32>,
    /// 32 bits of each code beside the key, fewer where it has no more. Some zeros follow, so that every bucket ends with
    /// a whole block.
    fingerprints: Vec<u32>,
    places: Vec<u32>,
}

impl Chunk {
    fn new(codes: &[u64], bit_count: u32, number: u32, chunk_count: u32) -> Chunk {
        let cut = Cut::new(bit_count, number, chunk_count, codes.len());
        let mut offsets = bucket_ends(codes, &cut);
        let mut fingerprints = vec![0; codes.len() + BLOCK - 1];
        let mut places = vec![0; codes.len()];
        // Filling each bucket from its end turns the ends into beginnings.
        for (place, &code) in codes.iter().enumerate().rev() {
            let end = &mut offsets[cut.key(code)];
            *end -= 1;
            fingerprints[*end as usize] = cut.fingerprint(code);
            places[*end as usize] = place as u32;
        }
        Chunk { cut, offsets, fingerprints, places }
    }

    fn heap_bytes(&self) -> usize {
        let words = self.offsets.capacity() + self.fingerprints.capacity() + self.places.capacity();
        words * size_of::<u32>()
    }

    /// Visits the places of the codes with the key of `code` and nearly its fingerprint.
    fn visit_near(&self, code: u64, hamming: u32, mut visit: impl FnMut(usize)) {
        let key = self.cut.key(code);
        let fingerprint = self.cut.fingerprint(code);
        let bucket = self.offsets[key] as usize..self.offsets[key + 1] as usize;
        for start in bucket.clone().step_by(BLOCK) {
            let Some(block) = self.fingerprints[start..].first_chunk() else { return };
            let near = near(block, fingerprint, hamming);
            if near == [false; BLOCK] {
                continue;
            }
            for (place, _) in self.places[start..bucket.end].iter().zip(near).filter(|(_, near)| *near) {
                visit(*place as usize);
            }
        }
    }
}

/// Which of a block differ from `fingerprint` in at most `hamming` bits.
///
/// Taking away the lowest one so many times leaves nothing: for few bits quicker than counting the ones, which takes a
/// dozen operations on processors that have none for it.
fn near(block: &[u32; BLOCK], fingerprint: u32, hamming: u32) -> [bool; BLOCK] {
    let mut ones = block.map(|other| other ^ fingerprint);
    for _ in 0..hamming {
        ones = ones.map(|ones| ones & ones.wrapping_sub(1));
    }
    ones.map(|ones| ones == 0)
}

/// For each key the number of codes with that key or a smaller one, and a last entry with the number of all.
fn bucket_ends(codes: &[u64], cut: &Cut) -> Vec<u32> {
    let mut ends = vec![0; (1 << cut.key_bits) + 1];
    codes.iter().for_each(|&code| ends[cut.key(code)] += 1);
    let mut sum = 0;
    for end in &mut ends {
        sum += *end;
        *end = sum;
    }
    ends
}

/// Which bits of a code are the key of a chunk and which the fingerprint.
#[derive(Clone, Copy, Debug)]
struct Cut {
    bit_count: u32,
    /// Where the key begins, counted from the least significant bit.
    start: u32,
    key_bits: u32,
}

impl Cut {
    /// Chunk `number` of `chunk_count` nearly equal ones. Its key is as long as it takes to have about half a code a
    /// bucket, if the chunk is.
    fn new(bit_count: u32, number: u32, chunk_count: u32, code_count: usize) -> Cut {
        let start = bit_count * number / chunk_count;
        let end = bit_count * (number + 1) / chunk_count;
        let wanted = (usize::BITS - code_count.leading_zeros() + 1).min(MAX_KEY_BITS);
        Cut { bit_count, start, key_bits: wanted.min(end - start) }
    }

    fn key(&self, code: u64) -> usize {
        (code >> self.start & ((1 << self.key_bits) - 1)) as usize
    }

    /// The bits above the key, and then those below it.
    fn fingerprint(&self, code: u64) -> u32 {
        let above = self.start + self.key_bits;
        let upper = code.checked_shr(above).unwrap_or(0);
        // At most 2^start - 1, so that the key itself does not get in.
        let lower = code & ((1 << self.start) - 1);
        (upper | lower.checked_shl(self.bit_count - above).unwrap_or(0)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use crate::random::Random;

    /// What `Index::lookup` has to find, by comparing with everything.
    fn brute_force(family: &Family, ids: &[u32], hamming: u32, code: u64) -> Option<Found> {
        let mut turned = code;
        let mut found = Vec::new();
        for rotation in 0..4 {
            let of = |&id: &u32| Found {
                id,
                hamming: (family.codes()[id as usize] ^ turned).count_ones(),
                rotation,
            };
            found.extend(ids.iter().map(of).filter(|found| found.hamming <= hamming));
            turned = family.layout().rotate90(turned);
        }
        found.into_iter().min_by_key(Found::rank)
    }

    fn all_ids(family: &Family) -> Vec<u32> {
        (0..family.codes().len() as u32).collect()
    }

    fn with_errors(code: u64, count: u32, bit_count: u32, random: &mut Random) -> u64 {
        let mut wrong = 0_u64;
        while wrong.count_ones() < count {
            wrong |= 1 << random.below(bit_count as usize);
        }
        code ^ wrong
    }

    fn turned(family: &Family, code: u64, times: u32) -> u64 {
        (0..times).fold(code, |code, _| family.layout().rotate90(code))
    }

    fn distances(name: &str) -> impl Iterator<Item = (Family, Index)> {
        let family = Family::published(name).unwrap();
        (0..=family.correctable().min(4)).map(move |hamming| (family.clone(), Index::new(&family, hamming)))
    }

    #[test]
    fn look_up_agrees_with_brute_force_on_random_codes_and_on_tags_with_errors() {
        for (seed, name) in (1..).zip(Family::PUBLISHED) {
            let mut random = Random::new(seed);
            for (family, index) in distances(name) {
                let ids = all_ids(&family);
                let bit_count = family.layout().bit_count();
                let mask = u64::MAX >> (64 - bit_count);
                let rounds = (2_000_000 / ids.len()).clamp(20, 1000);
                for round in 0..rounds {
                    let id = random.below(ids.len());
                    let errors = random.below(index.hamming() as usize + 2) as u32;
                    let tag = turned(&family, family.codes()[id], random.below(4) as u32);
                    let tag = with_errors(tag, errors, bit_count, &mut random);
                    for code in [tag, random.next() & mask] {
                        let expected = brute_force(&family, &ids, index.hamming(), code);
                        assert_eq!(
                            index.lookup(code),
                            expected,
                            "{name}, seed {seed}, round {round}, {code:#x}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn every_tag_is_found_in_every_rotation_with_all_the_errors_that_are_corrected() {
        for (seed, name) in (100..).zip(Family::PUBLISHED) {
            let mut random = Random::new(seed);
            for (family, index) in distances(name) {
                for (id, &code) in family.codes().iter().enumerate() {
                    let rotation = random.below(4) as u32;
                    let read = turned(&family, code, (4 - rotation) % 4);
                    let hamming = index.hamming();
                    let read = with_errors(read, hamming, family.layout().bit_count(), &mut random);
                    let expected = Found { id: id as u32, hamming, rotation };
                    assert_eq!(index.lookup(read), Some(expected), "{name}, seed {seed}, {read:#x}");
                }
            }
        }
    }

    #[test]
    fn the_codes_are_their_own_nearest_for_all_four_rotations() {
        let family = Family::published("tag36h11").unwrap();
        let index = Index::new(&family, 2);
        for (id, &code) in family.codes().iter().enumerate() {
            for times in 0..4 {
                let expected = Found { id: id as u32, hamming: 0, rotation: (4 - times) % 4 };
                assert_eq!(index.lookup(turned(&family, code, times)), Some(expected));
            }
        }
    }

    /// A family whose stated distance is far too large, so that several codes lie within reach.
    fn crowded(count: usize, seed: u64) -> Family {
        let layout = Layout::classic(8).unwrap();
        let mut random = Random::new(seed);
        let mut codes: Vec<u64> = Vec::new();
        while codes.len() < count {
            let code = random.next() & 0xffff;
            let is_new = (0..4).all(|times| {
                let turned = (0..times).fold(code, |code, _| layout.rotate90(code));
                !codes.contains(&turned)
            });
            if is_new {
                codes.push(code);
            }
        }
        Family::new("crowded", layout, codes, 9).unwrap()
    }

    #[test]
    fn the_nearest_code_wins_where_several_are_in_reach() {
        for (count, seed) in [(SCAN_AT_MOST, 1), (SCAN_AT_MOST + 1, 2), (300, 3)] {
            let family = crowded(count, seed);
            for hamming in 0..=4 {
                let index = Index::new(&family, hamming);
                for code in 0..0x1_0000 {
                    let expected = brute_force(&family, &all_ids(&family), hamming, code);
                    assert_eq!(index.lookup(code), expected, "{count} codes, {hamming} bits, {code:#x}");
                }
            }
        }
    }

    #[test]
    fn only_allowed_ids_are_found() {
        let family = Family::published("tag36h11").unwrap();
        for (count, seed) in [(0, 1), (3, 2), (SCAN_AT_MOST, 3), (200, 4)] {
            let mut random = Random::new(seed);
            let allowed: Vec<u32> = (0..count).map(|_| random.below(family.codes().len()) as u32).collect();
            let index = Index::for_ids(&family, 2, &allowed);
            for (id, &code) in all_ids(&family).iter().zip(family.codes()) {
                let expected = allowed.contains(id).then_some(*id);
                assert_eq!(index.lookup(code ^ 0b101).map(|found| found.id), expected);
            }
        }
    }

    #[test]
    fn ids_that_do_not_exist_or_come_twice_change_nothing() {
        let family = Family::published("tag25h9").unwrap();
        let index = Index::for_ids(&family, 2, &[35, u32::MAX, 7, 7]);
        assert_eq!(index.ids, [7]);
    }

    #[test]
    fn more_errors_than_can_be_told_apart_are_not_corrected() {
        for (name, most) in
            [("tag16h5", 2), ("tag25h9", 4), ("tag36h10", 4), ("tag36h11", 5), ("tagCircle21h7", 3)]
        {
            let family = Family::published(name).unwrap();
            assert_eq!(Index::new(&family, 64).hamming(), most);
            assert_eq!(Index::new(&family, 1).hamming(), 1);
        }
    }

    #[test]
    fn bits_beyond_the_code_are_not_looked_at() {
        let family = Family::published("tag36h11").unwrap();
        let read = family.codes()[5] | 1 << 63;
        let index = Index::new(&family, 0);
        assert_eq!(index.lookup(read), Some(Found { id: 5, hamming: 0, rotation: 0 }));
    }

    #[test]
    fn fingerprints_are_near_when_counting_says_so() {
        let mut random = Random::new(7);
        for hamming in 0..=7 {
            for round in 0..1000 {
                let fingerprint = random.next() as u32;
                let block = [0; BLOCK].map(|_| {
                    let errors = random.below(hamming as usize + 3) as u32;
                    with_errors(u64::from(fingerprint), errors, 32, &mut random) as u32
                });
                let counted = block.map(|other| (other ^ fingerprint).count_ones() <= hamming);
                assert_eq!(near(&block, fingerprint, hamming), counted, "{hamming} bits, round {round}");
            }
        }
    }

    #[test]
    fn key_and_fingerprint_have_no_bit_in_common_and_cover_what_they_can() {
        for bit_count in 4..=64 {
            for chunk_count in 1..=4 {
                for number in 0..chunk_count {
                    let cut = Cut::new(bit_count, number, chunk_count, 1000);
                    let seen =
                        |bit: u32| (cut.key(1 << bit).count_ones(), cut.fingerprint(1 << bit).count_ones());
                    let (keys, prints) =
                        (0..bit_count).map(seen).fold((0, 0), |(keys, prints), (key, print)| {
                            assert!(key + print <= 1);
                            (keys + key, prints + print)
                        });
                    assert_eq!((keys, prints), (cut.key_bits, 32.min(bit_count - cut.key_bits)));
                }
            }
        }
    }
}
