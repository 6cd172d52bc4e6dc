//! What the model says about pixels, and how that changes with each parameter.

use nalgebra::Matrix3;

use super::super::border::Border;
use super::super::homography::Homography;
use super::grown::Steps;
use super::patch::Patch;
use super::pattern::Pattern;
use super::pixels::{BLOCK, Block, Lanes, ZERO};
use super::solve::{PARAMETERS, Rows};
use super::window::Blurred;

/// Blur that is assumed before anything is measured: optics, sensor and demosaicing, pixels.
pub(super) const EXPECTED_SIGMA: f32 = 0.75;
/// Limits of the blur's logarithm.
const LOG_SIGMA: (f32, f32) = (-1.05, 1.25);
/// The largest move of the map's offsets in one step, cells.
const LONGEST_STEP: f64 = 0.5;
/// The largest change of the blur's logarithm in one step.
const LONGEST_LOG_STEP: f32 = 0.5;
/// The curve stays within this on both sides of 0. Narrower limits (1) make clipped tags swing to and fro from step to step.
const MOST_CURVE: f32 = 2.0;
/// Up to here white's growth is as good as a derivative says, pixels.
const LINEAR_BLOOM: f32 = 0.1;
/// Changes of the blur's logarithm and of white's growth as it is seen (pixels) that hardly matter to the corners.
const SETTLED_LOG_SIGMA: f32 = 0.25;
const SETTLED_GROWTH: f32 = 0.05;
/// The curve lifts the middle of an edge by a quarter of itself, which moves the edge by so many standard deviations of the blur: a
/// quarter over the normal distribution's density there.
const CURVE_AS_GROWTH: f32 = 0.627;

/// Places of the parameters: map from patch to cells, offset plane, gain plane, blur along u and v, bloom, curve.
pub(super) const MAP: usize = 0;
pub(super) const OFFSET: usize = 8;
pub(super) const GAIN: usize = 11;
pub(super) const LOG_BLUR: usize = 14;
pub(super) const BLOOM: usize = 16;
pub(super) const CURVE: usize = 17;

/// All parameters of the model. The map's numbers are kept in f64, since corners are wanted to a thousandth of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameters {
    map: [f64; 8],
    grey: [f32; 6],
    pub(super) log_sigma: [f32; 2],
    /// How far white has grown before the blur, pixels.
    pub(super) bloom: f32,
    /// How far the sensor's curve lifts what lies between black and white: by a quarter of this in the middle.
    pub(super) curve: f32,
}

impl Parameters {
    /// From the map of refined corners (frame pixels to cells) and the levels that the border shows.
    pub(super) fn new(to_cells: &Homography, patch: &Patch, border: &Border) -> Self {
        let [x, y] = patch.middle;
        let to_frame = Matrix3::new(patch.scale, 0.0, x, 0.0, patch.scale, y, 0.0, 0.0, 1.0);
        let map = to_cells.after(&to_frame).to_array();
        let black = border.black_level();
        Self {
            map: std::array::from_fn(|i| map[i]),
            grey: [black, 0.0, 0.0, border.contrast, 0.0, 0.0],
            log_sigma: [EXPECTED_SIGMA.ln(); 2],
            bloom: 0.0,
            curve: 0.0,
        }
    }

    /// White minus black at the tag's middle.
    pub(super) fn gain(&self) -> f32 {
        self.grey[3]
    }

    /// How far from an edge it can be seen, pixels: so many standard deviations of the blur, and what has grown.
    pub(super) fn reach(&self, deviations: f32) -> f32 {
        self.log_sigma[0].max(self.log_sigma[1]).exp() * deviations + self.bloom.abs()
    }

    /// Whether blur and bloom are so near to others that a step more would hardly move the corners.
    pub(super) fn look_like(&self, other: &Self) -> bool {
        let blur = |i: usize| (self.log_sigma[i] - other.log_sigma[i]).abs();
        let growth = self.seen_growth() - other.seen_growth();
        blur(0).max(blur(1)) < SETTLED_LOG_SIGMA && growth.abs() < SETTLED_GROWTH
    }

