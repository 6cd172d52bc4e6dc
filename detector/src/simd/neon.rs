//! The kernels for NEON, which every aarch64 processor has. Each does whole blocks of 64 pixels only and says how much
//! it did; the scalar twin does the rest.

use std::arch::aarch64::*;

/// For each of 16 pixels the number of its tile among the four of a vector.
const TILES: [u8; 16] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

/// For each of 16 pixels its bit in the byte that it shares with seven others.
const BITS: [u8; 16] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];

#[target_feature(enable = "neon")]
fn load(bytes: &[u8], at: usize) -> uint8x16_t {
    let chunk = &bytes[at..at + 16];
    // SAFETY: `chunk` has just been checked to hold the 16 bytes that are read; the load takes any alignment.
    unsafe { vld1q_u8(chunk.as_ptr()) }
}

#[target_feature(enable = "neon")]
fn store(v: uint8x16_t, to: &mut [u8], at: usize) {
    let chunk = &mut to[at..at + 16];
    // SAFETY: `chunk` has just been checked to hold the 16 bytes that are written; the store takes any alignment.
    unsafe { vst1q_u8(chunk.as_mut_ptr(), v) }
}

/// Smallest and largest value of each of 16 columns.
#[target_feature(enable = "neon")]
fn column_extrema(rows: [&[u8]; 4], at: usize) -> (uint8x16_t, uint8x16_t) {
    let [a, b, c, d] = rows.map(|row| load(row, at));
    let low = vminq_u8(vminq_u8(a, b), vminq_u8(c, d));
    let high = vmaxq_u8(vmaxq_u8(a, b), vmaxq_u8(c, d));
    (low, high)
}

/// Tiles done, always a multiple of 16.
#[target_feature(enable = "neon")]
pub(super) fn tile_extrema(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 64;
    for i in 0..blocks {
        // Four vectors of columns, taken together pairwise twice, are one vector of tiles.
        let [a, b, c, d] = [0, 16, 32, 48].map(|at| column_extrema(rows, i * 64 + at));
        let low = vpminq_u8(vpminq_u8(a.0, b.0), vpminq_u8(c.0, d.0));
        let high = vpmaxq_u8(vpmaxq_u8(a.1, b.1), vpmaxq_u8(c.1, d.1));
        store(low, minima, i * 16);
        store(high, maxima, i * 16);
    }
    blocks * 16
}

/// One bit for each of 64 pixels, the first lowest, from masks whose bytes are 0 or 255.
#[target_feature(enable = "neon")]
fn pack(masks: [uint8x16_t; 4]) -> u64 {
    let bits = load(&BITS, 0);
    let [a, b, c, d] = masks.map(|mask| vandq_u8(mask, bits));
    // Eight neighbours have eight different bits, so that adding them up is the same as joining them.
    let bytes = vpaddq_u8(vpaddq_u8(a, b), vpaddq_u8(c, d));
    let bytes = vpaddq_u8(bytes, bytes);
    vgetq_lane_u64::<0>(vreinterpretq_u64_u8(bytes))
}

/// Words of 64 pixels done.
#[target_feature(enable = "neon")]
pub(super) fn threshold_row(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) -> usize {
    let words = row.len() / 64;
    let tiles = [0, 4, 8, 12].map(|first| vaddq_u8(load(&TILES, 0), vdupq_n_u8(first)));
    for i in 0..words {
        let of_tiles = load(cuts, i * 16);
        // Spread over the pixels of their tiles.
        let cut = tiles.map(|tiles| vqtbl1q_u8(of_tiles, tiles));
        let at_least = [0, 1, 2, 3].map(|part| vcgeq_u8(load(row, i * 64 + part * 16), cut[part]));
        let sure = cut.map(|cut| vtstq_u8(cut, cut));
        let reached = pack(at_least);
        dark[i] = !reached;
        bright[i] = reached & pack(sure);
    }
    words
}
