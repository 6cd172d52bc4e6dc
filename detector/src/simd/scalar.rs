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

pub(super) fn threshold_row(row: &[u8], cuts: &[u8], dark: &mut [u64], bright: &mut [u64]) {
    dark.fill(0);
    bright.fill(0);
    for (x, value) in row.iter().enumerate() {
        let cut = cuts[x / 4];
        dark[x / 64] |= u64::from(*value < cut) << (x % 64);
        bright[x / 64] |= u64::from(*value >= cut && cut != 0) << (x % 64);
    }
}
