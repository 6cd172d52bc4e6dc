//! Large tags: profiles of four pixels, each across one edge with no other edge near.
//!
//! Where cells are larger than what blur reaches, a pixel near the middle of a cell's side shows that one edge alone, and
//! the four pixels of a profile share all derivatives but those along it. So their products are summed up first and laid out
//! over the eighteen parameters once a profile, which is a third of the work of windows, and the model is one step.

use super::super::sample::Frame;
use super::blur::normal;
use super::edges::{self, Stretch};
use super::grown::MOST_GROWTH;
use super::model::{BLOOM, CURVE, GAIN, LOG_BLUR, MAP, Model, OFFSET, Parameters};
use super::patch::Patch;
use super::pixels::{BLOCK, Lanes, ZERO};
use super::solve::{NormalEquations, PARAMETERS};

/// Where cells are at least five pixels wide: the outermost pixels of a profile lie three away from the next edge.
pub(super) const MOST_CELLS_A_PIXEL: f64 = 0.2;
/// With fewer profiles windows see more.
pub(super) const LEAST: usize = 60;
/// Pixels of a profile.
pub(super) const PIXELS: usize = 2 * edges::HALF_PROFILE;
/// What is left out at both ends of an edge, where another edge may be near: so much of a cell, but at most so many pixels.
const END: (f64, f64) = (0.45, 4.0);
/// Standard deviations of the blur that must fit into that: beyond, less than a hundredth of an edge is seen.
const DEVIATIONS: f32 = 2.6;

const ONES: Lanes = [1.0; BLOCK];
/// Columns of a pixel's own derivatives: by the place across the edge, by offset, gain, blur, bloom and curve; the residual.
const PLACE: usize = 0;
const ONE: usize = 1;
const BENT: usize = 2;
const BLURRED: usize = 3;
const GROWN: usize = 4;
const CURVED: usize = 5;
const RESIDUAL: usize = 6;
const COLUMNS: usize = 7;

/// Some profiles side by side.
#[repr(align(64))]
pub(super) struct Block {
    /// 0 when their edges are places along u, 1 along v.
    axis: usize,
    /// The first pixel, and from each to the next, in units of the patch.
    first: [Lanes; 2],
    step: [Lanes; 2],
    /// Where the edge lies, in cells, and 1 where white follows, -1 where black does.
    line: Lanes,
    sign: Lanes,
    grey: [Lanes; PIXELS],
    /// 1, or 0 behind the last profile of a block.
    weight: Lanes,
}

impl Block {
    const EMPTY: Self = Self {
        axis: 0,
        first: [ZERO; 2],
        step: [ZERO; 2],
        line: ZERO,
        sign: ZERO,
        grey: [ZERO; PIXELS],
        weight: ZERO,
    };
}

/// Pixels at both ends of an edge that are left out in a tag with so many cells to a pixel.
fn end(cells_a_pixel: f64) -> f64 {
    (END.0 / cells_a_pixel).min(END.1)
}

/// Whether profiles show one edge alone, by the blur and the growth of white that were found.
pub(super) fn are_apart(parameters: &Parameters, cells_a_pixel: f64) -> bool {
    parameters.reach(DEVIATIONS) <= end(cells_a_pixel) as f32
}

/// Buffers of the choice.
#[derive(Default)]
pub(super) struct Profiles {
    blocks: Vec<Block>,
    used: usize,
    /// Profiles in the last block that is used, and in all.
    filled: usize,
    count: usize,
}

impl Profiles {
    /// Makes room for all profiles of any tag.
    pub(super) fn reserve(&mut self) {
        // Each axis may end with a block that is not full.
        let most = (edges::MOST_PLACES / PIXELS).div_ceil(BLOCK) + 2;
        while self.blocks.len() < most {
            self.blocks.push(Block::EMPTY);
        }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks[..self.used]
    }

