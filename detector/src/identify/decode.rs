//! Reading the bits (paper III-D): sampling, sharpening, look-up.

use tagbus_family::Found;

use super::border::Border;
use super::homography::Homography;
use super::reader::Reader;
use super::sample::{Frame, LANES};
use crate::simd::Kernel;

/// The bits of a quad, whether they are a tag's or not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits {
    /// Most significant bit first, as the picture is turned.
    pub(crate) code: u64,
    /// Mean distance of the bits from their threshold in grey levels, the worse of white and black.
    pub(crate) margin: f32,
    /// The same over half the contrast.
    pub(crate) relative_margin: f32,
}

impl Bits {
    /// The tag that these bits are nearest to, if that is near enough.
    #[inline(always)]
    pub(crate) fn look_up(&self, reader: &Reader) -> Option<Found> {
        reader.index.lookup(self.code)
    }
}

/// Reads the bits of a quad. `grid` is scratch.
///
/// The paper sharpens the sampled data cells with a Laplacian (eq. 5) and lets all other cells count as zero. Here the
/// cells whose colour is known from the layout enter with that colour: at a few pixels a cell the blur of the border
/// decides the outer bits, and knowing it removes the bias. That is worth ten points of recall on small tags.
pub(crate) fn sample(
    frame: &Frame,
    reader: &Reader,
    homography: &Homography,
    border: &Border,
    sharpening: f32,
    grid: &mut Vec<f32>,
) -> Bits {
    frame.level().run(FillGrid { frame, reader, homography, border, grid });
    let mut code = 0;
    let (mut white, mut black) = (Mean::default(), Mean::default());
    for cell in &reader.data {
        let value = grid[cell.place];
        let around =
            [cell.place - reader.grid_width, cell.place - 1, cell.place + 1, cell.place + reader.grid_width];
        let laplacian: f32 = around.iter().map(|place| value - grid[*place]).sum();
        let is_white = value + sharpening * laplacian > 0.0;
        code = code << 1 | u64::from(is_white);
        if is_white { white.add(value) } else { black.add(-value) }
    }
    // On the smallest tags sharpening decides against the bare values; their margin is none, not less than none.
    let margin = white.mean().min(black.mean()).max(0.0);
    Bits { code, margin, relative_margin: margin / (0.5 * border.contrast).max(1.0) }
}

/// Distances from the threshold, in grey levels: measured for data cells, the model's for cells of known colour, zero for
/// cells that nothing is known of. A function of its own at every level, as [`super::border::measure`].
struct FillGrid<'a> {
    frame: &'a Frame<'a>,
    reader: &'a Reader,
    homography: &'a Homography,
    border: &'a Border,
    grid: &'a mut Vec<f32>,
}

impl Kernel for FillGrid<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        fill_grid(self.frame, self.reader, self.homography, self.border, self.grid);
    }
}

#[inline(always)]
fn fill_grid(frame: &Frame, reader: &Reader, homography: &Homography, border: &Border, grid: &mut Vec<f32>) {
    grid.clear();
    grid.resize(reader.grid_width * reader.grid_width, 0.0);
    for (cells, sign) in [(&reader.lanes.white_known, 1.0), (&reader.lanes.black_known, -1.0)] {
        for cells in cells {
            let (white, black) =
                (border.white.at_all(&cells.x, &cells.y), border.black.at_all(&cells.x, &cells.y));
            for i in 0..LANES {
                grid[cells.places[i]] = sign * ((white[i] - black[i]) * 0.5).max(1.0);
            }
        }
    }
    for cells in &reader.lanes.data {
        let (white, black) =
            (border.white.at_all(&cells.x, &cells.y), border.black.at_all(&cells.x, &cells.y));
        let [x, y] = homography.project_all(&cells.x, &cells.y);
        let (inside, values) = (frame.contains_all(&x, &y), frame.near_all(&x, &y));
        for i in 0..LANES {
            // A cell outside of the frame stays undecided.
            grid[cells.places[i]] = inside[i] * (values[i] - (white[i] + black[i]) * 0.5);
        }
    }
}

#[derive(Default)]
struct Mean {
    sum: f32,
    count: f32,
}

impl Mean {
    #[inline(always)]
    fn add(&mut self, value: f32) {
        self.sum += value;
        self.count += 1.0;
    }

    fn mean(&self) -> f32 {
        self.sum / self.count.max(1.0)
    }
}
