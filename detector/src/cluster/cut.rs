//! How a plane is cut into bands of rows: so that each has as many runs as the others, if the frame is like the one before.
//!
//! Where the cuts are changes nothing of what is found.

use std::ops::Range;

use super::Plane;
use super::band::{Band, Rows};
use super::components::Limits;
use super::labels::Connectivity;

/// Fewer rows are not worth a seam.
pub(super) const LEAST_ROWS: usize = 32;
/// What a row costs besides its runs, in runs.
const ROW: usize = 16;
/// How much of a plane's cost lies in the bands that threads begin with, in thousandths.
const LARGE: usize = 800;

/// Bands of a plane, from top to bottom.
#[derive(Default)]
pub(super) struct Cut {
    /// One past the last row of each.
    ends: Vec<usize>,
}

impl Cut {
    /// Cuts `height` rows into so many bands of the same number of rows, but for the last ones.
    pub(super) fn evenly(&mut self, height: usize, bands: usize) {
        let rows = height.div_ceil(bands);
        self.ends.clear();
        self.ends.extend((1..=height.div_ceil(rows)).map(|band| (band * rows).min(height)));
    }

    /// Cuts by what these bands cost, which are of another plane of this height: as if they held what this plane does.
    pub(super) fn by_runs(&mut self, height: usize, bands: usize, before: &[Band]) {
        let rows: usize = before.iter().map(|band| band.runs.rows()).sum();
        self.evenly(height, bands);
        // As many rows in each may give fewer bands than were asked for.
        let bands = self.bands();
        if rows != height || height < bands * LEAST_ROWS {
            return;
        }
        let all = before.iter().map(cost).sum::<usize>();
        for band in 1..bands {
            let row = row_at(before, all * thousandths_before(band, bands) / 1000);
            let (least, most) =
                (self.rows(band - 1).start + LEAST_ROWS, height - (bands - band) * LEAST_ROWS);
            self.ends[band - 1] = row.clamp(least, most);
        }
    }

    pub(super) fn bands(&self) -> usize {
        self.ends.len()
    }

    /// The rows of a band.
    pub(super) fn rows(&self, band: usize) -> Range<usize> {
        let start = if band == 0 { 0 } else { self.ends[band - 1] };
        start..self.ends[band]
    }

    /// The band that a row lies in.
    pub(super) fn band_of(&self, row: usize) -> usize {
        self.ends.partition_point(|end| *end <= row)
    }

    /// What a plane has in the rows of a band.
    pub(super) fn rows_of<'a>(&self, plane: &Plane<'a>, limits: &Limits, band: usize) -> Rows<'a> {
        let (rows, words) = (self.rows(band), plane.words);
        Rows {
            bits: &plane.bits[rows.start * words..rows.end * words],
            blank: &plane.blank[rows.clone()],
            words,
            first: rows.start,
            may_drop_specks: limits.area > 1 && plane.connectivity == Connectivity::Four,
        }
    }
}

/// How much of a plane's cost is to lie before a band that is not the first. The caller begins with the first band, workers with the
/// last ones: these are large, so that a thread outlines what it labelled itself and has near. As many small ones between them are
/// for whoever is done first.
fn thousandths_before(band: usize, bands: usize) -> usize {
    if bands < 4 || !bands.is_multiple_of(2) {
        return 1000 * band / bands;
    }
    let threads = bands / 2;
    let small = (band - 1).min(threads);
    (LARGE * (band - small) + (1000 - LARGE) * small) / threads
}

/// What a band cost, in runs.
fn cost(band: &Band) -> usize {
    band.runs.before(band.runs.rows()) + ROW * band.runs.rows()
}

/// The first row, counted through all bands, before which there is so much of the cost.
fn row_at(bands: &[Band], mut wanted: usize) -> usize {
    let mut first = 0;
    for band in bands {
        if wanted <= cost(band) {
            return first + band.runs.row_at(|row, runs| runs + ROW * row < wanted);
        }
        wanted -= cost(band);
        first += band.runs.rows();
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares(bands: usize) -> Vec<usize> {
        let mut ends: Vec<usize> = (1..bands).map(|band| thousandths_before(band, bands)).collect();
        ends.push(1000);
        let starts = std::iter::once(&0).chain(&ends);
        ends.iter().zip(starts).map(|(end, start)| end - start).collect()
    }

    #[test]
    fn bands_that_threads_begin_with_are_large_and_as_many_between_them_small() {
        assert_eq!(shares(4), [400, 100, 100, 400]);
        assert_eq!(shares(8), [200, 50, 50, 50, 50, 200, 200, 200]);
        assert_eq!(shares(2), [500, 500]);
        assert_eq!(shares(5), [200; 5]);
    }
}
