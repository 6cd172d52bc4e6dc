//! From a code that was read in a picture to the nearest tag.
//!
//! A code with at most k wrong bits, cut into k + 1 chunks, has at least one chunk without any. So for each chunk
//! all codes are sorted into buckets by (the low bits of) that chunk, and a look-up visits one bucket a chunk. Most
//! look-ups are of background that is no tag at all: next to each code's place a bucket keeps 32 other bits of it,
//! so that wrong codes are dropped without a jump to the table of codes.

use crate::family::Family;
use crate::layout::rotate90;

/// Up to this many codes it is quicker to compare with every one.
const SCAN_AT_MOST: usize = 64;
/// 2^16 offsets a chunk, 256 KiB: more would push the buckets out of the caches of a small board.
const MAX_KEY_BITS: u32 = 16;

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
        if self.chunks.is_empty() {
            (0..self.codes.len()).for_each(|place| self.compare(best, turned, rotation, place));
        }
        for chunk in &self.chunks {
            for entry in chunk.near(turned, self.hamming) {
                self.compare(best, turned, rotation, entry.place as usize);
            }
        }
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
    /// The bucket of key `i` is `entries[offsets[i]..offsets[i + 1]]`.
    offsets: Vec<u32>,
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// 32 bits of the code beside the key, fewer where it has no more.
    fingerprint: u32,
    place: u32,
}

impl Chunk {
    fn new(codes: &[u64], bit_count: u32, number: u32, chunk_count: u32) -> Chunk {
        let cut = Cut::new(bit_count, number, chunk_count, codes.len());
        let mut offsets = bucket_ends(codes, &cut);
        let mut entries = vec![Entry::default(); codes.len()];
        // Filling each bucket from its end turns the ends into beginnings.
        for (place, &code) in codes.iter().enumerate().rev() {
            let end = &mut offsets[cut.key(code)];
            *end -= 1;
            entries[*end as usize] = Entry { fingerprint: cut.fingerprint(code), place: place as u32 };
        }
        Chunk { cut, offsets, entries }
    }

    /// The entries with the key of `code` and nearly its fingerprint.
    fn near(&self, code: u64, hamming: u32) -> impl Iterator<Item = &Entry> {
        let key = self.cut.key(code);
        let fingerprint = self.cut.fingerprint(code);
        let bucket = self.offsets[key] as usize..self.offsets[key + 1] as usize;
        self.entries[bucket]
            .iter()
            .filter(move |entry| (entry.fingerprint ^ fingerprint).count_ones() <= hamming)
    }
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
