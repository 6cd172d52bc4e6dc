//! Which pixels of a tag say where it lies: those near an edge between a black and a white cell.

use super::super::homography::Homography;
use super::super::reader::Reader;
use super::super::sample::Frame;

/// Pixels within this distance of an edge carry its place.
const EDGE_REACH: f64 = 2.0;
/// A pixel this near to a cell of unknown colour is not modelled.
const UNKNOWN_REACH: f64 = 1.5;
/// More pixels than this are thinned evenly: the corners hardly gain from more, and time grows with them.
const MOST_PIXELS: usize = 1600;

/// A pixel's place relative to the tag's middle, in units of the patch's scale, and its grey value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) grey: f32,
}

/// Where a tag lies in the frame: coordinates relative to this keep all numbers near one.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub(super) middle: [f64; 2],
    /// Pixels per unit: distance of the farthest corner from the middle.
    pub(super) scale: f64,
    corners: [[f64; 2]; 4],
}

impl Patch {
    pub(super) fn around(corners: &[[f64; 2]; 4]) -> Self {
        let middle = [0, 1].map(|a| corners.iter().map(|corner| corner[a]).sum::<f64>() * 0.25);
        let distance = |corner: &[f64; 2]| (corner[0] - middle[0]).hypot(corner[1] - middle[1]);
        let scale = corners.iter().map(distance).fold(1.0, f64::max);
        Self { middle, scale, corners: *corners }
    }

    /// First and last column and row that a print of `share` times the tag's size can reach, inside the frame.
    fn bounds(&self, share: f64, size: [usize; 2]) -> [[usize; 2]; 2] {
        [0, 1].map(|a| {
            let reached = self.corners.map(|corner| self.middle[a] + share * (corner[a] - self.middle[a]));
            let low = reached.iter().copied().fold(f64::MAX, f64::min).floor().max(0.0);
            let high = reached.iter().copied().fold(f64::MIN, f64::max).ceil().max(0.0);
            [low as usize, (high as usize).min(size[a])]
        })
    }

    /// The corners of the tag that the map from patch units to cells describes.
    pub(super) fn corners_of(&self, to_patch: &Homography, width: f64) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [width, 0.0], [width, width], [0.0, width]].map(|cell| {
            let [x, y] = to_patch.project(cell);
            [self.middle[0] + x * self.scale, self.middle[1] + y * self.scale]
        })
    }
}

/// Collects the pixels of the tag that lie near an edge. `to_cells` maps frame pixels to cells.
#[inline(always)]
pub(super) fn choose(
    frame: &Frame,
    reader: &Reader,
    pattern: &[f32],
    patch: &Patch,
    to_cells: &Homography,
    pixels: &mut Vec<Pixel>,
) {
    pixels.clear();
    let cells = Cells { reader, pattern };
    let print = reader.grid_width as f64 / reader.width;
    // A perspective print reaches further than its middle suggests.
    let [columns, rows] = patch.bounds(1.25 * print, frame.size());
    for row in rows[0]..rows[1] {
        for column in columns[0]..columns[1] {
            let at = [column as f64 + 0.5, row as f64 + 0.5];
            if cells.has_edge_near(to_cells, at) {
                let [x, y] = [0, 1].map(|a| ((at[a] - patch.middle[a]) / patch.scale) as f32);
                pixels.push(Pixel { x, y, grey: f32::from(frame.pixel(column, row)) });
            }
        }
    }
    thin(pixels);
}

/// Keeps `MOST_PIXELS` pixels, evenly spread over the list.
fn thin(pixels: &mut Vec<Pixel>) {
    let count = pixels.len();
    if count > MOST_PIXELS {
        for kept in 0..MOST_PIXELS {
            pixels[kept] = pixels[kept * count / MOST_PIXELS];
        }
        pixels.truncate(MOST_PIXELS);
    }
}

struct Cells<'a> {
    reader: &'a Reader,
    pattern: &'a [f32],
}

impl Cells<'_> {
    /// Whether black and white, and nothing unknown, lie within reach of a pixel.
    #[inline(always)]
    fn has_edge_near(&self, to_cells: &Homography, pixel: [f64; 2]) -> bool {
        let margin = self.reader.grid_margin();
        let [u, v] = to_cells.project(pixel).map(|cell| cell + margin);
        let last = self.reader.grid_width as f64;
        if !(u >= 1.0 && v >= 1.0 && u < last - 1.0 && v < last - 1.0) {
            return false;
        }
        let [per_pixel_u, per_pixel_v] = to_cells.stretch(pixel);
        let span = |reach: f64| {
            [[u, per_pixel_u], [v, per_pixel_v]].map(|[c, per_pixel]| self.span(c, reach * per_pixel))
        };
        let [near_u, near_v] = span(EDGE_REACH);
        let (mut black, mut white) = (false, false);
        for y in near_v[0]..=near_v[1] {
            for x in near_u[0]..=near_u[1] {
                let colour = self.pattern[y * self.reader.grid_width + x];
                black |= colour == 0.0;
                white |= colour == 1.0;
            }
        }
        black && white && self.is_known(span(UNKNOWN_REACH))
    }

    /// First and last cell within `reach` cells of a coordinate.
    #[inline(always)]
    fn span(&self, coordinate: f64, reach: f64) -> [usize; 2] {
        let last = self.reader.grid_width - 1;
        [(coordinate - reach).max(0.0) as usize, ((coordinate + reach) as usize).min(last)]
    }

    #[inline(always)]
    fn is_known(&self, [u, v]: [[usize; 2]; 2]) -> bool {
        (v[0]..=v[1]).all(|y| (u[0]..=u[1]).all(|x| !self.pattern[y * self.reader.grid_width + x].is_nan()))
    }
}