    /// How far white seems to have grown at an edge with no other near, pixels. Bloom and curve look alike there, and steps may
    /// trade one for the other long after the corners lie still.
    fn seen_growth(&self) -> f32 {
        let sigma = (0.5 * (self.log_sigma[0] + self.log_sigma[1])).exp();
        self.bloom + CURVE_AS_GROWTH * sigma * self.curve
    }

    /// The map from cells to patch units.
    pub(super) fn to_homography(self) -> Option<Homography> {
        let m = self.map;
        Homography::from_rows([m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], 1.0]).inverse()
    }

    /// Goes a step, shortened where it would leave the range in which the model is linear.
    pub(super) fn step(&mut self, step: &[f64; PARAMETERS]) {
        let longest = step[MAP + 2].abs().max(step[MAP + 5].abs());
        let share = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        for (value, change) in self.map.iter_mut().zip(&step[MAP..OFFSET]) {
            *value += share * change;
        }
        let change = |place: usize| (share * step[place]) as f32;
        for (i, value) in self.grey.iter_mut().enumerate() {
            *value += change(OFFSET + i);
        }
        for (i, value) in self.log_sigma.iter_mut().enumerate() {
            let change = change(LOG_BLUR + i).clamp(-LONGEST_LOG_STEP, LONGEST_LOG_STEP);
            *value = (*value + change).clamp(LOG_SIGMA.0, LOG_SIGMA.1);
        }
        self.bloom += change(BLOOM);
        self.curve = (self.curve + change(CURVE)).clamp(-MOST_CURVE, MOST_CURVE);
    }
}

/// The model with parameters in force.
pub(super) struct Model {
    margin: f32,
    pub(super) map: [f32; 8],
    pub(super) grey: [f32; 6],
    /// Blur in units of the patch, along u and v.
    pub(super) sigma: [f32; 2],
    /// Growth of white in units of the patch.
    pub(super) bloom: f32,
    pub(super) curve: f32,
    pub(super) per_unit: f32,
}

/// Where pixels lie in cells, and how fast that changes.
#[repr(align(64))]
pub(super) struct Places {
    pub(super) u: Coordinate,
    pub(super) v: Coordinate,
    /// What the projection divides by, inverted.
    pub(super) depth: Lanes,
}

/// One of a pixel's two coordinates among the cells, counted as the pattern does.
#[repr(align(64))]
pub(super) struct Coordinate {
    pub(super) place: Lanes,
    /// How fast it changes along x and along y of the patch, and in the direction in which it changes fastest.
    by: [Lanes; 2],
    pub(super) speed: Lanes,
}

#[cfg(test)]
impl Coordinate {
    /// Places of a picture that has a unit of the patch a cell and is not turned.
    pub(super) fn at_unit_speed(place: Lanes) -> Self {
        Self { place, by: [[1.0; BLOCK], ZERO], speed: [1.0; BLOCK] }
    }
}

impl Model {
    pub(super) fn new(pattern: &Pattern, parameters: &Parameters, scale: f64) -> Self {
        Self {
            margin: pattern.margin() as f32,
            map: parameters.map.map(|v| v as f32),
            grey: parameters.grey,
            sigma: parameters.log_sigma.map(|log| log.exp() / scale as f32),
            bloom: parameters.bloom / scale as f32,
            curve: parameters.curve,
            per_unit: 1.0 / scale as f32,
        }
    }

    /// Residuals and derivatives of a block of pixels whose windows have `WINDOW` cells along an axis.
    #[inline(always)]
    pub(super) fn rows<const WINDOW: usize>(&self, block: &Block, rows: &mut Rows) {
        let places = self.places(&block.x, &block.y);
        let blurred = if self.bloom.abs() <= LINEAR_BLOOM * self.per_unit {
            let mut blurred = Blurred::plain::<WINDOW>(block, &places, self.sigma);
            for l in 0..BLOCK {
                let growth =
                    blurred.by_growth_u[l] * places.u.speed[l] + blurred.by_growth_v[l] * places.v.speed[l];
                blurred.value[l] += self.bloom * growth;
            }
            blurred
        } else {
            let along_u = Steps::<WINDOW>::new(&places.u, &block.first_u, self.sigma[0], self.bloom);
            let along_v = Steps::<WINDOW>::new(&places.v, &block.first_v, self.sigma[1], self.bloom);
            Blurred::grown(&block.rows, &along_u, &along_v, self.bloom > 0.0)
        };
        self.derive(block, &places, &blurred, rows);
    }

