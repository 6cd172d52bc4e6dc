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

/// Buffers for one row of tiles: the extremes of three tiles below each other.
#[derive(Default)]
pub(super) struct Columns([Vec<u8>; 2]);

impl Columns {
    /// Makes room for so many tiles.
    pub(super) fn resize(&mut self, tiles: usize) {
        self.0.iter_mut().for_each(|buffer| buffer.resize(tiles + 2, 0));
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
/// or more. `around` are the places of the row above, the row itself and the one below among the extremes.
#[inline(always)]
pub(super) fn fill_row(
    around: [Range<usize>; 3],
    minima: &[u8],
    maxima: &[u8],
    limit: u8,
    columns: &mut Columns,
    cuts: &mut [u8],
) {
    let Columns([low, high]) = columns;
    fold_column(around.clone().map(|places| &minima[places]), low, u8::min);
    fold_column(around.map(|places| &maxima[places]), high, u8::max);
    cut_row(low, high, limit, cuts);
}

/// The extreme of three rows, column by column, with the ends repeated once.
#[inline(always)]
fn fold_column(rows: [&[u8]; 3], out: &mut [u8], extreme: impl Fn(u8, u8) -> u8) {
    let tiles = rows[0].len();
    for (i, to) in out[1..=tiles].iter_mut().enumerate() {
        *to = extreme(extreme(rows[0][i], rows[1][i]), rows[2][i]);
    }
    out[0] = out[1];
    out[tiles + 1] = out[tiles];
}

#[inline(always)]
fn cut_row(low: &[u8], high: &[u8], limit: u8, cuts: &mut [u8]) {
    let tiles = cuts.len();
    let (low, high) = (&low[..tiles + 2], &high[..tiles + 2]);
    for (i, cut) in cuts.iter_mut().enumerate() {
        let least = low[i].min(low[i + 1]).min(low[i + 2]);
        let most = high[i].max(high[i + 1]).max(high[i + 2]);
        let range = most - least;
        // The middle itself is dark; a range of 5 or more keeps the sum below 256.
        *cut = if range >= limit { least + range / 2 + 1 } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_cut_at_the_middle_of_the_extremes_around_it() {
        let (mut minima, mut maxima) = (vec![100; 25], vec![102; 25]);
        minima[0] = 20;
        maxima[6] = 220;
        let (mut cuts, mut columns) = (Cuts::default(), Columns::default());
        cuts.resize(4, 5, 5);
        columns.resize(5);
        for (row, cuts) in cuts.chunks_mut(1).enumerate() {
            let around = [row.saturating_sub(1), row, (row + 1).min(4)].map(|row| row * 5..row * 5 + 5);
            fill_row(around, &minima, &maxima, 5, &mut columns, cuts);
        }
        assert_eq!(cuts.at(0, 0), 20 + 100 + 1);
        assert_eq!(cuts.at(8, 8), 100 + 60 + 1, "sees tile (1,1) but not tile (0,0)");
        assert_eq!(cuts.at(19, 19), 0, "a range of 2 is no content");
    }
}
