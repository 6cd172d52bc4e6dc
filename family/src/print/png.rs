//! Pages as PNG: every cell has a whole number of pixels, and the file says how large a pixel is.

use super::block::Block;
use super::page::{Mark, Outlines, Page, Pattern};
use ::png::{BitDepth, ColorType, Encoder, EncodingError, PixelDimensions, Unit};

/// The least resolution, 300 dots an inch, unless that makes the picture too large.
const PIXELS_A_MM: f64 = 300.0 / 25.4;
/// The longest side of a picture.
const LONGEST_PIXELS: f64 = 10_000.0;

/// Pixels a millimetre, and what the file says of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Pixels of a cell of a block's first tag.
    pub pixels_a_cell: u32,
    /// Pixels of a metre as the file says it, in whole numbers.
    pub pixels_a_metre: u32,
    /// What the file means for the size of a millimetre, minus 1: 1e-5 makes 100 mm one micrometre too long.
    pub deviation: f64,
    pixels_a_mm: f64,
}

impl Resolution {
    /// For a block on a page of this size: whole pixels for all its cells, 300 to 600 dots an inch or, where that is more
    /// than 10,000 pixels along a side, fewer, so chosen that the whole number of pixels a metre is as right as can be.
    /// `None` when even one pixel a cell is too much.
    pub fn of(block: &Block, size: [f64; 2]) -> Option<Resolution> {
        let cell_mm = block.cell_mm / f64::from(block.pixel_step);
        let most = (LONGEST_PIXELS / size[0].max(size[1]) * cell_mm).floor();
        let least = (PIXELS_A_MM * cell_mm).ceil().max(1.0).min((most / 2.0).ceil());
        let candidates = least as u32..=(2.0 * least).min(most) as u32;
        let resolution = |steps: u32| {
            let pixels_a_mm = f64::from(steps) / cell_mm;
            let written = (1000.0 * pixels_a_mm).round();
            Resolution {
                pixels_a_cell: steps * block.pixel_step,
                pixels_a_metre: written as u32,
                deviation: 1000.0 * pixels_a_mm / written - 1.0,
                pixels_a_mm,
            }
        };
        let usable = candidates.filter(|&steps| steps > 0).map(resolution);
        usable.min_by(|one, other| one.deviation.abs().total_cmp(&other.deviation.abs()))
    }
}

/// The page as a grey picture. Text is left out; tags are moved to whole pixels, by half of one at most.
///
/// # Errors
/// [`EncodingError`] when a side has no pixel.
pub fn to_png(page: &Page, resolution: &Resolution) -> Result<Vec<u8>, EncodingError> {
    let canvas = Canvas::painted(page, resolution.pixels_a_mm);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, canvas.width as u32, canvas.height as u32);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Eight);
    let a_metre = resolution.pixels_a_metre;
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: a_metre, yppu: a_metre, unit: Unit::Meter }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&canvas.levels)?;
    writer.finish()?;
    Ok(bytes)
}

struct Canvas {
    width: usize,
    height: usize,
    levels: Vec<u8>,
    pixels_a_mm: f64,
}

impl Canvas {
    fn painted(page: &Page, pixels_a_mm: f64) -> Canvas {
        let [width, height] = page.size.map(|side| (side * pixels_a_mm).round() as usize);
        let mut canvas = Canvas { width, height, levels: vec![255; width * height], pixels_a_mm };
        page.marks.iter().for_each(|mark| canvas.add(mark));
        canvas
    }

    fn add(&mut self, mark: &Mark) {
        match mark {
            Mark::Pattern(pattern) => self.fill(pattern),
            Mark::Line { from, to, width, ink } => self.line(*from, *to, *width, ink.level()),
            Mark::Circle { centre, radius, width, ink } => self.circle(*centre, *radius, *width, ink.level()),
            Mark::Text { .. } => {}
        }
    }

    /// Pixels whose centre is inside by the even-odd rule, row by row between each two sides that are met.
    fn fill(&mut self, pattern: &Pattern) {
        let polygons: Vec<Vec<[f64; 2]>> =
            pattern.parts.iter().flat_map(|part| in_pixels(part, self.pixels_a_mm)).collect();
        let heights = polygons.iter().flatten().map(|corner| corner[1]);
        let (top, bottom) =
            heights.fold((f64::MAX, 0.0), |(low, high): (f64, f64), y| (low.min(y), high.max(y)));
        for row in top.max(0.0) as usize..(bottom.ceil() as usize).min(self.height) {
            let mut met: Vec<f64> =
                polygons.iter().flat_map(|corners| crossings(corners, row as f64 + 0.5)).collect();
            met.sort_by(f64::total_cmp);
            for pair in met.chunks_exact(2) {
                self.paint_row(row, pair[0], pair[1], pattern.ink.level());
            }
        }
    }

    /// The pixels of a row whose centres lie from `left` to before `right`.
    fn paint_row(&mut self, row: usize, left: f64, right: f64, level: u8) {
        let [first, end] = [left, right].map(|x| ((x - 0.5).ceil().max(0.0) as usize).min(self.width));
        if row < self.height && first < end {
            self.levels[row * self.width..][first..end].fill(level);
        }
    }

