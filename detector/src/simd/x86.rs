//! The kernels for AVX2 and AVX-512. Each does whole vectors only and says how much it did; the scalar twin does the rest.

use std::arch::x86_64::*;

use super::TILE;
use super::blocks::{Blocks, word_of};
use super::level::Kernel;
use super::samples::{self, LANES, Pixels};

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi2,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// A function of its own: it is called in a dozen places, and in each of them would take as much code as a page has.
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn values_avx2(pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    samples::values(pixels, x, y)
}

#[target_feature(enable = "avx2")]
fn load_128(bytes: &[u8], at: usize) -> __m128i {
    let chunk = &bytes[at..at + 16];
    // SAFETY: `chunk` has just been checked to hold the 16 bytes that are read; the load takes any alignment.
    unsafe { _mm_loadu_si128(chunk.as_ptr().cast()) }
}

#[target_feature(enable = "avx2")]
fn load_256(bytes: &[u8], at: usize) -> __m256i {
    let chunk = &bytes[at..at + 32];
    // SAFETY: `chunk` has just been checked to hold the 32 bytes that are read; the load takes any alignment.
    unsafe { _mm256_loadu_si256(chunk.as_ptr().cast()) }
}

#[target_feature(enable = "avx512f,avx512bw")]
fn load_512(bytes: &[u8], at: usize) -> __m512i {
    let chunk = &bytes[at..at + 64];
    // SAFETY: `chunk` has just been checked to hold the 64 bytes that are read; the load takes any alignment.
    unsafe { _mm512_loadu_si512(chunk.as_ptr().cast()) }
}

/// The bytes from `at` to the end of a row, at most 64 of them, and `others` behind these.
#[target_feature(enable = "avx512f,avx512bw")]
fn load_rest_512(bytes: &[u8], at: usize, others: __m512i) -> __m512i {
    let rest = &bytes[at..];
    // SAFETY: no more bytes are read than `rest` has, since those that the mask leaves out are not; any alignment will do.
    unsafe { _mm512_mask_loadu_epi8(others, first_bits(rest.len()), rest.as_ptr().cast()) }
}

/// A mask of the first `count` of 64 bytes, or of all.
fn first_bits(count: usize) -> u64 {
    if count < 64 { (1 << count) - 1 } else { u64::MAX }
}

/// The least and the largest of four rows in each of 32 columns.
#[target_feature(enable = "avx2")]
fn columns_256<const SIZE: usize>(rows: [&[u8; SIZE]; 4], at: usize) -> [__m256i; 2] {
    // Not by `map`: its closure would be compiled without these instructions.
    let (a, b) = (load_256(rows[0], at), load_256(rows[1], at));
    let (c, d) = (load_256(rows[2], at), load_256(rows[3], at));
    let low = _mm256_min_epu8(_mm256_min_epu8(a, b), _mm256_min_epu8(c, d));
    let high = _mm256_max_epu8(_mm256_max_epu8(a, b), _mm256_max_epu8(c, d));
    [low, high]
}

/// The least of each two bytes, as 16 bits.
#[target_feature(enable = "avx2")]
fn least_of_two_256(v: __m256i) -> __m256i {
    _mm256_and_si256(_mm256_min_epu8(v, _mm256_srli_epi16::<8>(v)), _mm256_set1_epi16(0xff))
}

/// The largest of each two bytes, as 16 bits.
#[target_feature(enable = "avx2")]
fn most_of_two_256(v: __m256i) -> __m256i {
    _mm256_and_si256(_mm256_max_epu8(v, _mm256_srli_epi16::<8>(v)), _mm256_set1_epi16(0xff))
}

/// What was packed twice in order: packing keeps to halves of 128 bits.
#[target_feature(enable = "avx2")]
fn packed_twice_256(v: __m256i) -> __m256i {
    _mm256_permutevar8x32_epi32(v, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7))
}