    /// Takes profiles across those parts of stretches that are far from other edges.
    #[inline(always)]
    pub(super) fn choose(&mut self, frame: &Frame, patch: &Patch, stretches: &[Stretch], cells_a_pixel: f64) {
        (self.used, self.filled, self.count) = (0, BLOCK, 0);
        let end = end(cells_a_pixel);
        let spacing = edges::spacing(stretches, end, frame.size());
        let mut next = 0.0;
        for stretch in stretches {
            let Some(inner) = stretch.without_ends(end) else { continue };
            if self.used > 0 && self.blocks[self.used - 1].axis != inner.axis {
                self.filled = BLOCK;
            }
            inner.visit(frame.size(), spacing, &mut next, |place, step| {
                self.add(frame, patch, stretch, place, step);
            });
        }
    }

    #[inline(always)]
    fn add(&mut self, frame: &Frame, patch: &Patch, edge: &Stretch, place: [usize; 2], step: [usize; 2]) {
        if self.filled == BLOCK {
            if self.blocks.len() == self.used {
                self.blocks.push(Block::EMPTY);
            }
            self.blocks[self.used].weight = ZERO;
            self.blocks[self.used].axis = edge.axis;
            self.used += 1;
            self.filled = 0;
        }
        let (block, lane) = (&mut self.blocks[self.used - 1], self.filled);
        let unit = patch.unit_step();
        let first = patch.place_of([place[0] as f64 + 0.5, place[1] as f64 + 0.5]);
        for a in 0..2 {
            block.first[a][lane] = first[a];
            block.step[a][lane] = step[a] as f32 * unit;
        }
        block.line[lane] = edge.line as f32;
        block.sign[lane] = f32::from(edge.sign);
        block.weight[lane] = 1.0;
        for i in 0..PIXELS {
            let grey = frame.pixel(place[0] + i * step[0], place[1] + i * step[1]);
            block.grey[i][lane] = f32::from(grey);
        }
        self.filled += 1;
        self.count += 1;
    }
}

/// Where profiles lie: at their middles and at each pixel.
#[repr(align(64))]
struct Across {
    /// The middle, in units of the patch.
    middle: [Lanes; 2],
    /// Derivatives of the place among the cells by the five numbers of the map that it depends on.
    by_map: [Lanes; 5],
    /// How far behind the edge each pixel lies, in standard deviations of the blur.
    behind: [Lanes; PIXELS],
    /// Derivatives of that by the place in cells and by bloom in pixels.
    by_place: Lanes,
    by_bloom: Lanes,
}