    /// An upright or level line, a pixel wide at least.
    fn line(&mut self, from: [f64; 2], to: [f64; 2], width: f64, level: u8) {
        let half = (width * self.pixels_a_mm).max(1.0) / 2.0;
        let side = |axis: usize, sign: f64| {
            let ends = [from[axis], to[axis]].map(|at| at * self.pixels_a_mm);
            let thick = if from[axis] == to[axis] { half } else { 0.0 };
            if sign < 0.0 { ends[0].min(ends[1]) - thick } else { ends[0].max(ends[1]) + thick }
        };
        let [left, right, top, bottom] = [side(0, -1.0), side(0, 1.0), side(1, -1.0), side(1, 1.0)];
        for row in (top - 0.5).ceil().max(0.0) as usize..(bottom - 0.5).ceil().max(0.0) as usize {
            self.paint_row(row, left, right, level);
        }
    }

    fn circle(&mut self, centre: [f64; 2], radius: f64, width: f64, level: u8) {
        let [x, y] = centre.map(|at| at * self.pixels_a_mm);
        let half = (width * self.pixels_a_mm).max(1.0) / 2.0;
        let [inner, outer] = [-half, half].map(|by| radius * self.pixels_a_mm + by);
        for row in (y - outer).floor().max(0.0) as usize..(y + outer).ceil().max(0.0) as usize {
            let away = row as f64 + 0.5 - y;
            let chord = |radius: f64| (radius * radius - away * away).max(0.0).sqrt();
            let [short, long] = [inner, outer].map(chord);
            self.paint_row(row, x - long, x - short, level);
            self.paint_row(row, x + short, x + long, level);
        }
    }
}

/// Polygons in pixels, moved by half of one at most so that cells of whole pixels begin with whole pixels.
fn in_pixels(part: &Outlines, pixels_a_mm: f64) -> impl Iterator<Item = Vec<[f64; 2]>> {
    let whole = part.origin.map(|at| (at * pixels_a_mm).round());
    let step = part.step_mm * pixels_a_mm;
    let at = move |corner: &[i32; 2]| {
        [0, 1].map(|axis: usize| whole[axis] + to_whole(step * f64::from(corner[axis])))
    };
    part.loops.iter().map(move |corners| corners.iter().map(at).collect())
}

/// What is whole but for rounding is made whole; the sides of an arrow need not be.
fn to_whole(pixels: f64) -> f64 {
    if (pixels - pixels.round()).abs() < 1e-6 { pixels.round() } else { pixels }
}

/// Where the polygon's sides meet the level line at `y`.
fn crossings(corners: &[[f64; 2]], y: f64) -> impl Iterator<Item = f64> {
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).filter(move |(from, to)| (from[1] <= y) != (to[1] <= y));
    sides.map(move |(&[x0, y0], &[x1, y1])| x0 + (x1 - x0) * (y - y0) / (y1 - y0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::Family;
    use crate::grid::Paint;
    use crate::print::{Length, Size, sheet};

    fn custom(ids: &[u32], mm: &str) -> Block {
        let family = Family::published("tagCustom48h12").unwrap();
        let tags: Vec<(&Family, u32)> = ids.iter().map(|&id| (&family, id)).collect();
        Block::nest(&tags, Size::Printed(mm.parse().unwrap()), Length::ZERO).unwrap()
    }

    #[test]
    fn a_bare_tag_is_its_cells_in_whole_pixels() {
        let family = Family::published("tagCustom48h12").unwrap();
        let block = custom(&[7], "33.3mm");
        let resolution = Resolution::of(&block, block.size).unwrap();
        let canvas = Canvas::painted(&sheet::bare(&block), resolution.pixels_a_mm);
        let pixels = resolution.pixels_a_cell as usize;
        assert_eq!([canvas.width, canvas.height], [10 * pixels; 2]);
        let grid = family.grid(7).unwrap();
        for y in 0..canvas.height {
            for x in 0..canvas.width {
                let black = grid.get(x / pixels, y / pixels) == Paint::Black;
                assert_eq!(canvas.levels[y * canvas.width + x] == 0, black, "{x}, {y}");
            }
        }
    }

    #[test]
    fn sizes_are_right_to_a_ten_thousandth_and_pictures_are_not_endless() {
        for mm in ["1mm", "33.3mm", "160mm", "0.777m", "4.9m"] {
            let block = custom(&[0, 1, 2], mm);
            let resolution = Resolution::of(&block, block.size).unwrap();
            let pixels = block.size[0] * resolution.pixels_a_mm;
            assert!(pixels < 10_000.5, "{mm}: {pixels}");
            assert!(resolution.deviation.abs() < 2e-4, "{mm}: {resolution:?}");
            let said = pixels / f64::from(resolution.pixels_a_metre) * 1000.0;
            assert!((said / block.size[0] - 1.0 - resolution.deviation).abs() < 1e-9, "{mm}");
            assert_eq!(resolution.pixels_a_cell % 25, 0, "{mm}");
        }
    }
}