/// The least of each four bytes of four vectors.
#[target_feature(enable = "avx2")]
fn least_of_four_256([a, b, c, d]: [__m256i; 4]) -> __m256i {
    let ab = _mm256_packus_epi16(least_of_two_256(a), least_of_two_256(b));
    let cd = _mm256_packus_epi16(least_of_two_256(c), least_of_two_256(d));
    packed_twice_256(_mm256_packus_epi16(least_of_two_256(ab), least_of_two_256(cd)))
}

/// The largest of each four bytes of four vectors.
#[target_feature(enable = "avx2")]
fn most_of_four_256([a, b, c, d]: [__m256i; 4]) -> __m256i {
    let ab = _mm256_packus_epi16(most_of_two_256(a), most_of_two_256(b));
    let cd = _mm256_packus_epi16(most_of_two_256(c), most_of_two_256(d));
    packed_twice_256(_mm256_packus_epi16(most_of_two_256(ab), most_of_two_256(cd)))
}

/// Pixels done.
#[target_feature(enable = "avx2")]
pub(super) fn tile_extrema_avx2(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) -> usize {
    let mut blocks = Blocks::<128>::of(rows[0].len(), TILE);
    while let Some(at) = blocks.next() {
        // All is checked before anything is read: what is computed between checks would be put aside.
        let rows = block_of::<128>(rows, at);
        let (minima, maxima) = (&mut minima[at / TILE..][..32], &mut maxima[at / TILE..][..32]);
        let [[a, high_a], [b, high_b]] = [columns_256(rows, 0), columns_256(rows, 32)];
        let [[c, high_c], [d, high_d]] = [columns_256(rows, 64), columns_256(rows, 96)];
        store_256(least_of_four_256([a, b, c, d]), minima);
        store_256(most_of_four_256([high_a, high_b, high_c, high_d]), maxima);
    }
    if blocks.end > 0 { blocks.end } else { narrow_tile_extrema_avx2(rows, minima, maxima) }
}

/// As [`tile_extrema_avx2`], for rows of fewer pixels than four vectors.
#[target_feature(enable = "avx2")]
fn narrow_tile_extrema_avx2(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) -> usize {
    let mut blocks = Blocks::<32>::of(rows[0].len(), TILE);
    while let Some(at) = blocks.next() {
        let [low, high] = columns_256(block_of::<32>(rows, at), 0);
        let (low, high) = (least_of_four_256([low; 4]), most_of_four_256([high; 4]));
        minima[at / TILE..][..8].copy_from_slice(&first_half_128(low));
        maxima[at / TILE..][..8].copy_from_slice(&first_half_128(high));
    }
    blocks.end
}

/// So many pixels of each row from `at` on.
#[inline(always)]
fn block_of<const SIZE: usize>(rows: [&[u8]; 4], at: usize) -> [&[u8; SIZE]; 4] {
    rows.map(|row| row[at..].first_chunk().expect("rows are equally long"))
}

/// The first eight bytes.
#[target_feature(enable = "avx2")]
fn first_half_128(v: __m256i) -> [u8; 8] {
    _mm_cvtsi128_si64(_mm256_castsi256_si128(v)).to_le_bytes()
}

/// All pixels.
#[target_feature(enable = "avx512f,avx512bw,avx512vl")]
pub(super) fn tile_extrema_avx512(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) {
    let (mut at, pixels) = (0, rows[0].len());
    while at + 64 <= pixels {
        // Not by `map`: its closure would be compiled without these instructions.
        let (a, b) = (load_512(rows[0], at), load_512(rows[1], at));
        let (c, d) = (load_512(rows[2], at), load_512(rows[3], at));
        let low = _mm512_min_epu8(_mm512_min_epu8(a, b), _mm512_min_epu8(c, d));
        let high = _mm512_max_epu8(_mm512_max_epu8(a, b), _mm512_max_epu8(c, d));
        store_128(least_of_four(low), &mut minima[at / TILE..]);
        store_128(most_of_four(high), &mut maxima[at / TILE..]);
        at += 64;
    }
    if at < pixels {
        let (mut low, mut high) = (_mm512_set1_epi8(-1), _mm512_setzero_si512());
        for row in rows {
            low = _mm512_min_epu8(low, load_rest_512(row, at, low));
            high = _mm512_max_epu8(high, load_rest_512(row, at, high));
        }
        store_rest_128(least_of_four(low), &mut minima[at / TILE..]);
        store_rest_128(most_of_four(high), &mut maxima[at / TILE..]);
    }
}

