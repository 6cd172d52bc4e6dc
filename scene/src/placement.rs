//! A tag placed in the picture, and how it is painted.

use crate::canvas::{Canvas, Window};
use crate::coverage::{Coverage, Layers, sense_of};
use crate::homography::{Homography, Point, project};
use crate::ink::Lattice;
use crate::tag::{Tag, TrueTag};
use tagbus_family::Paint;

/// What a tag is printed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paper {
    /// Nothing but the cells: clear cells show what is behind the tag.
    CutOut,
    /// A white sheet that is `margin_cells` (of the outermost tag) wider than the print on every side. Clear cells
    /// show the sheet.
    Sheet {
        /// Width of the white margin around the print in cells; may be 0 or a fraction.
        margin_cells: f64,
    },
    /// Nothing but the cells, and those of the outermost ring cut off in part: how a careless cut takes the white
    /// margin of a classic tag away.
    Trimmed {
        /// How much of the outermost ring is cut off, in cells: 0 for nothing, 1 for all of it.
        cut_cells: f64,
    },
}

impl Paper {
    /// How far the paper reaches beyond the print, in cells; negative where some of the print is cut off.
    fn overhang_cells(&self) -> f64 {
        match *self {
            Paper::CutOut => 0.0,
            Paper::Sheet { margin_cells } => margin_cells.max(0.0),
            Paper::Trimmed { cut_cells } => -cut_cells.clamp(0.0, 1.0),
        }
    }

    /// What lies where nothing is printed.
    fn bare(&self) -> Layers {
        match self {
            Paper::CutOut | Paper::Trimmed { .. } => [0.0, 0.0],
            Paper::Sheet { .. } => [1.0, 0.0],
        }
    }
}

/// A tag with its place in the picture and its two grey levels.
#[derive(Clone, Debug)]
pub struct Placement {
    /// What is printed, nested tags included.
    pub tag: Tag,
    /// From the border square [-1, 1]^2 of the (outermost) tag to pixels.
    pub homography: Homography,
    /// What it is printed on.
    pub paper: Paper,
    /// Grey level of black cells, 0..=255.
    pub black: f32,
    /// Grey level of white cells and of the sheet, 0..=255.
    pub white: f32,
    /// How far the ink of black cells has spread into white and clear ones, in cells of their tag: 0 for a sharp print,
    /// at most 0.45. Truth stays where the print was meant to be.
    pub ink_spread_cells: f64,
}

impl Placement {
    /// A cut-out tag with the contrast of ordinary paper: black 35, white 215.
    pub fn new(tag: Tag, homography: Homography) -> Placement {
        Placement { tag, homography, paper: Paper::CutOut, black: 35.0, white: 215.0, ink_spread_cells: 0.0 }
    }

    /// What is to be found in a picture of that size: this tag, then the tags nested in it.
    pub fn truth(&self, width: usize, height: usize) -> Vec<TrueTag> {
        self.tag.truth(&self.homography, width, height)
    }

    pub(crate) fn print(&self) -> Print<'_> {
        let Placement { tag, homography, paper, black, white, ink_spread_cells } = self;
        Print {
            tag,
            homography: *homography,
            paper: *paper,
            black: *black,
            white: *white,
            ink_spread_cells: *ink_spread_cells,
        }
    }
}

/// A placement that borrows its tag, so that a moving tag is not copied for every frame.
pub(crate) struct Print<'a> {
    pub tag: &'a Tag,
    pub homography: Homography,
    pub paper: Paper,
    pub black: f32,
    pub white: f32,
    pub ink_spread_cells: f64,
}

impl Print<'_> {
    /// The pixels of `limit` that the tag or its sheet touches; empty when there are none, or when a part of it lies
    /// behind the camera.
    pub(crate) fn window(&self, limit: &Window) -> Window {
        if !self.tag.in_front_of_camera(&self.homography) {
            return Window { width: 0, ..*limit };
        }
        limit.around(&self.outline(self.ink_spread_cells.max(0.0)))
    }

    /// Paints the tag over what is on the canvas.
    pub(crate) fn paint(&self, canvas: &mut Canvas, coverage: &mut Coverage) {
        let window = self.window(&canvas.window);
        if window.is_empty() {
            return;
        }
        coverage.clear_to(window);
        self.cover(coverage);
        for y in window.rows() {
            let pixels = canvas.row_mut(y, window.columns());
            for (pixel, [painted, ink]) in pixels.iter_mut().zip(coverage.row(y)) {
                *pixel += painted * (self.white - *pixel) + ink * (self.black - self.white);
            }
        }
    }

    /// Adds the edges of everything that is printed. A nest of tags is one print: where an inner tag meets its hole
    /// the shares of a pixel add up, and nothing shines through between them.
    fn cover(&self, coverage: &mut Coverage) {
        let outline = self.outline(0.0);
        let sense = sense_of(&outline);
        let bare = self.paper.bare();
        coverage.add_polygon(&outline, bare);
        let (mut tag, mut homography) = (self.tag, self.homography);
        let ink_spread_cells = self.ink_spread_cells;
        let cut_cells = (-self.paper.overhang_cells()).max(0.0);
        cover_cells(tag, &homography, &Edges { ink_spread_cells, cut_cells, bare, sense }, coverage);
        while let Some(inner) = tag.inner() {
            homography = tag.homography_in_hole(inner, &homography);
            tag = inner;
            cover_cells(tag, &homography, &Edges { ink_spread_cells, cut_cells: 0.0, bare, sense }, coverage);
        }
    }

    /// The corners of the sheet, or of the print where there is no sheet, in the picture, moved outwards by some cells.
    fn outline(&self, beyond_cells: f64) -> [Point; 4] {
        let overhang = 2.0 * (self.paper.overhang_cells() + beyond_cells) / self.tag.grid().width() as f64;
        let radius = self.tag.print_radius() * (1.0 + overhang);
        let corners = [[-radius, -radius], [-radius, radius], [radius, radius], [radius, -radius]];
        corners.map(|corner| project(&self.homography, corner))
    }
}