    /// Where pixels lie.
    #[inline(always)]
    pub(super) fn places(&self, x: &Lanes, y: &Lanes) -> Places {
        let h = &self.map;
        let mut depth = ZERO;
        for l in 0..BLOCK {
            depth[l] = 1.0 / (h[6] * x[l] + h[7] * y[l] + 1.0);
        }
        let u = self.coordinate([h[0], h[1], h[2]], x, y, &depth);
        let v = self.coordinate([h[3], h[4], h[5]], x, y, &depth);
        Places { u, v, depth }
    }

    #[inline(always)]
    fn coordinate(&self, row: [f32; 3], x: &Lanes, y: &Lanes, depth: &Lanes) -> Coordinate {
        let mut c = Coordinate { place: ZERO, by: [ZERO; 2], speed: ZERO };
        for l in 0..BLOCK {
            let place = (row[0] * x[l] + row[1] * y[l] + row[2]) * depth[l];
            let by_x = (row[0] - place * self.map[6]) * depth[l];
            let by_y = (row[1] - place * self.map[7]) * depth[l];
            c.place[l] = place + self.margin;
            c.by[0][l] = by_x;
            c.by[1][l] = by_y;
            c.speed[l] = (by_x * by_x + by_y * by_y).sqrt();
        }
        c
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn derive(&self, block: &Block, p: &Places, t: &Blurred, rows: &mut Rows) {
        let (g, Rows(rows)) = (&self.grey, rows);
        for l in 0..BLOCK {
            let (x, y, depth) = (block.x[l], block.y[l], p.depth[l]);
            let growth = (t.by_growth_u[l] * p.u.speed[l] + t.by_growth_v[l] * p.v.speed[l]) * self.per_unit;
            let gain = g[3] + g[4] * x + g[5] * y;
            let bend = t.value[l] * (1.0 - t.value[l]);
            let bent = t.value[l] + self.curve * bend;
            let predicted = g[0] + g[1] * x + g[2] * y + gain * bent;
            let slope = gain * (1.0 + self.curve * (1.0 - 2.0 * t.value[l]));
            let (by_u, by_v) = (slope * t.by_u[l] * depth, slope * t.by_v[l] * depth);
            let by_depth = -(by_u * (p.u.place[l] - self.margin) + by_v * (p.v.place[l] - self.margin));
            rows[MAP][l] = by_u * x;
            rows[MAP + 1][l] = by_u * y;
            rows[MAP + 2][l] = by_u;
            rows[MAP + 3][l] = by_v * x;
            rows[MAP + 4][l] = by_v * y;
            rows[MAP + 5][l] = by_v;
            rows[MAP + 6][l] = by_depth * x;
            rows[MAP + 7][l] = by_depth * y;
            rows[OFFSET][l] = 1.0;
            rows[OFFSET + 1][l] = x;
            rows[OFFSET + 2][l] = y;
            rows[GAIN][l] = bent;
            rows[GAIN + 1][l] = bent * x;
            rows[GAIN + 2][l] = bent * y;
            rows[LOG_BLUR][l] = slope * t.by_blur_u[l];
            rows[LOG_BLUR + 1][l] = slope * t.by_blur_v[l];
            rows[BLOOM][l] = slope * growth;
            rows[CURVE][l] = gain * bend;
            rows[PARAMETERS][l] = block.grey[l] - predicted;
        }
    }
}

#[cfg(test)]
impl Parameters {
    /// A tag in light that falls from one side, a little blurred.
    pub(super) fn for_tests(to_cells: &Homography, patch: &Patch) -> Self {
        let [x, y] = patch.middle;
        let map =
            to_cells.after(&Matrix3::new(patch.scale, 0.0, x, 0.0, patch.scale, y, 0.0, 0.0, 1.0)).to_array();
        Self {
            map: std::array::from_fn(|i| map[i]),
            grey: [40.0, 3.0, -5.0, 150.0, 8.0, 4.0],
            log_sigma: [-0.1, 0.2],
            bloom: 0.0,
            curve: 0.3,
        }
    }
}

#[cfg(test)]
mod tests {
    use tagbus_family::Family;

