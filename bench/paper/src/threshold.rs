//! Black, white, or neither (figure 4 step 3): each pixel against the middle between the extremes around it.
//!
//! The paper takes this step over from AprilTag 2: the extremes of tiles of 4x4 pixels are taken together over 3x3
//! tiles, so that neighbouring tiles have similar thresholds; where white and black differ too little there is no edge
//! to be found, and every pixel is left out ("unsure", 127 in the papers' pictures).

use crate::picture::Picture;

const TILE: usize = 4;
/// Tiles whose extremes differ by less than this many grey levels are unsure. AprilTag's value; no paper names it.
const MIN_CONTRAST: u8 = 5;

/// What a pixel counts as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shade {
    Black,
    Unsure,
    White,
}

/// The thresholded picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shades {
    pub(crate) width: usize,
    pub(crate) height: usize,
    shades: Vec<Shade>,
}

impl Shades {
    pub(crate) fn at(&self, x: usize, y: usize) -> Shade {
        self.shades[y * self.width + x]
    }

    /// The shade at a place that may lie outside the picture.
    pub(crate) fn get(&self, x: i64, y: i64) -> Option<Shade> {
        let inside = |v: i64, end: usize| usize::try_from(v).ok().filter(|v| *v < end);
        Some(self.at(inside(x, self.width)?, inside(y, self.height)?))
    }

    #[cfg(test)]
    pub(crate) fn from_rows(rows: &[&str]) -> Shades {
        let shade = |letter: char| match letter {
            '#' => Shade::Black,
            '.' => Shade::White,
            _ => Shade::Unsure,
        };
        let shades = rows.iter().flat_map(|row| row.chars().map(shade)).collect();
        Shades { width: rows[0].len(), height: rows.len(), shades }
    }

    #[cfg(test)]
    pub(crate) fn from_fn(width: usize, height: usize, mut shade: impl FnMut() -> Shade) -> Shades {
        Shades { width, height, shades: (0..width * height).map(|_| shade()).collect() }
    }
}

/// Least and greatest grey level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Extremes {
    least: u8,
    greatest: u8,
}

impl Extremes {
    const NONE: Extremes = Extremes { least: u8::MAX, greatest: 0 };

    fn and(self, other: Extremes) -> Extremes {
        Extremes { least: self.least.min(other.least), greatest: self.greatest.max(other.greatest) }
    }

    fn shade(self, grey: u8) -> Shade {
        let contrast = self.greatest - self.least;
        match (contrast < MIN_CONTRAST, grey > self.least + contrast / 2) {
            (true, _) => Shade::Unsure,
            (false, true) => Shade::White,
            (false, false) => Shade::Black,
        }
    }
}

/// Extremes by tile; tiles at the right and lower edge are as wide as the picture leaves room for.
struct Tiles {
    columns: usize,
    rows: usize,
    extremes: Vec<Extremes>,
}

/// Thresholds the whole picture.
pub(crate) fn threshold(picture: &Picture) -> Shades {
    let around = Tiles::of(picture).taken_together();
    let (width, height) = (picture.width(), picture.height());
    let mut shades = Vec::with_capacity(width * height);
    for y in 0..height {
        shades.extend((0..width).map(|x| around.at(x / TILE, y / TILE).shade(picture.at(x, y))));
    }
    Shades { width, height, shades }
}

impl Tiles {
    fn of(picture: &Picture) -> Tiles {
        let [columns, rows] = [picture.width(), picture.height()].map(|side| side.div_ceil(TILE));
        let mut extremes = vec![Extremes::NONE; columns * rows];
        for y in 0..picture.height() {
            for x in 0..picture.width() {
                let grey = picture.at(x, y);
                let tile = &mut extremes[y / TILE * columns + x / TILE];
                *tile = tile.and(Extremes { least: grey, greatest: grey });
            }
        }
        Tiles { columns, rows, extremes }
    }

    fn at(&self, column: usize, row: usize) -> Extremes {
        self.extremes[row * self.columns + column]
    }

    /// For each tile the extremes of itself and its up to eight neighbours.
    fn taken_together(&self) -> Tiles {
        let near = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let around = |column: usize, row: usize| {
            near(row, self.rows)
                .flat_map(|row| near(column, self.columns).map(move |column| self.at(column, row)))
                .fold(Extremes::NONE, Extremes::and)
        };
        let places = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        let extremes = places.map(|(column, row)| around(column, row)).collect();
        Tiles { extremes, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_picture_is_unsure_everywhere() {
        let noise = Picture::computed(13, 9, |x, y| 100 + ((x * 7 + y * 5) % 5) as u8);
        let shades = threshold(&noise);
        assert!((0..9).all(|y| (0..13).all(|x| shades.at(x, y) == Shade::Unsure)));
    }

    #[test]
    fn an_edge_is_seen_up_to_two_tiles_away_and_not_farther() {
        let edge = Picture::computed(32, 4, |x, _| if x < 16 { 50 } else { 60 });
        let row: Vec<Shade> = (0..32).map(|x| threshold(&edge).at(x, 0)).collect();
        // The tiles beside the edge start at 12 and 16. Each sees its neighbours.
        assert!(row[..12].iter().all(|shade| *shade == Shade::Unsure));
        assert!(row[12..16].iter().all(|shade| *shade == Shade::Black));
        assert!(row[16..20].iter().all(|shade| *shade == Shade::White));
        assert!(row[20..].iter().all(|shade| *shade == Shade::Unsure));
    }

    #[test]
    fn a_tile_at_the_rim_that_is_not_whole_follows_the_same_rule() {
        let flat_rim = Picture::computed(17, 4, |x, _| if x < 4 { 0 } else { 200 });
        assert_eq!(threshold(&flat_rim).at(16, 0), Shade::Unsure);
        let dark_rim = Picture::computed(17, 4, |x, _| if x < 16 { 200 } else { 0 });
        assert_eq!(
            (threshold(&dark_rim).at(16, 0), threshold(&dark_rim).at(15, 0)),
            (Shade::Black, Shade::White)
        );
    }

    #[test]
    fn brightness_does_not_matter() {
        let picture =
            |shift: u8| Picture::computed(40, 30, |x, y| shift + ((x * 13 + y * 29 + x * y) % 97) as u8);
        assert_eq!(threshold(&picture(0)), threshold(&picture(150)));
    }
}