/// The least of each four bytes.
#[target_feature(enable = "avx512f,avx512bw")]
fn least_of_four(v: __m512i) -> __m128i {
    let pairs = _mm512_min_epu8(v, _mm512_srli_epi32::<8>(v));
    _mm512_cvtepi32_epi8(_mm512_min_epu8(pairs, _mm512_srli_epi32::<16>(pairs)))
}

/// The largest of each four bytes.
#[target_feature(enable = "avx512f,avx512bw")]
fn most_of_four(v: __m512i) -> __m128i {
    let pairs = _mm512_max_epu8(v, _mm512_srli_epi32::<8>(v));
    _mm512_cvtepi32_epi8(_mm512_max_epu8(pairs, _mm512_srli_epi32::<16>(pairs)))
}

#[target_feature(enable = "avx2")]
fn store_128(v: __m128i, to: &mut [u8]) {
    let to = &mut to[..16];
    // SAFETY: `to` has just been checked to hold the 16 bytes that are written; the store takes any alignment.
    unsafe { _mm_storeu_si128(to.as_mut_ptr().cast(), v) }
}

/// As many of the 16 bytes as `to` has room for.
#[target_feature(enable = "avx512f,avx512bw,avx512vl")]
fn store_rest_128(v: __m128i, to: &mut [u8]) {
    // SAFETY: no more bytes are written than `to` has, since those that the mask leaves out are not; any alignment will do.
    unsafe { _mm_mask_storeu_epi8(to.as_mut_ptr().cast(), first_bits(to.len()) as u16, v) }
}

/// Pixels done.
#[target_feature(enable = "avx2")]
pub(super) fn threshold_row_avx2(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) -> usize {
    let zero = _mm256_setzero_si256();
    let mut blocks = Blocks::<64>::of(row.len(), 1);
    while let Some(at) = blocks.next() {
        let (mut reached, mut sure) = ([0u64; 2], [0u64; 2]);
        for half in 0..2 {
            let pixels = load_256(row, at + half * 32);
            let cut = load_256(cuts, at + half * 32);
            let at_least = _mm256_cmpeq_epi8(_mm256_max_epu8(pixels, cut), pixels);
            // Masked as vectors: joined as words, the compiler would take them apart byte by byte.
            let bright = _mm256_andnot_si256(_mm256_cmpeq_epi8(cut, zero), at_least);
            reached[half] = u64::from(_mm256_movemask_epi8(at_least) as u32);
            sure[half] = u64::from(_mm256_movemask_epi8(bright) as u32);
        }
        let (word, known) = word_of(at);
        dark[word] = !(reached[0] | reached[1] << 32) >> known;
        bright[word] = (sure[0] | sure[1] << 32) >> known;
    }
    blocks.end
}

/// All pixels.
#[target_feature(enable = "avx512f,avx512bw")]
pub(super) fn threshold_row_avx512(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) {
    let none = _mm512_setzero_si512();
    for (i, (dark, bright)) in dark.iter_mut().zip(bright).enumerate() {
        // Behind the row's end cuts are 0: neither dark nor bright.
        let (pixels, cut) = if i * 64 + 64 <= row.len() {
            (load_512(row, i * 64), load_512(cuts, i * 64))
        } else {
            (load_rest_512(row, i * 64, none), load_rest_512(&cuts[..row.len()], i * 64, none))
        };
        let below = _mm512_cmplt_epu8_mask(pixels, cut);
        *dark = below;
        *bright = !below & _mm512_test_epi8_mask(cut, cut);
    }
}

