//! The kernels for NEON, which every aarch64 processor has. Each does whole blocks of 64 pixels only and says how much
//! it did; the scalar twin does the rest. Without `map` on arrays: it stays a call in the middle of the loop here.

use std::arch::aarch64::*;

use super::TILE;
use super::blocks::{Blocks, word_of};
use super::samples::{Crossings, LANES, Pixels, RIM, Sides};

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

/// Pixels done.
#[target_feature(enable = "neon")]
pub(super) fn tile_extrema(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) -> usize {
    let mut blocks = Blocks::<64>::of(rows[0].len(), TILE);
    while let Some(at) = blocks.next() {
        let (a, b) = (load_block(rows[0], at), load_block(rows[1], at));
        let (c, d) = (load_block(rows[2], at), load_block(rows[3], at));
        // Four vectors of columns, taken together pairwise twice, are one vector of tiles.
        let left = vpminq_u8(min_4(a.0, b.0, c.0, d.0), min_4(a.1, b.1, c.1, d.1));
        let right = vpminq_u8(min_4(a.2, b.2, c.2, d.2), min_4(a.3, b.3, c.3, d.3));
        store(vpminq_u8(left, right), minima, at / 4);
        let left = vpmaxq_u8(max_4(a.0, b.0, c.0, d.0), max_4(a.1, b.1, c.1, d.1));
        let right = vpmaxq_u8(max_4(a.2, b.2, c.2, d.2), max_4(a.3, b.3, c.3, d.3));
        store(vpmaxq_u8(left, right), maxima, at / 4);
    }
    blocks.end
}

/// The upper four bits of each of 16 bytes, the first byte's lowest.
#[target_feature(enable = "neon")]
fn upper_halves(bytes: uint8x16_t) -> u64 {
    // Narrowing takes the upper half of every even byte and the lower half of every odd one: make them equal first.
    let doubled = vreinterpretq_u16_u8(vsriq_n_u8::<4>(bytes, bytes));
    vget_lane_u64::<0>(vreinterpret_u64_u8(vshrn_n_u16::<4>(doubled)))
}

/// One bit for each of 64 pixels whose masks were dealt out as `load_dealt` deals.
#[target_feature(enable = "neon")]
fn packed(a: uint8x16_t, b: uint8x16_t, c: uint8x16_t, d: uint8x16_t) -> u64 {
    // Shifted in below each other: at last the uppermost bits of each byte are those of d, c, b and a.
    let (ab, cd) = (vsriq_n_u8::<1>(b, a), vsriq_n_u8::<1>(d, c));
    upper_halves(vsriq_n_u8::<2>(cd, ab))
}

/// Pixels done.
#[target_feature(enable = "neon")]
pub(super) fn threshold_row(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) -> usize {
    let mut blocks = Blocks::<64>::of(row.len(), 1);
    while let Some(at) = blocks.next() {
        let (pixels, cuts) = (load_dealt(row, at), load_dealt(cuts, at));
        let (a, b) = (vcgeq_u8(pixels.0, cuts.0), vcgeq_u8(pixels.1, cuts.1));
        let (c, d) = (vcgeq_u8(pixels.2, cuts.2), vcgeq_u8(pixels.3, cuts.3));
        let (sure_a, sure_b) = (vandq_u8(a, vtstq_u8(cuts.0, cuts.0)), vandq_u8(b, vtstq_u8(cuts.1, cuts.1)));
        let (sure_c, sure_d) = (vandq_u8(c, vtstq_u8(cuts.2, cuts.2)), vandq_u8(d, vtstq_u8(cuts.3, cuts.3)));
        let (word, known) = word_of(at);
        dark[word] = !packed(a, b, c, d) >> known;
        bright[word] = packed(sure_a, sure_b, sure_c, sure_d) >> known;
    }
    blocks.end
}

