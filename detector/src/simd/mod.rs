//! The pixel kernels, each with a scalar twin that is obviously right; and which of them this processor can run.

#![allow(unsafe_code, reason = "this folder is the place that the conventions name for intrinsics")]

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod blocks;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
mod samples;
mod scalar;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use level::Kernel;
pub use level::{Level, UnknownLevel};
pub(crate) use samples::{Crossings, LANES, Pixels, Sides};

use level::Kind;
pub(crate) use scalar::{average, pair_extrema};

/// Pixels along a tile of the search with larger ones.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
const TILE: usize = 4;

/// Smallest and largest value of each 4x4 tile of four rows. `rows` are equally long; a partial tile at the right end
/// uses the pixels that it has. `minima` and `maxima` take `rows[0].len().div_ceil(4)` values.
pub(crate) fn tile_extrema(level: Level, rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) {
    let done = match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        Kind::Avx2 => unsafe { x86::tile_extrema_avx2(rows, minima, maxima) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX-512 BW and VL (Level::available).
        Kind::Avx512 => return unsafe { x86::tile_extrema_avx512(rows, minima, maxima) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::tile_extrema(rows, minima, maxima) },
        _ => 0,
    };
    if done < rows[0].len() {
        let rest = rows.map(|row| &row[done..]);
        scalar::tile_extrema(rest, &mut minima[done / 4..], &mut maxima[done / 4..]);
    }
}

/// The bit planes of one row: a pixel is dark when it lies below its cut, bright when not; a cut of 0 marks one that is neither.
/// `cuts` are as many as pixels. Bit `x % 64` of word `x / 64`; bits past the row are clear.
pub(crate) fn threshold_row(level: Level, row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) {
    let done = match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        Kind::Avx2 => unsafe { x86::threshold_row_avx2(row, cuts, dark, bright) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX-512 BW and VL (Level::available).
        Kind::Avx512 => return unsafe { x86::threshold_row_avx512(row, cuts, dark, bright) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::threshold_row(row, cuts, dark, bright) },
        _ => 0,
    };
    // Words from here on are not begun yet.
    let word = done.div_ceil(64);
    scalar::threshold_row(&row[done..], &cuts[done..], &mut dark[word..], &mut bright[word..]);
}

/// Reads a byte of every line of a cache, so that all of them are near when they are needed. Lines that follow each other are
/// foreseen by the processor; read as tiles need them, four rows at a time, most are waited for. `rows` are equally long and lie
/// far apart; their lines are read by turns, as some processors foresee one line or two in each place. Not on other architectures,
/// where nobody has measured it.
#[inline(always)]
pub(crate) fn touch<const ROWS: usize>(rows: [&[u8]; ROWS]) {
    const LINE: usize = 64;
    if cfg!(target_arch = "x86_64") {
        let (mut sum, mut at) = (0, 0);
        while at < rows[0].len() {
            for row in rows {
                sum |= row[at];
            }
            at += LINE;
        }
        std::hint::black_box(sum);
    }
}

/// Steps from which on a vector of 64 bytes holds two values or one, which are quicker read one by one.
#[cfg(target_arch = "x86_64")]
const FEW_IN_A_VECTOR: usize = 32;

/// Every `step`-th byte of `row`, from the first; `out` takes them all.
#[inline(always)]
pub(crate) fn every(level: Level, row: &[u8], step: usize, out: &mut [u8]) {
    let done = match (level.kind(), step) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        (Kind::Avx2 | Kind::Avx512, 2) => unsafe { x86::every_second_avx2(row, out) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX-512 VBMI2 and VL (Level::available).
        (Kind::Avx512, 3..FEW_IN_A_VECTOR) => return unsafe { x86::every_avx512(row, step, out) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        (Kind::Neon, 2) => unsafe { neon::every_second(row, out) },
        _ => 0,
    };
    scalar::every(&row[done * step..], step, &mut out[done..]);
}

/// A row of the grid on which three pixels become two, from the row that is covered whole and the one that is covered by
/// half. `out` takes two values for every three of the rows, which are equally long.
pub(crate) fn three_to_two(level: Level, full: &[u8], half: &[u8], out: &mut [u8]) {
    let done = match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        Kind::Avx2 | Kind::Avx512 => unsafe { x86::three_to_two_avx2(full, half, out) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::three_to_two(full, half, out) },
        _ => 0,
    };
    let pixels = done / 2 * 3;
    scalar::three_to_two(&full[pixels..], &half[pixels..], &mut out[done..]);
}

/// The mean of each 2x2 pixels of two equally long rows, rounded; says how many of `out` are done.
pub(crate) fn pair_means(level: Level, rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        Kind::Avx2 | Kind::Avx512 => unsafe { x86::pair_means_avx2(rows, out) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::pair_means(rows, out) },
        _ => 0,
    }
}