#[target_feature(enable = "avx2")]
fn store_256(v: __m256i, to: &mut [u8]) {
    let to = &mut to[..32];
    // SAFETY: `to` has just been checked to hold the 32 bytes that are written; the store takes any alignment.
    unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), v) }
}

/// Values done.
#[target_feature(enable = "avx2")]
pub(super) fn every_second_avx2(row: &[u8], out: &mut [u8]) -> usize {
    let blocks = row.len() / 64;
    let low = _mm256_set1_epi16(0xff);
    for i in 0..blocks {
        let a = _mm256_and_si256(load_256(row, i * 64), low);
        let b = _mm256_and_si256(load_256(row, i * 64 + 32), low);
        store_256(packed_256(a, b), &mut out[i * 32..]);
    }
    blocks * 32
}

/// All values. Steps of 3 and more take at most 22 of a vector's 64 bytes; what is stored behind them is overwritten.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi2")]
pub(super) fn every_avx512(row: &[u8], step: usize, out: &mut [u8]) {
    let values = 64usize.div_ceil(step);
    let wanted: u64 = (0..values).map(|i| 1 << (i * step)).sum();
    let (mut at, mut done) = (0, 0);
    while at + 64 <= row.len() && done + 32 <= out.len() {
        let packed = _mm512_maskz_compress_epi8(wanted, load_512(row, at));
        store_256(_mm512_castsi512_si256(packed), &mut out[done..]);
        (at, done) = (at + values * step, done + values);
    }
    while done < out.len() {
        let bytes = load_rest_512(row, at, _mm512_setzero_si512());
        let packed = _mm512_maskz_compress_epi8(wanted, bytes);
        store_rest_256(_mm512_castsi512_si256(packed), &mut out[done..]);
        (at, done) = (at + values * step, done + values);
    }
}

/// As many of the 32 bytes as `to` has room for.
#[target_feature(enable = "avx512f,avx512bw,avx512vl")]
fn store_rest_256(v: __m256i, to: &mut [u8]) {
    // SAFETY: no more bytes are written than `to` has, since those that the mask leaves out are not; any alignment will do.
    unsafe { _mm256_mask_storeu_epi8(to.as_mut_ptr().cast(), first_bits(to.len()) as u32, v) }
}

/// The bytes of two vectors of 16-bit values below 256, in order.
#[target_feature(enable = "avx2")]
fn packed_256(a: __m256i, b: __m256i) -> __m256i {
    // Packing works in halves of 128 bits: put the quarters in order again.
    _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_packus_epi16(a, b))
}

/// Values done.
#[target_feature(enable = "avx2")]
pub(super) fn pair_means_avx2(rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 64;
    let (ones, two) = (_mm256_set1_epi8(1), _mm256_set1_epi16(2));
    for i in 0..blocks {
        let mut means = [_mm256_setzero_si256(); 2];
        for (half, mean) in means.iter_mut().enumerate() {
            let at = i * 64 + half * 32;
            let upper = _mm256_maddubs_epi16(load_256(rows[0], at), ones);
            let lower = _mm256_maddubs_epi16(load_256(rows[1], at), ones);
            let sum = _mm256_add_epi16(_mm256_add_epi16(upper, lower), two);
            *mean = _mm256_srli_epi16::<2>(sum);
        }
        store_256(packed_256(means[0], means[1]), &mut out[i * 32..]);
    }
    blocks * 32
}