/// Values done, always a multiple of 16.
#[target_feature(enable = "neon")]
pub(super) fn every_second(row: &[u8], out: &mut [u8]) -> usize {
    let blocks = row.len() / 32;
    for i in 0..blocks {
        let chunk = &row[i * 32..][..32];
        // SAFETY: `chunk` has just been checked to hold the 32 bytes that are read; the load takes any alignment.
        let dealt = unsafe { vld2q_u8(chunk.as_ptr()) };
        store(dealt.0, out, i * 16);
    }
    blocks * 16
}

/// 24 bytes, dealt out: the first vector has bytes 0, 3, 6 and so on, the second 1, 4, 7, ...
#[target_feature(enable = "neon")]
fn load_triples(bytes: &[u8], at: usize) -> uint8x8x3_t {
    let chunk = &bytes[at..at + 24];
    // SAFETY: `chunk` has just been checked to hold the 24 bytes that are read; the load takes any alignment.
    unsafe { vld3_u8(chunk.as_ptr()) }
}

/// Sums of eight pixels: twice the full row's and once the half row's.
#[target_feature(enable = "neon")]
fn column(full: uint8x8_t, half: uint8x8_t) -> uint16x8_t {
    vaddw_u8(vshll_n_u8::<1>(full), half)
}

/// Ninths of twice `outer` and once `middle`, rounded: 7282 / 65536 is near enough for all sums up to 2299.
#[target_feature(enable = "neon")]
fn ninths(outer: uint16x8_t, middle: uint16x8_t) -> uint8x8_t {
    let sum = vaddq_u16(vaddq_u16(outer, outer), vaddq_u16(middle, vdupq_n_u16(4)));
    let low = vmull_n_u16(vget_low_u16(sum), 7282);
    let high = vmull_n_u16(vget_high_u16(sum), 7282);
    vmovn_u16(vcombine_u16(vshrn_n_u32::<16>(low), vshrn_n_u32::<16>(high)))
}

/// Values done, always a multiple of 16.
#[target_feature(enable = "neon")]
pub(super) fn three_to_two(full: &[u8], half: &[u8], out: &mut [u8]) -> usize {
    let blocks = full.len() / 24;
    for i in 0..blocks {
        let (a, b) = (load_triples(full, i * 24), load_triples(half, i * 24));
        let middle = column(a.1, b.1);
        let (first, last) = (ninths(column(a.0, b.0), middle), ninths(column(a.2, b.2), middle));
        let to = &mut out[i * 16..][..16];
        // SAFETY: `to` has just been checked to hold the 16 bytes that are written; the store takes any alignment.
        unsafe { vst2_u8(to.as_mut_ptr(), uint8x8x2_t(first, last)) };
    }
    blocks * 16
}

/// Values done.
#[target_feature(enable = "neon")]
pub(super) fn pair_means(rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 32;
    for i in 0..blocks {
        let at = i * 32;
        let low = vpadalq_u8(vpaddlq_u8(load(rows[0], at)), load(rows[1], at));
        let high = vpadalq_u8(vpaddlq_u8(load(rows[0], at + 16)), load(rows[1], at + 16));
        store(vcombine_u8(vrshrn_n_u16::<2>(low), vrshrn_n_u16::<2>(high)), out, i * 16);
    }
    blocks * 16
}

/// Values done.
#[target_feature(enable = "neon")]
pub(super) fn pair_minima(rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 32;
    for i in 0..blocks {
        let at = i * 32;
        let low = vminq_u8(load(rows[0], at), load(rows[1], at));
        let high = vminq_u8(load(rows[0], at + 16), load(rows[1], at + 16));
        store(vpminq_u8(low, high), out, i * 16);
    }
    blocks * 16
}

/// Numbers that are written at once, as the scalar twin does.
const COLUMNS: usize = 8;

