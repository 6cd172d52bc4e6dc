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

/// The smallest and the largest value of each tile of a row.
#[derive(Clone, Copy)]
pub(super) struct Extremes<'e> {
    pub(super) minima: &'e [[u8; LANES]],
    pub(super) maxima: &'e [[u8; LANES]],
}

impl<'e> Extremes<'e> {
    /// Both are whole [`LANES`].
    #[inline(always)]
    pub(super) fn new(minima: &'e [u8], maxima: &'e [u8]) -> Self {
        Self { minima: minima.as_chunks().0, maxima: maxima.as_chunks().0 }
    }
}

/// Buffers for one row of tiles: of three tiles below each other the extremes, and the largest range.
#[derive(Default)]
pub(super) struct Columns {
    pub(super) tiles: usize,
    pub(super) low: Vec<u8>,
    pub(super) high: Vec<u8>,
    pub(super) range: Vec<u8>,
}

impl Columns {
    /// Makes room for so many tiles.
    pub(super) fn resize(&mut self, tiles: usize) {
        self.tiles = tiles;
        // One before the first, one behind the last.
        let room = tiles.next_multiple_of(LANES) + 2;
        self.low.resize(room, NO_MINIMUM);
        self.high.resize(room, NO_MAXIMUM);
        self.range.resize(room, 0);
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
/// or more; whether there is one. `around` are the row above, the row itself and the one below; `cuts` are whole [`LANES`].
#[inline(always)]
pub(super) fn fill_row(around: [Extremes; 3], limit: u8, columns: &mut Columns, cuts: &mut [u8]) -> bool {
    let Columns { tiles, low, high, .. } = columns;
    let [above, row, below] = around;
    fold([above.minima, row.minima, below.minima], *tiles, low, u8::min);
    fold([above.maxima, row.maxima, below.maxima], *tiles, high, u8::max);
    let cuts = cuts.as_chunks_mut::<LANES>().0;
    let (low, high) = (beside(low, cuts.len()), beside(high, cuts.len()));
    for (i, to) in cuts.iter_mut().enumerate() {
        let (least, most) = (of_three(low, i, u8::min), of_three(high, i, u8::max));
        let mut cuts = [0; LANES];
        for l in 0..LANES {
            // Where there is no tile the least is above the most, and the difference 1.
            let range = most[l].wrapping_sub(least[l]);
            // The middle itself is dark; a range of 5 or more keeps the sum below 256.
            cuts[l] = if range >= limit { least[l] + range / 2 + 1 } else { 0 };
        }
        *to = cuts;
    }
    has_any(cuts)
}

/// Whether any tile has a cut.
#[inline(always)]
pub(super) fn has_any(cuts: &[[u8; LANES]]) -> bool {
    let mut any = [0; LANES];
    for cuts in cuts {
        for l in 0..LANES {
            any[l] |= cuts[l];
        }
    }
    any != [0; LANES]
}

/// From the first to the last tile that has a cut, in whole [`LANES`].
#[inline(always)]
pub(super) fn filled(cuts: &[u8]) -> Range<usize> {
    let blocks = cuts.as_chunks::<LANES>().0;
    let has_any = |block: &[u8; LANES]| has_any(std::slice::from_ref(block));
    let first = blocks.iter().position(has_any).unwrap_or(blocks.len());
    let end = blocks.iter().rposition(has_any).map_or(first, |last| last + 1);
    first * LANES..end * LANES
}

/// The extreme of three rows, column by column.
#[inline(always)]
fn fold(rows: [&[[u8; LANES]]; 3], tiles: usize, columns: &mut [u8], extreme: impl Fn(u8, u8) -> u8) {
    let to = columns[1..].as_chunks_mut::<LANES>().0;
    let rows = rows.map(|row| &row[..to.len()]);
    for (i, to) in to.iter_mut().enumerate() {
        *to = of_three(rows, i, &extreme);
    }
    repeat_ends(columns, tiles);
}

/// The extreme of the `i`-th block of three rows. Put down as a whole: one by one, not every compiler sees that they change nothing
/// that is read.
#[inline(always)]
pub(super) fn of_three(rows: [&[[u8; LANES]]; 3], i: usize, extreme: impl Fn(u8, u8) -> u8) -> [u8; LANES] {
    let [a, b, c] = [&rows[0][i], &rows[1][i], &rows[2][i]];
    let mut extremes = [0; LANES];
    for l in 0..LANES {
        extremes[l] = extreme(extreme(a[l], b[l]), c[l]);
    }
    extremes
}

/// The columns beside the first and the last tile are as these.
#[inline(always)]
pub(super) fn repeat_ends(columns: &mut [u8], tiles: usize) {
    columns[0] = columns[1];
    columns[tiles + 1] = columns[tiles];
}

/// So many blocks of the columns before, at and behind the tiles of a row.
#[inline(always)]
pub(super) fn beside(columns: &[u8], blocks: usize) -> [&[[u8; LANES]]; 3] {
    [columns, &columns[1..], &columns[2..]].map(|columns| &columns.as_chunks().0[..blocks])
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
            let around = [row.saturating_sub(1), row, (row + 1).min(4)].map(|row| {
                let places = row * LANES..(row + 1) * LANES;
                Extremes::new(&minima[places.clone()], &maxima[places])
            });
            let mut all = [9; LANES];
            assert_eq!(fill_row(around, 5, &mut columns, &mut all), row < 3, "row {row}");
            assert_eq!(all[5..], [0; LANES - 5], "where there is no tile");
            cuts.copy_from_slice(&all[..5]);
        }
        assert_eq!(cuts.at(0, 0), 20 + 100 + 1);
        assert_eq!(cuts.at(8, 8), 100 + 60 + 1, "sees tile (1,1) but not tile (0,0)");
        assert_eq!(cuts.at(19, 19), 0, "a range of 2 is no content");
    }
}