    use super::super::super::reader::Reader;
    use super::super::pattern::MOST_CELLS;
    use super::super::pixels::ZERO;
    use super::*;

    /// Large against what single precision and the approximated distribution blur.
    const STEP: f64 = 0.01;
    const CORNERS: [[f64; 2]; 4] = [[20.3, 14.8], [61.9, 22.4], [57.2, 63.1], [16.6, 52.7]];

    /// A block of pixels all over the tag, and the pattern and the parameters that they belong to.
    fn block_on_a_tag(bloom: f32) -> (Block, Pattern, Parameters, f64) {
        let family = Family::published("tag36h11").unwrap();
        let reader = Reader::new(0, &family, None, &[]);
        let mut pattern = Pattern::default();
        pattern.paint(&reader, family.codes()[7]);
        let patch = Patch::around(&CORNERS);
        let to_cells = Homography::from_square(&CORNERS, reader.width).unwrap().inverse().unwrap();
        let parameters = Parameters { bloom, ..Parameters::for_tests(&to_cells, &patch) };
        let mut block = Block::EMPTY;
        let model = Model::new(&pattern, &parameters, patch.scale);
        for l in 0..BLOCK {
            let point = [22.0 + (l % 7) as f64 * 5.3, 24.0 + (l / 7) as f64 * 6.1];
            [block.x[l], block.y[l]] = patch.place_of(point);
        }
        let at = model.places(&block.x, &block.y);
        for l in 0..BLOCK {
            let first = |place: f32| place as usize - 2;
            let (u, v) = (first(at.u.place[l]), first(at.v.place[l]));
            (block.first_u[l], block.first_v[l]) = (u as f32, v as f32);
            for (j, row) in block.rows.iter_mut().enumerate() {
                row[l] = pattern.word(u, v + j);
            }
        }
        (block, pattern, parameters, patch.scale)
    }

    #[test]
    fn derivatives_say_how_residuals_change() {
        for bloom in [0.4, 0.0, -0.3] {
            compare_derivatives(bloom);
        }
    }

    fn compare_derivatives(bloom: f32) {
        let (block, pattern, parameters, scale) = block_on_a_tag(bloom);
        let rows_of = |parameters: &Parameters| {
            let mut rows = Rows([ZERO; PARAMETERS + 1]);
            Model::new(&pattern, parameters, scale).rows::<MOST_CELLS>(&block, &mut rows);
            rows
        };
        let rows = rows_of(&parameters);
        for place in 0..PARAMETERS {
            let moved = |by: f64| {
                let mut step = [0.0; PARAMETERS];
                step[place] = by;
                let mut parameters = parameters;
                parameters.step(&step);
                rows_of(&parameters).0[PARAMETERS]
            };
            let (more, less) = (moved(STEP), moved(-STEP));
            // Where cells become larger the blur becomes less in cells; that is left out.
            let slack = if [0, 1, 3, 4, 6, 7].contains(&place) { 0.2 } else { 0.01 };
            let largest = rows.0[place].iter().fold(0.0, |most: f64, d| most.max(f64::from(d.abs())));
            for l in 0..BLOCK {
                let change = f64::from(less[l] - more[l]) / (2.0 * STEP);
                let derivative = f64::from(rows.0[place][l]);
                assert!(
                    (change - derivative).abs() < slack * largest,
                    "bloom {bloom}, parameter {place}, pixel {l}: {change}, not {derivative}"
                );
            }
        }
    }
}