#[target_feature(enable = "neon")]
pub(super) fn columns(words: &[u64], first: u16, out: &mut [u16]) -> usize {
    let mut count = 0;
    for (base, word) in (first..).step_by(64).zip(words) {
        if *word == 0 {
            continue;
        }
        let base = vdupq_n_u16(base);
        let end = count + word.count_ones() as usize;
        // There is an instruction that counts leading zeros, but none for trailing ones.
        let mut bits = word.reverse_bits();
        while count < end {
            let mut numbers = 0;
            for i in 0..COLUMNS {
                let number = bits.leading_zeros();
                numbers |= u64::from(number) << (8 * i);
                // Where no bit is left this clears none, and the number is not used.
                bits &= !(1 << 63 >> (number % 64));
            }
            store_u16(vaddw_u8(base, vcreate_u8(numbers)), out, count);
            count += COLUMNS;
        }
        count = end;
    }
    count
}

#[target_feature(enable = "neon")]
fn store_u16(v: uint16x8_t, to: &mut [u16], at: usize) {
    let chunk = &mut to[at..at + 8];
    // SAFETY: `chunk` has just been checked to hold the 8 numbers that are written; the store takes any alignment.
    unsafe { vst1q_u16(chunk.as_mut_ptr(), v) }
}

#[target_feature(enable = "neon")]
fn load_f32(values: &[f32; LANES], at: usize) -> float32x4_t {
    let chunk = &values[at..at + 4];
    // SAFETY: `chunk` has just been checked to hold the 4 values that are read; the load takes any alignment.
    unsafe { vld1q_f32(chunk.as_ptr()) }
}

#[target_feature(enable = "neon")]
fn store_f32(v: float32x4_t, to: &mut [f32; LANES], at: usize) {
    let chunk = &mut to[at..at + 4];
    // SAFETY: `chunk` has just been checked to hold the 4 values that are written; the store takes any alignment.
    unsafe { vst1q_f32(chunk.as_mut_ptr(), v) }
}

#[target_feature(enable = "neon")]
pub(super) fn contains(pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    let mut contains = [0.0; LANES];
    for at in [0, 4] {
        let is_inside = vandq_u32(
            is_between(load_f32(x, at), pixels.last[0]),
            is_between(load_f32(y, at), pixels.last[1]),
        );
        let one = vreinterpretq_u32_f32(vdupq_n_f32(1.0));
        store_f32(vreinterpretq_f32_u32(vandq_u32(is_inside, one)), &mut contains, at);
    }
    contains
}

/// Whether coordinates lie between the first pixel's centre and the last one's.
#[target_feature(enable = "neon")]
fn is_between(v: float32x4_t, last: f32) -> uint32x4_t {
    let from_centre = vsubq_f32(v, vdupq_n_f32(0.5));
    vandq_u32(vcgezq_f32(from_centre), vcltq_f32(from_centre, vdupq_n_f32(last)))
}

/// `last_square` is that of `pixels`.
#[target_feature(enable = "neon")]
pub(super) fn values(pixels: &Pixels, last_square: u32, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    let mut values = [0.0; LANES];
    for at in [0, 4] {
        let (x, y) = (inside(load_f32(x, at), pixels.last[0]), inside(load_f32(y, at), pixels.last[1]));
        let (columns, rows) = (vcvtq_u32_f32(x), vcvtq_u32_f32(y));
        let (right, down) = (vsubq_f32(x, vcvtq_f32_u32(columns)), vsubq_f32(y, vcvtq_f32_u32(rows)));
        let places = vmlaq_n_u32(vmulq_n_u32(rows, pixels.stride as u32), columns, pixels.step as u32);
        // They never are behind it; what is read without a check has to be certain of that.
        let squares = squares(pixels, vminq_u32(places, vdupq_n_u32(last_square)));
        let upper = between(squares, right);
        let lower = between(vshrq_n_u32::<16>(squares), right);
        store_f32(vaddq_f32(upper, vmulq_f32(vsubq_f32(lower, upper), down)), &mut values, at);
    }
    values
}

/// Coordinates from the first pixel's centre, kept inside of the frame.
#[target_feature(enable = "neon")]
fn inside(v: float32x4_t, last: f32) -> float32x4_t {
    let from_centre = vsubq_f32(v, vdupq_n_f32(0.5));
    vminnmq_f32(vmaxnmq_f32(from_centre, vdupq_n_f32(0.0)), vdupq_n_f32(last - RIM))
}

