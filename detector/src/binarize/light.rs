//! Light that falls off over a wall is no content.
//!
//! Three tiles of a decimated picture are wide in the frame: light that changes slowly changes more over them than noise does
//! over one. Edges are sharp there, so that content has its contrast within a single tile somewhere in the window. A window
//! whose tiles are all even is content only if much contrast lies between them, as where an edge runs along their seams.

use super::cuts::{Columns, Extremes, LANES, beside, has_any, of_three, repeat_ends};

/// From how many pixels of the frame a value on edges are that sharp: those of a blurred picture have both their sides within
/// three values then.
pub(super) const LEAST_PITCH: f64 = 4.0;

/// Clears the cuts where the range around a tile is the light's; whether one is left. `limit` is the contrast that the frame's
/// noise asks of a window, and `columns` are what the cuts were made of.
#[inline(always)]
pub(super) fn clear_uneven_light(
    around: [Extremes; 3],
    limit: u8,
    columns: &mut Columns,
    cuts: &mut [u8],
) -> bool {
    // Of a tile noise asks a little less than of nine.
    let (within_a_tile, between_tiles) = (limit - limit / 4, 2 * limit);
    fold_ranges(around, columns);
    let cuts = cuts.as_chunks_mut::<LANES>().0;
    let [low, high, range] = [&columns.low, &columns.high, &columns.range].map(|all| beside(all, cuts.len()));
    for (i, to) in cuts.iter_mut().enumerate() {
        let (least, most) = (of_three(low, i, u8::min), of_three(high, i, u8::max));
        let (within, mut cuts) = (of_three(range, i, u8::max), *to);
        for l in 0..LANES {
            let is_light = (within[l] < within_a_tile) & (most[l].wrapping_sub(least[l]) < between_tiles);
            cuts[l] = if is_light { 0 } else { cuts[l] };
        }
        *to = cuts;
    }
    has_any(cuts)
}

/// The largest range of three tiles below each other, column by column.
#[inline(always)]
fn fold_ranges(around: [Extremes; 3], columns: &mut Columns) {
    for (i, to) in columns.range[1..].as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let mut largest = [0; LANES];
        for row in around {
            let (minima, maxima) = (&row.minima[i], &row.maxima[i]);
            for l in 0..LANES {
                largest[l] = largest[l].max(maxima[l].wrapping_sub(minima[l]));
            }
        }
        *to = largest;
    }
    repeat_ends(&mut columns.range, columns.tiles);
}

#[cfg(test)]
mod tests {
    use super::super::cuts::{NO_MAXIMUM, NO_MINIMUM, fill_row};
    use super::*;

    const TILES: usize = 40;
    const LIMIT: u8 = 14;

    /// The cuts of a row of tiles whose extremes are these, and those above and below too, before and after.
    fn cuts(extremes: impl Fn(usize) -> [u8; 2]) -> [Vec<u8>; 2] {
        let (mut minima, mut maxima) = (vec![NO_MINIMUM; 2 * LANES], vec![NO_MAXIMUM; 2 * LANES]);
        for tile in 0..TILES {
            [minima[tile], maxima[tile]] = extremes(tile);
        }
        let around = [Extremes::new(&minima, &maxima); 3];
        let (mut columns, mut before) = (Columns::default(), vec![9; 2 * LANES]);
        columns.resize(TILES);
        assert!(fill_row(around, LIMIT, &mut columns, &mut before));
        let mut after = before.clone();
        let is_left = clear_uneven_light(around, LIMIT, &mut columns, &mut after);
        assert_eq!(is_left, after.iter().any(|cut| *cut > 0));
        [before, after].map(|cuts| cuts[..TILES].to_vec())
    }

    #[test]
    fn light_that_falls_off_from_tile_to_tile_has_no_cuts() {
        let [before, after] = cuts(|tile| [100 + 3 * tile as u8, 109 + 3 * tile as u8]);
        assert!(before[1..TILES - 1].iter().all(|cut| *cut > 0), "{before:?}");
        assert_eq!(after, [0; TILES]);
    }

    #[test]
    fn what_has_contrast_within_a_tile_keeps_its_cuts() {
        let [before, after] = cuts(|tile| [100, if tile == 33 { 114 } else { 104 }]);
        assert_eq!(after, before);
        assert_eq!(after.iter().filter(|cut| **cut > 0).count(), 3);
    }

    #[test]
    fn an_edge_between_two_tiles_keeps_its_cuts() {
        let edge =
            |height: u8| cuts(move |tile| if tile < 20 { [100, 104] } else { [96 + height, 100 + height] });
        let [before, after] = edge(2 * LIMIT);
        assert_eq!(after, before);
        let [before, after] = edge(2 * LIMIT - 1);
        assert!(before[19] > 0 && after == [0; TILES], "{before:?}");
    }
}
