//! The threshold of every tile.

/// One threshold a tile: pixels below it are dark, the others bright; 0 marks a tile without contrast around it.
#[derive(Default)]
pub(crate) struct Cuts {
    /// Tiles a row.
    pub(super) tiles: usize,
    /// Binary logarithm of a tile's width in pixels.
    shift: u32,
    pub(super) values: Vec<u8>,
    columns: [Vec<u8>; 2],
}

impl Cuts {
    /// The cut of the tile that pixel (x, y) of the search grid lies in.
    #[inline(always)]
    pub(crate) fn at(&self, x: usize, y: usize) -> u8 {
        self.values[(y >> self.shift) * self.tiles + (x >> self.shift)]
    }

    /// The cuts of one row of tiles of `TILE` pixels, one for each pixel.
    #[inline(always)]
    pub(super) fn spread<const TILE: usize>(&self, tile_row: usize, pixels: &mut [u8]) {
        let cuts = &self.values[tile_row * self.tiles..][..self.tiles];
        let (tiles, rest) = pixels.as_chunks_mut::<TILE>();
        for (tile, cut) in tiles.iter_mut().zip(cuts) {
            *tile = [*cut; TILE];
        }
        rest.fill(cuts[cuts.len() - 1]);
    }

    /// Makes room for so many tiles of this width.
    pub(super) fn resize(&mut self, tile: usize, tiles: usize, rows: usize) {
        self.tiles = tiles;
        self.shift = tile.ilog2();
        self.values.resize(tiles * rows, 0);
        for buffer in &mut self.columns {
            buffer.resize(tiles + 2, 0);
        }
    }

    /// Cuts of a row of tiles, at the middle between the extremes of the 3x3 tiles around each, where these differ by `limit`
    /// or more.
    #[inline(always)]
    pub(super) fn fill_row(&mut self, row: usize, minima: &[u8], maxima: &[u8], limit: u8) {
        let tiles = self.tiles;
        let last = self.values.len() / tiles - 1;
        let around = [row.saturating_sub(1), row, (row + 1).min(last)];
        let [low, high] = &mut self.columns;
        fold_column(rows_of(minima, tiles, around), low, u8::min);
        fold_column(rows_of(maxima, tiles, around), high, u8::max);
        cut_row(low, high, limit, &mut self.values[row * tiles..][..tiles]);
    }
}

#[inline(always)]
fn rows_of(values: &[u8], tiles: usize, [above, row, below]: [usize; 3]) -> [&[u8]; 3] {
    [&values[above * tiles..][..tiles], &values[row * tiles..][..tiles], &values[below * tiles..][..tiles]]
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
        let mut cuts = Cuts::default();
        cuts.resize(4, 5, 5);
        (0..5).for_each(|row| cuts.fill_row(row, &minima, &maxima, 5));
        assert_eq!(cuts.at(0, 0), 20 + 100 + 1);
        assert_eq!(cuts.at(8, 8), 100 + 60 + 1, "sees tile (1,1) but not tile (0,0)");
        assert_eq!(cuts.at(19, 19), 0, "a range of 2 is no content");
    }
}