/// The least of each 2x2 pixels of two equally long rows; says how many of `out` are done.
pub(crate) fn pair_minima(level: Level, rows: [&[u8]; 2], out: &mut [u8]) -> usize {
    match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX2 (Level::available).
        Kind::Avx2 | Kind::Avx512 => unsafe { x86::pair_minima_avx2(rows, out) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::pair_minima(rows, out) },
        _ => 0,
    }
}

/// Entries that `columns` may write, without meaning, behind those that it returns.
pub(crate) const COLUMNS_SLACK: usize = 64;

/// The numbers of the set bits of some words of a row, in order, and how many there are; `first` is the number of the first bit.
/// `out` has room for a number for every bit and for [`COLUMNS_SLACK`] more.
pub(crate) fn columns(level: Level, words: &[u64], first: u16, out: &mut [u16]) -> usize {
    match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has AVX-512 VBMI2 (Level::available).
        Kind::Avx512 => unsafe { x86::columns_avx512(words, first, out) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a Level of this kind is only made where the processor has BMI (Level::available).
        Kind::Avx2 => unsafe { x86::columns_avx2(words, first, out) },
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::columns(words, first, out) },
        _ => scalar::columns(words, first, out),
    }
}

/// Whether points lie between the outermost pixel centres, so that they have a grey value: 1 or 0.
#[inline(always)]
pub(crate) fn contains(level: Level, pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    match level.kind() {
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::contains(pixels, x, y) },
        // Compilers make vectors of it elsewhere.
        _ => samples::contains(pixels, x, y),
    }
}

/// The grey values at points, bilinear between the four pixel centres around each (paper III-D). Those outside of the frame have
/// the value of a place at its rim.
#[inline(always)]
pub(crate) fn values(level: Level, pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    #[cfg(target_arch = "aarch64")]
    if let (Kind::Neon, Some(last_square)) = (level.kind(), pixels.last_square()) {
        // SAFETY: NEON belongs to the baseline of this architecture.
        return unsafe { neon::values(pixels, last_square, x, y) };
    }
    match level.kind() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: levels of these kinds are only made where the processor has AVX2 (Level::available).
        Kind::Avx2 | Kind::Avx512 => unsafe { x86::values_avx2(pixels, x, y) },
        _ => samples::values(pixels, x, y),
    }
}

