//! Whether a code lies too close to others, and the order in which others are compared.

/// Codes that are compared before anybody looks whether one was near: four vectors of eight.
const BLOCK: usize = 32;
/// Codes a vector of the widest kind.
const LANES: usize = 8;

/// Whether any of `others` differs from `code` in fewer than `distance` bits.
///
/// Plain loops over whole blocks: compiled for AVX-512 they are as quick as written with its intrinsics.
#[inline(always)]
pub(super) fn any_within(code: u64, others: &[u64], distance: u32) -> bool {
    let (blocks, rest) = others.as_chunks::<BLOCK>();
    for block in blocks {
        if is_near(code, block.as_chunks().0, distance) {
            return true;
        }
    }
    let (groups, rest) = rest.as_chunks();
    let mut near = is_near(code, groups, distance);
    for other in rest {
        near |= (other ^ code).count_ones() < distance;
    }
    near
}

#[inline(always)]
fn is_near(code: u64, groups: &[[u64; LANES]], distance: u32) -> bool {
    let mut least = [u64::MAX; LANES];
    for group in groups {
        for lane in 0..LANES {
            least[lane] = least[lane].min(u64::from((group[lane] ^ code).count_ones()));
        }
    }
    let mut near = 0;
    for least in least {
        near |= u64::from(least < u64::from(distance));
    }
    near != 0
}

/// Codes in buckets by their low bits, so that those which resemble a candidate there are compared first: they are
/// the most likely ones to be too close.
pub(super) struct Buckets {
    /// How many low bits.
    bits: u32,
    buckets: Vec<Vec<u64>>,
    len: usize,
    /// The values of the low bits, those with fewest ones first.
    by_ones: Vec<u64>,
}

impl Buckets {
    /// No codes yet, in 2^`bits` buckets.
    pub(super) fn new(bits: u32) -> Buckets {
        let mut by_ones: Vec<u64> = (0..1 << bits).collect();
        by_ones.sort_by_key(|value| value.count_ones());
        Buckets { bits, buckets: vec![Vec::new(); 1 << bits], len: 0, by_ones }
    }

    pub(super) fn insert(&mut self, code: u64) {
        let low = self.low(code);
        self.buckets[low as usize].push(code);
        self.len += 1;
    }

    /// The low bits of a code.
    pub(super) fn low(&self, code: u64) -> u64 {
        code & ((1 << self.bits) - 1)
    }

    /// How many values of the order by ones bring together at least `count` codes, all of one distance or none.
    pub(super) fn reach(&self, count: usize) -> usize {
        let all = self.by_ones.len();
        let wanted = (count * all).checked_div(self.len).unwrap_or(all).clamp(1, all);
        let ones = self.by_ones[wanted - 1].count_ones();
        self.by_ones.partition_point(|value| value.count_ones() <= ones)
    }

    /// The codes whose low bits differ from `low` as the values at `places` of the order by ones.
    pub(super) fn around(&self, low: u64, places: std::ops::Range<usize>) -> impl Iterator<Item = &[u64]> {
        self.by_ones[places].iter().map(move |value| self.buckets[(low ^ value) as usize].as_slice())
    }

    /// How many values the low bits have.
    pub(super) fn values(&self) -> usize {
        self.by_ones.len()
    }
}
