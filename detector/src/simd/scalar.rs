//! The kernels in plain Rust: the oracle of the others, and what runs where there is nothing better.

pub(super) fn tile_extrema(rows: [&[u8]; 4], minima: &mut [u8], maxima: &mut [u8]) {
    for (tile, (low, high)) in minima.iter_mut().zip(maxima).enumerate() {
        let from = tile * 4;
        let to = (from + 4).min(rows[0].len());
        (*low, *high) = (255, 0);
        for value in rows.iter().flat_map(|row| &row[from..to]) {
            *low = (*low).min(*value);
            *high = (*high).max(*value);
        }
    }
}

/// Smallest and largest value of each 2x2 tile of two rows. A loop that compilers make vectors of.
#[inline(always)]
pub(crate) fn pair_extrema(rows: [&[u8]; 2], minima: &mut [u8], maxima: &mut [u8]) {
    let ((upper, upper_rest), (lower, lower_rest)) = (rows[0].as_chunks::<2>(), rows[1].as_chunks::<2>());
    let tiles = upper.iter().zip(lower).zip(minima.iter_mut().zip(maxima.iter_mut()));
    for (([a, b], [c, d]), (low, high)) in tiles {
        *low = (*a).min(*b).min(*c).min(*d);
        *high = (*a).max(*b).max(*c).max(*d);
    }
    if let ([a], [b]) = (upper_rest, lower_rest) {
        minima[upper.len()] = *a.min(b);
        maxima[upper.len()] = *a.max(b);
    }
}

pub(super) fn threshold_row(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) {
    dark.fill(0);
    bright.fill(0);
    for (x, value) in row.iter().enumerate() {
        let cut = cuts[x];
        dark[x / 64] |= u64::from(*value < cut) << (x % 64);
        bright[x / 64] |= u64::from(*value >= cut && cut != 0) << (x % 64);
    }
}

/// Every `step`-th byte of `row`, from the first. With a step that the compiler knows it deals whole vectors out.
#[inline(always)]
pub(super) fn every(row: &[u8], step: usize, out: &mut [u8]) {
    let done = match step {
        3 => every_nth::<3>(row, out),
        4 => every_nth::<4>(row, out),
        5 => every_nth::<5>(row, out),
        6 => every_nth::<6>(row, out),
        7 => every_nth::<7>(row, out),
        8 => every_nth::<8>(row, out),
        _ => 0,
    };
    let (row, out) = (&row[done * step..], &mut out[done..]);
    let steps = row.chunks_exact(step);
    if let (Some(last), Some(value)) = (out.get_mut(steps.len()), steps.remainder().first()) {
        *last = *value;
    }
    for (to, from) in out.iter_mut().zip(steps) {
        *to = from[0];
    }
}

/// Values done.
#[inline(always)]
fn every_nth<const STEP: usize>(row: &[u8], out: &mut [u8]) -> usize {
    let steps = row.as_chunks::<STEP>().0;
    for (to, from) in out.iter_mut().zip(steps) {
        *to = from[0];
    }
    steps.len().min(out.len())
}

/// The mean of the 1.5 x 1.5 pixels of which one is covered whole, two by half and one by a quarter: of each row the whole
/// and the half column.
#[inline(always)]
pub(crate) fn average(full_row: [u8; 2], half_row: [u8; 2]) -> u8 {
    let column = |i: usize| 2 * u16::from(full_row[i]) + u16::from(half_row[i]);
    ((2 * column(0) + column(1) + 4) / 9) as u8
}

/// Three pixels of two rows, of which the second is covered by half, become two.
#[inline(always)]
pub(super) fn three_to_two(full: &[u8], half: &[u8], out: &mut [u8]) {
    let triples = full.as_chunks::<3>().0.iter().zip(half.as_chunks::<3>().0);
    for (to, (a, b)) in out.as_chunks_mut::<2>().0.iter_mut().zip(triples) {
        *to = [average([a[0], a[1]], [b[0], b[1]]), average([a[2], a[1]], [b[2], b[1]])];
    }
}

/// Numbers that are written at once, whether there are so many or not: a loop that ends with the last bit of a word is
/// mispredicted nearly every time, and few words have more.
const BLOCK: usize = 8;

#[inline(always)]
pub(super) fn columns(words: &[u64], first: u16, out: &mut [u16]) -> usize {
    let mut count = 0;
    for (base, word) in (first..).step_by(64).zip(words) {
        let mut bits = *word;
        if bits == 0 {
            continue;
        }
        let end = count + bits.count_ones() as usize;
        while count < end {
            for column in &mut out[count..count + BLOCK] {
                *column = base + bits.trailing_zeros() as u16;
                bits &= bits.wrapping_sub(1);
            }
            count += BLOCK;
        }
        count = end;
    }
    count
}
