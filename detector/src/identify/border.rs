//! The border gate: does the colour change along the whole border edge as it does around a tag? Most quads are no tags,
//! and this costs 8 samples a cell width, so it comes first. It also gives the grey model that bits are compared with.

use super::homography::Homography;
use super::reader::Reader;
use super::sample::Frame;

/// What white and black look like across a tag, and how well the border fits that.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    pub(crate) white: GreyPlane,
    pub(crate) black: GreyPlane,
    /// White minus black at the tag's middle, grey levels.
    pub(crate) contrast: f32,
    /// Contrast over one plus the root mean square distance of the border's samples from the planes.
    pub(crate) score: f32,
}

/// A grey value that changes evenly across the tag.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GreyPlane {
    slope: [f32; 2],
    middle: f32,
    /// Half the border edge's width in cells.
    half: f32,
}

impl GreyPlane {
    /// The grey value at a point given in cells.
    #[inline(always)]
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> f32 {
        self.middle + self.slope[0] * (x as f32 - self.half) + self.slope[1] * (y as f32 - self.half)
    }
}

impl Border {
    /// Black at the tag's middle, grey levels.
    pub(crate) fn black_level(&self) -> f32 {
        self.black.middle
    }

    /// Whether white or black lies at the end of the scale, where the sensor clips.
    pub(crate) fn is_saturated(&self) -> bool {
        self.white.middle >= 254.0 || self.black.middle <= 1.0
    }
}

/// Share of the border's samples that must lie inside the frame.
const LEAST_INSIDE: f32 = 0.75;
/// Where a border has more cells than this, every second or third is sampled.
const MOST_SAMPLES: usize = 128;

/// Samples both rings. `None` when the corners are no quad or the colours are the wrong way round.
#[inline(always)]
pub(crate) fn measure(frame: &Frame, reader: &Reader, corners: &[[f64; 2]; 4]) -> Option<Border> {
    let homography = Homography::from_square(corners, reader.width)?;
    let (mut white, mut black) = (Ring::new(reader.width), Ring::new(reader.width));
    let step = reader.rings.len().div_ceil(MOST_SAMPLES);
    let samples = reader.rings.len().div_ceil(step);
    for (i, cell) in reader.rings.iter().step_by(step).enumerate() {
        white.add(cell.white, frame.at(homography.project(cell.white)));
        black.add(cell.black, frame.at(homography.project(cell.black)));
        // After half the way a quad without contrast is given up.
        if i + 1 == samples / 2 && white.sum * black.count <= black.sum * white.count {
            return None;
        }
    }
    let wanted = LEAST_INSIDE * samples as f32;
    if white.count < wanted || black.count < wanted {
        return None;
    }
    let (white_plane, black_plane) = (white.plane(), black.plane());
    let contrast = white_plane.middle - black_plane.middle;
    if contrast <= 0.0 {
        return None;
    }
    let squares = white.squares_from(&white_plane) + black.squares_from(&black_plane);
    let rms = (squares / (white.count + black.count)).sqrt();
    Some(Border { white: white_plane, black: black_plane, contrast, score: contrast / (1.0 + rms) })
}

/// The samples of one ring.
struct Ring {
    points: [[f32; 2]; MOST_SAMPLES],
    values: [f32; MOST_SAMPLES],
    taken: usize,
    missing: bool,
    half: f32,
    count: f32,
    sum: f32,
}

impl Ring {
    #[inline(always)]
    fn new(width: f64) -> Self {
        let half = width as f32 * 0.5;
        Self {
            points: [[0.0; 2]; MOST_SAMPLES],
            values: [0.0; MOST_SAMPLES],
            taken: 0,
            missing: false,
            half,
            count: 0.0,
            sum: 0.0,
        }
    }

    #[inline(always)]
    fn add(&mut self, cell: [f64; 2], value: Option<f32>) {
        let Some(value) = value else {
            self.missing = true;
            return;
        };
        self.points[self.taken] = [cell[0] as f32 - self.half, cell[1] as f32 - self.half];
        self.values[self.taken] = value;
        self.taken += 1;
        self.count += 1.0;
        self.sum += value;
    }

    /// The plane with the least squared distance from the samples. A whole ring is symmetric, so its sums of x, y and xy
    /// vanish and three divisions are enough; a ring cut by the frame is taken as evenly lit.
    #[inline(always)]
    fn plane(&self) -> GreyPlane {
        let middle = self.sum / self.count;
        if self.missing {
            return GreyPlane { slope: [0.0; 2], middle, half: self.half };
        }
        let (mut squares, mut products) = (0.0, [0.0; 2]);
        for ([x, y], value) in self.points[..self.taken].iter().zip(&self.values) {
            squares += x * x;
            products[0] += x * value;
            products[1] += y * value;
        }
        GreyPlane { slope: [products[0] / squares, products[1] / squares], middle, half: self.half }
    }

    #[inline(always)]
    fn squares_from(&self, plane: &GreyPlane) -> f32 {
        let samples = self.points[..self.taken].iter().zip(&self.values);
        samples
            .map(|([x, y], value)| {
                let off = value - (plane.middle + plane.slope[0] * x + plane.slope[1] * y);
                off * off
            })
            .sum()
    }
}
