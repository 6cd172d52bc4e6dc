//! The border gate: does the colour change along the whole border edge as it does around a tag? Most quads are no tags,
//! and this costs 8 samples a cell width, so it comes first. It also gives the grey model that bits are compared with.

use super::homography::Homography;
use super::reader::{Cells, Reader};
use super::sample::{Frame, LANES};
use crate::simd::Kernel;

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
    /// The grey values at points given in cells.
    #[inline(always)]
    pub(crate) fn at_all(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        for i in 0..LANES {
            values[i] = self.middle + self.slope[0] * (x[i] - self.half) + self.slope[1] * (y[i] - self.half);
        }
        values
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

/// Samples both rings. `None` when the colours are the wrong way round or too much is outside of the frame.
pub(crate) fn measure(frame: &Frame, reader: &Reader, homography: &Homography) -> Option<Border> {
    frame.level().run(Measure { frame, reader, homography })
}

/// A function of its own at every level: code that is read from the caches once serves all who measure.
struct Measure<'a> {
    frame: &'a Frame<'a>,
    reader: &'a Reader,
    homography: &'a Homography,
}

impl Kernel for Measure<'_> {
    type Output = Option<Border>;

    #[inline(always)]
    fn run(self) -> Option<Border> {
        measure_rings(self.frame, self.reader, self.homography)
    }
}

#[inline(always)]
fn measure_rings(frame: &Frame, reader: &Reader, homography: &Homography) -> Option<Border> {
    let (mut white, mut black) = (Ring::default(), Ring::default());
    let half = reader.width as f32 * 0.5;
    let blocks = reader.lanes.white_ring.len();
    for (i, (white_cells, black_cells)) in
        reader.lanes.white_ring.iter().zip(&reader.lanes.black_ring).enumerate()
    {
        white.add(frame, homography, white_cells, half);
        black.add(frame, homography, black_cells, half);
        // After half the way a quad without contrast is given up.
        if i + 1 == blocks / 2 {
            let (white, black) = (white.sums(), black.sums());
            if white.value * black.count <= black.value * white.count {
                return None;
            }
        }
    }
    let (white, black) = (white.sums(), black.sums());
    if white.inside_share() < LEAST_INSIDE || black.inside_share() < LEAST_INSIDE {
        return None;
    }
    let (white_plane, black_plane) = (white.plane(half), black.plane(half));
    let contrast = white_plane.middle - black_plane.middle;
    if contrast <= 0.0 {
        return None;
    }
    let squares = white.squares_from(&white_plane) + black.squares_from(&black_plane);
    let rms = (squares / (white.count + black.count)).sqrt();
    Some(Border { white: white_plane, black: black_plane, contrast, score: contrast / (1.0 + rms) })
}

/// Sums over the samples of one ring, a lane each. Values are counted from a middle grey, so that little of their squares is
/// lost to rounding.
#[derive(Default)]
struct Ring {
    wanted: [f32; LANES],
    count: [f32; LANES],
    value: [f32; LANES],
    square: [f32; LANES],
    by_x: [f32; LANES],
    by_y: [f32; LANES],
    x_square: [f32; LANES],
}

const MIDDLE_GREY: f32 = 128.0;

impl Ring {
    #[inline(always)]
    fn add(&mut self, frame: &Frame, homography: &Homography, cells: &Cells, half: f32) {
        let [seen_x, seen_y] = homography.project_all(&cells.x, &cells.y);
        let inside = frame.contains_all(&seen_x, &seen_y);
        let values = frame.near_all(&seen_x, &seen_y);
        for i in 0..LANES {
            let (x, y) = (cells.x[i] - half, cells.y[i] - half);
            let counts = cells.counts[i] * inside[i];
            let value = counts * (values[i] - MIDDLE_GREY);
            self.wanted[i] += cells.counts[i];
            self.count[i] += counts;
            self.value[i] += value;
            self.square[i] += value * value;
            self.by_x[i] += value * x;
            self.by_y[i] += value * y;
            self.x_square[i] += counts * x * x;
        }
    }

    #[inline(always)]
    fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        for i in 0..LANES {
            sums.wanted += self.wanted[i];
            sums.count += self.count[i];
            sums.value += self.value[i];
            sums.square += self.square[i];
            sums.by_x += self.by_x[i];
            sums.by_y += self.by_y[i];
            sums.x_square += self.x_square[i];
        }
        sums
    }
}

/// Sums over a ring: values above middle grey, and these with the place relative to the tag's middle.
#[derive(Default)]
struct Sums {
    /// Samples that there are, inside of the frame or not.
    wanted: f32,
    count: f32,
    value: f32,
    square: f32,
    by_x: f32,
    by_y: f32,
    x_square: f32,
}

impl Sums {
    fn inside_share(&self) -> f32 {
        self.count / self.wanted
    }

    /// The plane with the least squared distance from the samples. A whole ring is symmetric, so its sums of x, y and xy
    /// vanish and three divisions are enough; a ring cut by the frame is taken as evenly lit.
    #[inline(always)]
    fn plane(&self, half: f32) -> GreyPlane {
        let middle = self.value / self.count + MIDDLE_GREY;
        let is_whole = self.count == self.wanted;
        let slope = if is_whole { [self.by_x / self.x_square, self.by_y / self.x_square] } else { [0.0; 2] };
        GreyPlane { slope, middle, half }
    }

    /// The sum of squared distances from that plane.
    #[inline(always)]
    fn squares_from(&self, plane: &GreyPlane) -> f32 {
        let explained = (plane.middle - MIDDLE_GREY) * self.value
            + plane.slope[0] * self.by_x
            + plane.slope[1] * self.by_y;
        (self.square - explained).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::view::LumaView;
    use tagbus_family::Family;

    #[test]
    fn both_planes_of_an_unevenly_lit_square_are_measured() {
        let family = Family::published("tag36h11").unwrap();
        let reader = Reader::new(0, &family, None, &[]);
        // A black square from 40 to 120 on white, both brighter to the right.
        let grey = |x: usize, y: usize| {
            let is_black = (40..120).contains(&x) && (40..120).contains(&y);
            (if is_black { 30 } else { 150 }) + x / 4
        };
        let luma: Vec<u8> = (0..160 * 160).map(|i| grey(i % 160, i / 160) as u8).collect();
        let view = LumaView::grey(&luma, 160, 160).unwrap();
        let corners = [[40.0, 40.0], [120.0, 40.0], [120.0, 120.0], [40.0, 120.0]];
        let homography = Homography::from_square(&corners, reader.width).unwrap();
        let border = measure(&Frame::new(Level::best(), &view), &reader, &homography).unwrap();
        assert!((border.contrast - 120.0).abs() < 1.0, "{border:?}");
        let [left, right] = [0.5, 7.5].map(|x| border.white.at_all(&[x; LANES], &[4.0; LANES])[0]);
        assert!((right - left - 17.5).abs() < 1.0, "{left} to {right}");
        // What the planes leave is the rounding of grey levels.
        assert!(border.score > 60.0, "{border:?}");
    }
}