/// The values `share` of the way from the lowest bytes to the second ones.
#[target_feature(enable = "neon")]
fn between(pairs: uint32x4_t, share: float32x4_t) -> float32x4_t {
    let byte = vdupq_n_u32(0xff);
    let left = vcvtq_f32_u32(vandq_u32(pairs, byte));
    let right = vcvtq_f32_u32(vandq_u32(vshrq_n_u32::<8>(pairs), byte));
    vaddq_f32(left, vmulq_f32(vsubq_f32(right, left), share))
}

/// Squares of pixels, a byte each. No place is behind the last square's.
#[target_feature(enable = "neon")]
fn squares(pixels: &Pixels, places: uint32x4_t) -> uint32x4_t {
    let places = [
        vgetq_lane_u32::<0>(places),
        vgetq_lane_u32::<1>(places),
        vgetq_lane_u32::<2>(places),
        vgetq_lane_u32::<3>(places),
    ];
    let mut squares = [0; 4];
    for i in 0..4 {
        let place = places[i] as usize;
        // Two bytes side by side are read at once.
        squares[i] = match pixels.step {
            1 => pair(pixels, place, 1) | pair(pixels, place + pixels.stride, 1) << 16,
            step => pair(pixels, place, step) | pair(pixels, place + pixels.stride, step) << 16,
        };
    }
    // SAFETY: the list holds the four numbers that are read; the load takes any alignment.
    unsafe { vld1q_u32(squares.as_ptr()) }
}

/// A pixel and the one on its right, `step` bytes further: of a square that is not behind the last one.
#[target_feature(enable = "neon")]
fn pair(pixels: &Pixels, place: usize, step: usize) -> u32 {
    // SAFETY: squares that are not behind the last one end inside of the bytes (Pixels::last_square), and so do both their rows.
    let pair = unsafe { pixels.bytes.get_unchecked(place..place + step + 1) };
    u32::from(pair[0]) | u32::from(pair[step]) << 8
}

#[target_feature(enable = "neon")]
pub(super) fn look(crossings: &mut Crossings, k: f32, step: f32, before: &Sides, now: &Sides) -> bool {
    let (k, far) = (vdupq_n_f32(k), vdupq_n_f32(f32::MAX));
    let mut any_open = 0.0f32;
    for at in [0, 4] {
        let (outer, inner) = (load_f32(&before[0], at), load_f32(&before[1], at));
        let (next_outer, next_inner) = (load_f32(&now[0], at), load_f32(&now[1], at));
        let rises_outside = vandq_u32(vclezq_f32(outer), vcgtzq_f32(next_outer));
        let rises_inside = vandq_u32(vclezq_f32(next_inner), vcgtzq_f32(inner));
        let out = vdivq_f32(next_outer, vsubq_f32(next_outer, outer));
        let within = vdivq_f32(next_inner, vsubq_f32(next_inner, inner));
        let outwards = vbslq_f32(rises_outside, vsubq_f32(k, out), far);
        let inwards = vbslq_f32(rises_inside, vsubq_f32(k, within), far);
        let nearest = vbslq_f32(vcltq_f32(inwards, outwards), vnegq_f32(inwards), outwards);
        let is_open = load_f32(&crossings.is_open, at);
        let is_found = vandq_u32(vcgtzq_f32(is_open), vorrq_u32(rises_outside, rises_inside));
        let shifts = vbslq_f32(is_found, vmulq_n_f32(nearest, step), load_f32(&crossings.shifts, at));
        let is_open = vbslq_f32(is_found, vdupq_n_f32(0.0), is_open);
        store_f32(shifts, &mut crossings.shifts, at);
        store_f32(is_open, &mut crossings.is_open, at);
        any_open += vmaxvq_f32(is_open);
    }
    any_open > 0.0
}