/// The `k`-th step of this length of a search for crossings, from the values `before` to those `now`; says whether anything is
/// still looked for.
#[inline(always)]
pub(crate) fn look(
    level: Level,
    crossings: &mut Crossings,
    k: f32,
    step: f32,
    before: &Sides,
    now: &Sides,
) -> bool {
    match level.kind() {
        #[cfg(target_arch = "aarch64")]
        // SAFETY: NEON belongs to the baseline of this architecture.
        Kind::Neon => unsafe { neon::look(crossings, k, step, before, now) },
        // Compilers make vectors of it elsewhere.
        _ => crossings.look(k, step, before, now),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{Geometry, LumaView};

    /// A small seeded generator (xorshift64*), enough for pixels.
    struct Random(u64);

    impl Random {
        fn byte(&mut self) -> u8 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 56) as u8
        }

        fn bytes(&mut self, count: usize) -> Vec<u8> {
            (0..count).map(|_| self.byte()).collect()
        }
    }

    #[test]
    fn every_level_gives_the_scalar_tile_extrema_at_every_length_and_alignment() {
        let mut random = Random(7);
        for length in 1..=200 {
            for start in [0, 1, 3, 17] {
                let rows: Vec<Vec<u8>> = (0..4).map(|_| random.bytes(start + length)).collect();
                let rows = [&rows[0][start..], &rows[1][start..], &rows[2][start..], &rows[3][start..]];
                let tiles = length.div_ceil(4);
                let (mut low, mut high) = (vec![0; tiles], vec![0; tiles]);
                scalar::tile_extrema(rows, &mut low, &mut high);
                for level in Level::available() {
                    let (mut a, mut b) = (vec![9; tiles], vec![9; tiles]);
                    tile_extrema(level, rows, &mut a, &mut b);
                    assert_eq!((&a, &b), (&low, &high), "{level} at length {length}");
                }
            }
        }
    }

    #[test]
    fn every_level_gives_the_scalar_bit_planes_at_every_length_and_alignment() {
        let mut random = Random(11);
        for length in 1..=400 {
            let start = length % 5;
            let row = random.bytes(start + length);
            let row = &row[start..];
            let cuts: Vec<u8> =
                random.bytes(length).iter().map(|c| if c % 3 == 0 { 0 } else { *c }).collect();
            let words = length / 64 + 1;
            let (mut dark, mut bright) = (vec![1; words], vec![1; words]);
            scalar::threshold_row(row, &cuts, &mut dark, &mut bright);
            for level in Level::available() {
                let (mut a, mut b) = (vec![5; words], vec![5; words]);
                threshold_row(level, row, &cuts, &mut a, &mut b);
                assert_eq!((&a, &b), (&dark, &bright), "{level} at length {length}");
            }
        }
    }

    #[test]
    fn every_level_picks_the_scalar_bytes_at_every_length_and_step() {
        let mut random = Random(13);
        for length in 1..=900 {
            let row = random.bytes(length);
            for step in (1..=8).chain([12, 31, 64, 70]) {
                let expected: Vec<u8> = row.iter().copied().step_by(step).collect();
                for level in Level::available() {
                    let mut out = vec![9; expected.len()];
                    every(level, &row, step, &mut out);
                    assert_eq!(out, expected, "{level}, step {step}, length {length}");
                }
            }
        }
    }

    #[test]
    fn every_level_gives_the_scalar_averages_of_three_to_two_at_every_length() {
        let mut random = Random(17);
        for triples in 1..=100 {
            let (mut full, mut half) = (random.bytes(3 * triples), random.bytes(3 * triples));
            // The largest sums must not overflow.
            full[0..2].fill(255);
            half[0..2].fill(255);
            let mut expected = vec![0; 2 * triples];
            scalar::three_to_two(&full, &half, &mut expected);
            assert_eq!(expected[0], 255);
            for level in Level::available() {
                let mut out = vec![9; 2 * triples];
                three_to_two(level, &full, &half, &mut out);
                assert_eq!(out, expected, "{level}, {triples} triples");
            }
        }
    }

    #[test]
    fn every_level_lists_the_set_bits_in_order() {
        let mut random = Random(19);
        for words in 1..=20 {
            let first = words % 3 * 64;
            for density in [0, 20, 128, 250, 255] {
                let mut bit = || u64::from(random.byte() <= density && density > 0);
                let row: Vec<u64> = (0..words).map(|_| (0..64).map(|i| bit() << i).sum()).collect();
                let is_set = |column: &u16| row[usize::from(column / 64)] >> (column % 64) & 1 == 1;
                let expected: Vec<u16> =
                    (0..words * 64).filter(is_set).map(|column| first + column).collect();
                for level in Level::available() {
                    let mut out = vec![9; row.len() * 64 + COLUMNS_SLACK];
                    let count = columns(level, &row, first, &mut out);
                    assert_eq!(out[..count], expected, "{level}, {words} words");
                }
            }
        }
    }

    #[test]
    fn every_level_gives_the_scalar_values_between_pixels_at_every_step_and_outside_of_the_frame() {
        let mut random = Random(23);
        let (width, height) = (23, 9);
        for step in [1, 2, 3] {
            let stride = width * step + 5;
            let bytes = random.bytes(3 + stride * (height - 1) + (width - 1) * step + 1);
            let geometry = Geometry { offset: 3, width, height, row_stride: stride, pixel_step: step };
            let pixels = Pixels::new(&LumaView::new(&bytes, geometry).unwrap());
            for round in 0..400 {
                let mut coordinate = |side: usize| {
                    let share = (f32::from(random.byte()) + f32::from(random.byte()) / 256.0) / 255.0;
                    match round % 8 {
                        0 => {
                            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9][(share * 3.0).round() as usize]
                        }
                        1 => (share * side as f32).round() + 0.5,
                        _ => share * (side as f32 + 4.0) - 2.0,
                    }
                };
                let x: [f32; LANES] = std::array::from_fn(|_| coordinate(width));
                let y: [f32; LANES] = std::array::from_fn(|_| coordinate(height));
                let expected = samples::values(&pixels, &x, &y);
                let inside = samples::contains(&pixels, &x, &y);
                for level in Level::available() {
                    assert_eq!(contains(level, &pixels, &x, &y), inside, "{level}, {x:?}, {y:?}");
                    assert_eq!(
                        values(level, &pixels, &x, &y),
                        expected,
                        "{level}, step {step}, {x:?}, {y:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_level_finds_the_scalar_crossings() {
        let mut random = Random(29);
        let mut side = || std::array::from_fn(|_| (f32::from(random.byte()) - 128.0) / 8.0);
        for round in 0..500 {
            let places: [Sides; 4] = std::array::from_fn(|_| [side(), side()]);
            let found = |level: Option<Level>| {
                let mut crossings = Crossings {
                    shifts: [f32::NAN; LANES],
                    is_open: std::array::from_fn(|i| (i != 3) as u8 as f32),
                };
                let mut open = Vec::new();
                for k in 1..places.len() {
                    let (before, now) = (&places[k - 1], &places[k]);
                    open.push(match level {
                        Some(level) => look(level, &mut crossings, k as f32, 0.4, before, now),
                        None => crossings.look(k as f32, 0.4, before, now),
                    });
                }
                (crossings.shifts.map(f32::to_bits), crossings.is_open, open)
            };
            for level in Level::available() {
                assert_eq!(found(Some(level)), found(None), "{level}, round {round}");
            }
        }
    }
}