/// How the edges of a print lie.
struct Edges {
    /// How far ink has spread, in cells.
    ink_spread_cells: f64,
    /// How much of the outermost ring is cut off, in cells.
    cut_cells: f64,
    /// What already lies where nothing is printed.
    bare: Layers,
    /// The sense of the print's outline.
    sense: f32,
}

/// Adds the edges between cells of different paint.
fn cover_cells(tag: &Tag, homography: &Homography, edges: &Edges, coverage: &mut Coverage) {
    let Edges { ink_spread_cells, cut_cells, bare, sense } = *edges;
    let to_pixels = tag.cells_to_pixels(homography);
    let lattice = Lattice::new(tag, ink_spread_cells);
    let (first, last) = (cut_cells, tag.grid().width() as f64 - cut_cells);
    let line_at = |line: i64| match cut_cells > 0.0 {
        true => lattice.line_at(line).clamp(first, last),
        false => lattice.line_at(line),
    };
    let corner_at = |x: i64, y: i64| project(&to_pixels, [line_at(x), line_at(y)]);
    let share_at = |x: i64, y: i64| match lattice.paint_at(x, y) {
        Paint::White => [1.0, 0.0],
        Paint::Black => [1.0, 1.0],
        Paint::Clear => bare,
    };
    for y in lattice.lines() {
        for x in lattice.lines() {
            let (here, left, above) = (share_at(x, y), share_at(x - 1, y), share_at(x, y - 1));
            let corner = corner_at(x, y);
            if here != left {
                coverage.add_edge(corner, corner_at(x, y + 1), step(here, left, sense));
            }
            if here != above {
                coverage.add_edge(corner, corner_at(x + 1, y), step(above, here, sense));
            }
        }
    }
}

