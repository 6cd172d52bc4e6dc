//! The threshold of every tile.

use std::ops::Range;

/// One threshold a tile: pixels below it are dark, the others bright; 0 marks a tile without contrast around it.
#[derive(Default)]
pub(crate) struct Cuts {
    /// Tiles a row.
    tiles: usize,
    /// Binary logarithm of a tile's width in pixels.
    shift: u32,
    values: Vec<u8>,
}

/// Tiles that are worked on at once: extremes, and cuts as they are made, fill whole vectors. What lies behind a row's last tile
/// is no tile's: [`NO_MINIMUM`] and [`NO_MAXIMUM`].
pub(super) const LANES: usize = 32;
pub(super) const NO_MINIMUM: u8 = 255;
pub(super) const NO_MAXIMUM: u8 = 0;

/// Buffers for one row of tiles: the extremes of three tiles below each other.
#[derive(Default)]
pub(super) struct Columns {
    tiles: usize,
    low: Vec<u8>,
    high: Vec<u8>,
}

impl Columns {
    /// Makes room for so many tiles.
    pub(super) fn resize(&mut self, tiles: usize) {
        self.tiles = tiles;
        // One before the first, one behind the last.
        let room = tiles.next_multiple_of(LANES) + 2;
        self.low.resize(room, NO_MINIMUM);
        self.high.resize(room, NO_MAXIMUM);
    }
}

impl Cuts {
    /// The cut of the tile that pixel (x, y) of the search grid lies in.
    #[inline(always)]
    pub(crate) fn at(&self, x: usize, y: usize) -> u8 {
        self.values[(y >> self.shift) * self.tiles + (x >> self.shift)]
    }

    /// Makes room for so many tiles of this width.
    pub(super) fn resize(&mut self, tile: usize, tiles: usize, rows: usize) {
        self.tiles = tiles;
        self.shift = tile.ilog2();
        self.values.resize(tiles * rows, 0);
    }

    /// So many rows of tiles at a time.
    pub(super) fn chunks_mut(&mut self, rows: usize) -> std::slice::ChunksMut<'_, u8> {
        self.values.chunks_mut(rows * self.tiles)
    }
}

/// The cuts of one row of tiles of `TILE` pixels, one for each pixel.
#[inline(always)]
pub(super) fn spread<const TILE: usize>(cuts: &[u8], pixels: &mut [u8]) {
    let (tiles, rest) = pixels.as_chunks_mut::<TILE>();
    for (tile, cut) in tiles.iter_mut().zip(cuts) {
        *tile = [*cut; TILE];
    }
    rest.fill(cuts[cuts.len() - 1]);
}

/// The cuts of a row of tiles, at the middle between the extremes of the 3x3 tiles around each, where these differ by `limit`
/// or more. `around` are the places of the row above, the row itself and the one below among the extremes; like `cuts` whole
/// [`LANES`].
#[inline(always)]
pub(super) fn fill_row(
    around: [Range<usize>; 3],
    minima: &[u8],
    maxima: &[u8],
    limit: u8,
    columns: &mut Columns,
    cuts: &mut [u8],
) {
    let Columns { tiles, low, high } = columns;
    fold_column(around.clone().map(|places| &minima[places]), *tiles, low, u8::min);
    fold_column(around.map(|places| &maxima[places]), *tiles, high, u8::max);
    cut_row(low, high, limit, cuts);
}

/// The extreme of three rows, column by column, with the ends repeated once.
#[inline(always)]
fn fold_column(rows: [&[u8]; 3], tiles: usize, out: &mut [u8], extreme: impl Fn(u8, u8) -> u8) {
    let [above, row, below] = [rows[0], rows[1], rows[2]];
    let rows = above.as_chunks::<LANES>().0.iter().zip(row.as_chunks().0).zip(below.as_chunks().0);
    for (to, ((above, row), below)) in out[1..].as_chunks_mut::<LANES>().0.iter_mut().zip(rows) {
        let (above, row, below): (_, &[u8; LANES], &[u8; LANES]) = (above, row, below);
        // Put down as a whole: one by one, not every compiler sees that they change nothing that is read.
        let mut extremes = [0; LANES];
        for l in 0..LANES {
            extremes[l] = extreme(extreme(above[l], row[l]), below[l]);
        }
        *to = extremes;
    }
    out[0] = out[1];
    out[tiles + 1] = out[tiles];
}

#[inline(always)]
fn cut_row(low: &[u8], high: &[u8], limit: u8, cuts: &mut [u8]) {
    const AROUND: usize = LANES + 2;
    for (i, cuts) in cuts.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let low: &[u8] = &low[i * LANES..][..AROUND];
        let high: &[u8] = &high[i * LANES..][..AROUND];
        for l in 0..LANES {
            let least = low[l].min(low[l + 1]).min(low[l + 2]);
            let most = high[l].max(high[l + 1]).max(high[l + 2]);
            // Where there is no tile the least is above the most, and the difference 1.
            let range = most.wrapping_sub(least);
            // The middle itself is dark; a range of 5 or more keeps the sum below 256.
            cuts[l] = if range >= limit { least + range / 2 + 1 } else { 0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_cut_at_the_middle_of_the_extremes_around_it() {
        let (mut minima, mut maxima) = (vec![NO_MINIMUM; 5 * LANES], vec![NO_MAXIMUM; 5 * LANES]);
        for row in 0..5 {
            minima[row * LANES..][..5].fill(100);
            maxima[row * LANES..][..5].fill(102);
        }
        minima[0] = 20;
        maxima[LANES + 1] = 220;
        let (mut cuts, mut columns) = (Cuts::default(), Columns::default());
        cuts.resize(4, 5, 5);
        columns.resize(5);
        for (row, cuts) in cuts.chunks_mut(1).enumerate() {
            let around = [row.saturating_sub(1), row, (row + 1).min(4)];
            let (around, mut all) = (around.map(|row| row * LANES..(row + 1) * LANES), [9; LANES]);
            fill_row(around, &minima, &maxima, 5, &mut columns, &mut all);
            assert_eq!(all[5..], [0; LANES - 5], "where there is no tile");
            cuts.copy_from_slice(&all[..5]);
        }
        assert_eq!(cuts.at(0, 0), 20 + 100 + 1);
        assert_eq!(cuts.at(8, 8), 100 + 60 + 1, "sees tile (1,1) but not tile (0,0)");
        assert_eq!(cuts.at(19, 19), 0, "a range of 2 is no content");
    }
}