/// Values done.
#[target_feature(enable = "avx2")]
pub(super) fn pair_minima_avx2(rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    let blocks = rows[0].len() / 64;
    let low = _mm256_set1_epi16(0xff);
    for i in 0..blocks {
        let mut minima = [_mm256_setzero_si256(); 2];
        for (half, minimum) in minima.iter_mut().enumerate() {
            let at = i * 64 + half * 32;
            let rows = _mm256_min_epu8(load_256(rows[0], at), load_256(rows[1], at));
            let pairs = _mm256_min_epu8(rows, _mm256_srli_epi16::<8>(rows));
            *minimum = _mm256_and_si256(pairs, low);
        }
        store_256(packed_256(minima[0], minima[1]), &mut out[i * 32..]);
    }
    blocks * 32
}

/// Twelve bytes from `at` and twelve after these, in the lower part of each half; four more of each are read and not used.
#[target_feature(enable = "avx2")]
fn load_twelves(bytes: &[u8], at: usize) -> __m256i {
    _mm256_set_m128i(load_128(bytes, at + 12), load_128(bytes, at))
}

/// Values done, always a multiple of 16.
#[target_feature(enable = "avx2")]
pub(super) fn three_to_two_avx2(full: &[u8], half: &[u8], out: &mut [u8]) -> usize {
    // The last block reads four bytes more than it uses.
    let blocks = full.len().saturating_sub(4) / 24;
    // Of each three bytes the first with the middle one, and the last with the middle one.
    let pairs = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 2, 1, 3, 4, 5, 4, 6, 7, 8, 7, 9, 10, 11, 10));
    let two_and_one = _mm256_set1_epi16(i16::from_le_bytes([2, 1]));
    // 7282 / 65536 is a ninth, near enough for all sums up to 2299.
    let (rounding, ninth) = (_mm256_set1_epi16(4), _mm256_set1_epi16(7282));
    for i in 0..blocks {
        let a = _mm256_maddubs_epi16(_mm256_shuffle_epi8(load_twelves(full, i * 24), pairs), two_and_one);
        let b = _mm256_maddubs_epi16(_mm256_shuffle_epi8(load_twelves(half, i * 24), pairs), two_and_one);
        let sum = _mm256_add_epi16(_mm256_add_epi16(a, a), _mm256_add_epi16(b, rounding));
        let mean = _mm256_mulhi_epu16(sum, ninth);
        let packed = _mm256_permute4x64_epi64::<0b00_00_10_00>(_mm256_packus_epi16(mean, mean));
        store_128(_mm256_castsi256_si128(packed), &mut out[i * 16..]);
    }
    blocks * 16
}

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn columns_avx2(words: &[u64], first: u16, out: &mut [u16]) -> usize {
    super::scalar::columns(words, first, out)
}

#[target_feature(enable = "avx512f,avx512bw")]
fn store_512(v: __m512i, to: &mut [u16]) {
    let to = &mut to[..32];
    // SAFETY: `to` has just been checked to hold the 64 bytes that are written; the store takes any alignment.
    unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), v) }
}

/// The numbers of 64 bytes, with those taken out whose bit is clear.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi2,popcnt")]
pub(super) fn columns_avx512(words: &[u64], first: u16, out: &mut [u16]) -> usize {
    let numbers: [u8; 64] = std::array::from_fn(|i| i as u8);
    let numbers = load_512(&numbers, 0);
    let mut count = 0;
    for (base, word) in (first..).step_by(64).zip(words) {
        let set = _mm512_maskz_compress_epi8(*word, numbers);
        let base = _mm512_set1_epi16(base as i16);
        let low = _mm512_cvtepu8_epi16(_mm512_castsi512_si256(set));
        store_512(_mm512_add_epi16(low, base), &mut out[count..]);
        let bits = word.count_ones() as usize;
        if bits > 32 {
            let high = _mm512_cvtepu8_epi16(_mm512_extracti64x4_epi64::<1>(set));
            store_512(_mm512_add_epi16(high, base), &mut out[count + 32..]);
        }
        count += bits;
    }
    count
}
