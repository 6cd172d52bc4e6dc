//! The kernels for NEON, which every aarch64 processor has. Each does whole blocks of 64 pixels only and says how much
//! it did; the scalar twin does the rest. Without `map` on arrays: it stays a call in the middle of the loop here.

use std::arch::aarch64::*;

#[target_feature(enable = "neon")]
fn load(bytes: &[u8], at: usize) -> uint8x16_t {
    let chunk = &bytes[at..at + 16];
    // SAFETY: `chunk` has just been checked to hold the 16 bytes that are read; the load takes any alignment.
    unsafe { vld1q_u8(chunk.as_ptr()) }
}

/// 64 bytes, one vector after the other.
#[target_feature(enable = "neon")]
fn load_block(bytes: &[u8], at: usize) -> uint8x16x4_t {
    let chunk = &bytes[at..at + 64];
    // SAFETY: `chunk` has just been checked to hold the 64 bytes that are read; the load takes any alignment.
    unsafe { vld1q_u8_x4(chunk.as_ptr()) }
}

/// 64 bytes, dealt out: the first vector has bytes 0, 4, 8 and so on, the second 1, 5, 9, ...
#[target_feature(enable = "neon")]
fn load_dealt(bytes: &[u8], at: usize) -> uint8x16x4_t {
    let chunk = &bytes[at..at + 64];
    // SAFETY: `chunk` has just been checked to hold the 64 bytes that are read; the load takes any alignment.
    unsafe { vld4q_u8(chunk.as_ptr()) }
}

#[target_feature(enable = "neon")]
fn store(v: uint8x16_t, to: &mut [u8], at: usize) {
    let chunk = &mut to[at..at + 16];
    // SAFETY: `chunk` has just been checked to hold the 16 bytes that are written; the store takes any alignment.
    unsafe { vst1q_u8(chunk.as_mut_ptr(), v) }
}

#[target_feature(enable = "neon")]
fn min_4(a: uint8x16_t, b: uint8x16_t, c: uint8x16_t, d: uint8x16_t) -> uint8x16_t {
    vminq_u8(vminq_u8(a, b), vminq_u8(c, d))
}

#[target_feature(enable = "neon")]
fn max_4(a: uint8x16_t, b: uint8x16_t, c: uint8x16_t, d: uint8x16_t) -> uint8x16_t {
    vmaxq_u8(vmaxq_u8(a, b), vmaxq_u8(c, d))
}

/// Tiles done, always a multiple of 16.
#[target_feature(enable = "neon")]
pub(super) fn tile_extrema(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 64;
    for i in 0..blocks {
        let (a, b) = (load_block(rows[0], i * 64), load_block(rows[1], i * 64));
        let (c, d) = (load_block(rows[2], i * 64), load_block(rows[3], i * 64));
        // Four vectors of columns, taken together pairwise twice, are one vector of tiles.
        let left = vpminq_u8(min_4(a.0, b.0, c.0, d.0), min_4(a.1, b.1, c.1, d.1));
        let right = vpminq_u8(min_4(a.2, b.2, c.2, d.2), min_4(a.3, b.3, c.3, d.3));
        store(vpminq_u8(left, right), minima, i * 16);
        let left = vpmaxq_u8(max_4(a.0, b.0, c.0, d.0), max_4(a.1, b.1, c.1, d.1));
        let right = vpmaxq_u8(max_4(a.2, b.2, c.2, d.2), max_4(a.3, b.3, c.3, d.3));
        store(vpmaxq_u8(left, right), maxima, i * 16);
    }
    blocks * 16
}

/// The upper four bits of each of 16 bytes, the first byte's lowest.
#[target_feature(enable = "neon")]
fn upper_halves(bytes: uint8x16_t) -> u64 {
    // Narrowing takes the upper half of every even byte and the lower half of every odd one: make them equal first.
    let doubled = vreinterpretq_u16_u8(vsriq_n_u8::<4>(bytes, bytes));
    vget_lane_u64::<0>(vreinterpret_u64_u8(vshrn_n_u16::<4>(doubled)))
}

/// Words of 64 pixels done.
///
/// A dealt-out vector has one pixel of each of the 16 tiles, so that the cuts need no spreading over pixels.
#[target_feature(enable = "neon")]
pub(super) fn threshold_row(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) -> usize {
    let words = row.len() / 64;
    for i in 0..words {
        let cut = load(cuts, i * 16);
        let pixels = load_dealt(row, i * 64);
        let (a, b) = (vcgeq_u8(pixels.0, cut), vcgeq_u8(pixels.1, cut));
        let (c, d) = (vcgeq_u8(pixels.2, cut), vcgeq_u8(pixels.3, cut));
        // Shifted in below each other: at last the uppermost bits of each byte are those of d, c, b and a.
        let (ab, cd) = (vsriq_n_u8::<1>(b, a), vsriq_n_u8::<1>(d, c));
        let reached = upper_halves(vsriq_n_u8::<2>(cd, ab));
        let sure = upper_halves(vtstq_u8(cut, cut));
        dark[i] = !reached;
        bright[i] = reached & sure;
    }
    words
}