impl Model {
    /// Adds a block of profiles to the equations; `rms` is the root mean square residual of the step before.
    #[inline(always)]
    pub(super) fn add_profiles(&self, block: &Block, rms: f32, equations: &mut NormalEquations) {
        let across = self.across(block);
        let mut sums = [[ZERO; COLUMNS]; RESIDUAL];
        for i in 0..PIXELS {
            let columns = self.columns(block, &across, i);
            let weight = equations.count(&columns[RESIDUAL], &block.weight, rms);
            add_pixels(&mut sums, &columns, &weight);
        }
        lay_out(equations, block.axis, &across, &sums);
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn across(&self, block: &Block) -> Across {
        let row = [self.map[3 * block.axis], self.map[3 * block.axis + 1], self.map[3 * block.axis + 2]];
        let [h6, h7] = [self.map[6], self.map[7]];
        let sigma = self.sigma[block.axis];
        let mut a = Across {
            middle: [ZERO; 2],
            by_map: [ZERO; 5],
            behind: [ZERO; PIXELS],
            by_place: ZERO,
            by_bloom: ZERO,
        };
        let mut growth = ZERO;
        for l in 0..BLOCK {
            let half = 0.5 * (PIXELS - 1) as f32;
            let x = block.first[0][l] + half * block.step[0][l];
            let y = block.first[1][l] + half * block.step[1][l];
            let depth = 1.0 / (h6 * x + h7 * y + 1.0);
            let place = (row[0] * x + row[1] * y + row[2]) * depth;
            let (by_x, by_y) = ((row[0] - place * h6) * depth, (row[1] - place * h7) * depth);
            let speed = (by_x * by_x + by_y * by_y).sqrt();
            let inverse = 1.0 / (sigma * speed);
            (a.middle[0][l], a.middle[1][l]) = (x, y);
            a.by_map[0][l] = depth * x;
            a.by_map[1][l] = depth * y;
            a.by_map[2][l] = depth;
            a.by_map[3][l] = -place * depth * x;
            a.by_map[4][l] = -place * depth * y;
            a.by_place[l] = block.sign[l] * inverse;
            a.by_bloom[l] = inverse * speed * self.per_unit;
            growth[l] = (self.bloom * speed).clamp(-MOST_GROWTH, MOST_GROWTH) * inverse;
        }
        for i in 0..PIXELS {
            for l in 0..BLOCK {
                let x = block.first[0][l] + i as f32 * block.step[0][l];
                let y = block.first[1][l] + i as f32 * block.step[1][l];
                let place = (row[0] * x + row[1] * y + row[2]) / (h6 * x + h7 * y + 1.0);
                a.behind[i][l] = (place - block.line[l]) * a.by_place[l] + growth[l];
            }
        }
        a
    }

    /// Derivatives and residuals of the `i`-th pixel of every profile.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
    fn columns(&self, block: &Block, across: &Across, i: usize) -> [Lanes; COLUMNS] {
        let mut columns = [ZERO; COLUMNS];
        let g = &self.grey;
        for l in 0..BLOCK {
            let x = block.first[0][l] + i as f32 * block.step[0][l];
            let y = block.first[1][l] + i as f32 * block.step[1][l];
            let z = across.behind[i][l];
            let (share, density) = normal(z);
            let gain = g[3] + g[4] * x + g[5] * y;
            let bend = share * (1.0 - share);
            let bent = share + self.curve * bend;
            let slope = gain * (1.0 + self.curve * (1.0 - 2.0 * share)) * density;
            columns[PLACE][l] = slope * across.by_place[l];
            columns[ONE][l] = 1.0;
            columns[BENT][l] = bent;
            columns[BLURRED][l] = -z * slope;
            columns[GROWN][l] = slope * across.by_bloom[l];
            columns[CURVED][l] = gain * bend;
            columns[RESIDUAL][l] = block.grey[i][l] - (g[0] + g[1] * x + g[2] * y + gain * bent);
        }
        columns
    }
}

/// Adds the products of a pixel's columns to the sums of its profile.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "the compiler makes vectors of one index over many arrays")]
fn add_pixels(sums: &mut [[Lanes; COLUMNS]; RESIDUAL], columns: &[Lanes; COLUMNS], weight: &Lanes) {
    for a in 0..RESIDUAL {
        let weighted = product(&columns[a], weight);
        for b in a..COLUMNS {
            for l in 0..BLOCK {
                sums[a][b][l] += weighted[l] * columns[b][l];
            }
        }
    }
}

#[inline(always)]
fn product(a: &Lanes, b: &Lanes) -> Lanes {
    let mut product = ZERO;
    for l in 0..BLOCK {
        product[l] = a[l] * b[l];
    }
    product
}

/// Adds the sums of profiles to the equations of all parameters.
#[inline(always)]
#[allow(
    clippy::needless_range_loop,
    reason = "not by iterators, which stay calls without the level's instructions"
)]
fn lay_out(
    equations: &mut NormalEquations,
    axis: usize,
    across: &Across,
    sums: &[[Lanes; COLUMNS]; RESIDUAL],
) {
    let map = [MAP + 3 * axis, MAP + 3 * axis + 1, MAP + 3 * axis + 2, MAP + 6, MAP + 7];
    let plane = [&ONES, &across.middle[0], &across.middle[1]];
    let others = [(BLURRED, LOG_BLUR + axis), (GROWN, BLOOM), (CURVED, CURVE), (RESIDUAL, PARAMETERS)];
    for a in 0..map.len() {
        let by_map = &across.by_map[a];
        let weighted = [PLACE, ONE, BENT].map(|column| product(&sums[PLACE][column], by_map));
        for b in a..map.len() {
            equations.add_products(map[a], map[b], &weighted[0], &across.by_map[b]);
        }
        for b in 0..plane.len() {
            equations.add_products(map[a], OFFSET + b, &weighted[1], plane[b]);
            equations.add_products(map[a], GAIN + b, &weighted[2], plane[b]);
        }
        for (column, other) in others {
            equations.add_products(map[a], other, &sums[PLACE][column], by_map);
        }
    }
    for a in 0..plane.len() {
        let weighted = [(ONE, ONE), (ONE, BENT), (BENT, BENT)].map(|(c, d)| product(&sums[c][d], plane[a]));
        for b in 0..plane.len() {
            equations.add_products(OFFSET + a, GAIN + b, &weighted[1], plane[b]);
        }
        for b in a..plane.len() {
            equations.add_products(OFFSET + a, OFFSET + b, &weighted[0], plane[b]);
            equations.add_products(GAIN + a, GAIN + b, &weighted[2], plane[b]);
        }
        for (column, other) in others {
            equations.add_products(OFFSET + a, other, &sums[ONE][column], plane[a]);
            equations.add_products(GAIN + a, other, &sums[BENT][column], plane[a]);
        }
    }
    for a in 0..3 {
        for b in a..4 {
            equations.add_products(others[a].1, others[b].1, &sums[others[a].0][others[b].0], &ONES);
        }
    }
}