/// The weight of an edge between two shares.
fn step(to: Layers, from: Layers, sense: f32) -> Layers {
    [(to[0] - from[0]) * sense, (to[1] - from[1]) * sense]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Turn, View, homography_of};
    use tagbus_family::Family;

    const GROUND: f32 = 120.0;

    fn tag(name: &str, id: u32) -> Tag {
        Tag::new(&Family::published(name).unwrap(), id).unwrap()
    }

    fn painted(placement: &Placement, width: usize, height: usize) -> Canvas {
        let mut canvas = Canvas::plain(Window::whole(width, height), GROUND);
        placement.print().paint(&mut canvas, &mut Coverage::default());
        canvas
    }

    fn pixel(canvas: &Canvas, x: usize, y: usize) -> f32 {
        canvas.row(y, x..x + 1)[0]
    }

    /// One pixel a cell: the print's top-left corner in the top-left corner of the picture.
    fn pixel_a_cell(tag: &Tag, border_width: f64) -> Homography {
        let (half, middle) = (border_width / 2.0, tag.grid().width() as f64 / 2.0);
        [half, 0.0, middle, 0.0, half, middle, 0.0, 0.0, 1.0]
    }

    #[test]
    fn with_one_pixel_a_cell_the_picture_is_the_grid() {
        for (name, border_width) in [("tag36h11", 8.0), ("tagCustom48h12", 6.0), ("tagCircle21h7", 5.0)] {
            let tag = tag(name, 3);
            let canvas = painted(&Placement::new(tag.clone(), pixel_a_cell(&tag, border_width)), 12, 12);
            for y in 0..12 {
                for x in 0..12 {
                    let expected = match tag.paint_at(x, y) {
                        Paint::White => 215.0,
                        Paint::Black => 35.0,
                        Paint::Clear => GROUND,
                    };
                    let found = pixel(&canvas, x as usize, y as usize);
                    assert!((found - expected).abs() < 1e-3, "{name} cell {x}, {y}: {found}");
                }
            }
        }
    }

    #[test]
    fn a_mirrored_map_paints_the_mirrored_tag() {
        let tag = tag("tag36h11", 3);
        let upright = pixel_a_cell(&tag, 8.0);
        let mut mirrored = upright;
        mirrored[0] = -upright[0];
        let (one, other) = (Placement::new(tag.clone(), upright), Placement::new(tag, mirrored));
        let (one, other) = (painted(&one, 10, 10), painted(&other, 10, 10));
        for y in 0..10 {
            for x in 0..10 {
                assert!((pixel(&one, x, y) - pixel(&other, 9 - x, y)).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_sheet_is_white_around_the_print_and_where_cells_are_clear() {
        let tag = tag("tagCircle21h7", 0);
        let mut homography = pixel_a_cell(&tag, 5.0);
        (homography[2], homography[5]) = (homography[2] + 2.0, homography[5] + 2.0);
        let paper = Paper::Sheet { margin_cells: 1.5 };
        let canvas = painted(&Placement { paper, ..Placement::new(tag, homography) }, 14, 14);
        assert_eq!(pixel(&canvas, 1, 6), 215.0);
        assert!((pixel(&canvas, 0, 6) - (GROUND + 215.0) / 2.0).abs() < 1e-3);
        assert!((pixel(&canvas, 2, 2) - 215.0).abs() < 1e-3, "the clear corner of the circle");
    }

    #[test]
    fn trimming_takes_off_the_outermost_ring_and_nothing_else() {
        let tag = tag("tag36h11", 3);
        let whole = painted(&Placement::new(tag.clone(), pixel_a_cell(&tag, 8.0)), 10, 10);
        for cut_cells in [0.0, 0.25, 0.5, 1.0] {
            let placement = Placement::new(tag.clone(), pixel_a_cell(&tag, 8.0));
            let trimmed = painted(&Placement { paper: Paper::Trimmed { cut_cells }, ..placement }, 10, 10);
            for y in 1..9 {
                let (kept, before) = (trimmed.row(y, 1..9), whole.row(y, 1..9));
                assert!(
                    kept.iter().zip(before).all(|(a, b)| (a - b).abs() < 1e-3),
                    "cut {cut_cells}, row {y}"
                );
                let expected = 215.0 + cut_cells as f32 * (GROUND - 215.0);
                assert!((pixel(&trimmed, 0, y) - expected).abs() < 1e-3, "cut {cut_cells}, row {y}");
            }
        }
    }

    #[test]
    fn spread_ink_makes_black_wider_and_leaves_the_middle_of_cells_alone() {
        let tag = tag("tagStandard41h12", 3);
        let mut homography = pixel_a_cell(&tag, 5.0);
        (homography[2], homography[5]) = (homography[2] + 1.0, homography[5] + 1.0);
        let sharp = Placement::new(tag.clone(), homography);
        let spread = Placement { ink_spread_cells: 0.25, ..sharp.clone() };
        let [sharp, spread] = [sharp, spread].map(|placement| painted(&placement, 11, 11));
        let darker =
            sharp.pixels.iter().zip(&spread.pixels).filter(|(before, after)| *after < before).count();
        assert!(darker > 20, "{darker} pixels are darker");
        assert!(sharp.pixels.iter().zip(&spread.pixels).all(|(before, after)| *after < before + 1e-3));
        // A cell above a black one of the outermost row is covered by a quarter.
        let x = (0..9).find(|&x| tag.paint_at(x, 0) == Paint::Black).unwrap() as usize + 1;
        let expected = GROUND + 0.25 * (35.0 - GROUND);
        assert!((pixel(&spread, x, 0) - expected).abs() < 1e-3, "{}", pixel(&spread, x, 0));
    }

    #[test]
    fn nothing_shines_through_between_a_nested_tag_and_its_hole() {
        let nested = tag("tagCustom48h12", 0).nest(tag("tag36h11", 0)).unwrap();
        let layout = Family::published("tagCustom48h12").unwrap().layout().clone();
        let turn = Turn { rotation_rad: 0.3, tilt_rad: 0.5, tilt_direction_rad: 1.0 };
        let view = View { centre: [100.0, 100.0], cell_px: 12.3, turn, ..View::default() };
        let mut placement = Placement::new(nested, homography_of(&layout, &view));
        // On a black ground, with black and white painted the same, every gap would show.
        (placement.black, placement.white) = (200.0, 200.0);
        let mut canvas = Canvas::plain(Window::whole(200, 200), 0.0);
        placement.print().paint(&mut canvas, &mut Coverage::default());
        for y in 80..120 {
            for x in 80..120 {
                assert!((pixel(&canvas, x, y) - 200.0).abs() < 0.01, "gap at {x}, {y}");
            }
        }
    }

    #[test]
    fn a_tag_behind_the_camera_or_without_finite_numbers_is_not_painted() {
        let tag = tag("tag36h11", 0);
        for (entry, value) in [(6, 2.0), (6, -0.9), (0, f64::NAN), (2, f64::INFINITY)] {
            let mut homography = pixel_a_cell(&tag, 8.0);
            homography[entry] = value;
            let canvas = painted(&Placement::new(tag.clone(), homography), 10, 10);
            assert!(canvas.pixels.iter().all(|&pixel| pixel == GROUND), "entry {entry} = {value}");
        }
    }
}