#[cfg(test)]
mod tests {
    use tagbus_family::Family;

    use super::super::super::homography::Homography;
    use super::super::super::reader::Reader;
    use super::super::pattern::Pattern;
    use super::super::pixels::{Laid, Pixels};
    use super::super::solve::Rows;
    use super::*;
    use crate::simd::Level;
    use crate::view::LumaView;

    /// Of cells about 17 pixels wide.
    const SMALLNESS: f64 = 1.0 / 17.0;
    const CORNERS: [[f64; 2]; 4] = [[40.3, 34.8], [181.9, 52.4], [167.2, 193.1], [26.6, 172.7]];

    #[test]
    fn profiles_lead_where_windows_around_every_pixel_lead() {
        let family = Family::published("tag36h11").unwrap();
        let reader = Reader::new(0, &family, None, &[]);
        let mut pattern = Pattern::default();
        pattern.paint(&reader, family.codes()[7]);
        let bytes: Vec<u8> = (0..220 * 220).map(|i| if i % 220 + i / 220 > 220 { 180 } else { 60 }).collect();
        let view = LumaView::grey(&bytes, 220, 220).unwrap();
        let frame = Frame::new(Level::SCALAR, &view);
        let patch = Patch::around(&CORNERS);
        let to_frame = Homography::from_square(&CORNERS, reader.width).unwrap();
        let mut stretches = Vec::new();
        edges::find(&pattern, &to_frame, &mut stretches);
        let mut parameters = Parameters::for_tests(&to_frame.inverse().unwrap(), &patch);
        for bloom in [0.0, 0.6, -0.5] {
            parameters.bloom = bloom;
            let model = Model::new(&pattern, &parameters, patch.scale);
            let mut profiles = Profiles::default();
            profiles.choose(&frame, &patch, &stretches, SMALLNESS);
            let (mut by_profiles, mut by_windows) = (NormalEquations::default(), NormalEquations::default());
            profiles.blocks().iter().for_each(|block| model.add_profiles(block, f32::MAX, &mut by_profiles));
            let mut pixels = Pixels::default();
            let inner: Vec<Stretch> =
                stretches.iter().filter_map(|s| s.without_ends(end(SMALLNESS))).collect();
            pixels.choose::<2>(&frame, &Laid { pattern: &pattern, patch: &patch, model: &model }, &inner);
            let mut rows = Rows([ZERO; PARAMETERS + 1]);
            for block in pixels.blocks() {
                model.rows::<2>(block, &mut rows);
                by_windows.add(&rows, &block.weight, f32::MAX);
            }
            assert_eq!(profiles.count() * PIXELS, pixels.count());
            by_profiles.assert_near(&by_windows, 0.03);
        }
    }
}
