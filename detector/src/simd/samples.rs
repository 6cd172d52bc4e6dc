//! Points of a frame that are looked at together: the values between pixels, and where these cross a level.

use crate::view::{Geometry, LumaView};

/// Points that are sampled together: arithmetic on all of them is done in vectors.
pub(crate) const LANES: usize = 8;

/// The pixels of a frame, and where they lie.
#[derive(Clone, Copy)]
pub(crate) struct Pixels<'a> {
    /// From the first pixel on.
    pub(super) bytes: &'a [u8],
    /// Bytes from a pixel to the one below.
    pub(super) stride: usize,
    /// Bytes from a pixel to the one on its right.
    pub(super) step: usize,
    /// The last pixel's centre, from the first one's.
    pub(super) last: [f32; 2],
    /// Where the last square of pixels begins, if that is a 32-bit number.
    #[cfg_attr(
        not(target_arch = "aarch64"),
        allow(dead_code, reason = "only NEON's kernel reads without a check")
    )]
    last_square: Option<u32>,
}

/// How near points may come to the last pixel's centre: more than f32 rounds a coordinate of the largest frames.
pub(super) const RIM: f32 = 0.01;

impl<'a> Pixels<'a> {
    /// The pixels of a view.
    pub(crate) fn new(view: &LumaView<'a>) -> Self {
        let Geometry { offset, width, height, row_stride: stride, pixel_step: step } = view.geometry();
        let bytes = &view.bytes()[offset..];
        let last = [width, height].map(|side| side as f32 - 1.0);
        // Numbers of 32 bits hold all places then.
        let is_small = u32::try_from(bytes.len()).is_ok();
        let last_square = if is_small { bytes.len().checked_sub(stride + step + 1) } else { None };
        Self { bytes, stride, step, last, last_square: last_square.map(|place| place as u32) }
    }

    /// The grey value of a pixel.
    #[inline(always)]
    pub(crate) fn at(&self, column: usize, row: usize) -> u8 {
        self.bytes[row * self.stride + column * self.step]
    }

    /// A pixel, the one on its right, and the two below these.
    #[inline(always)]
    fn square(&self, column: usize, row: usize) -> [u8; 4] {
        let (right, below) = (self.step, self.stride);
        let square = &self.bytes[row * self.stride + column * self.step..][..below + right + 1];
        [square[0], square[right], square[below], square[below + right]]
    }

    /// Where the last square of pixels begins, if that is a 32-bit number: whatever begins there or before ends inside of the bytes.
    #[cfg(target_arch = "aarch64")]
    pub(super) fn last_square(&self) -> Option<u32> {
        self.last_square
    }
}

/// Whether points lie between the outermost pixel centres, so that they have a grey value: 1 or 0.
#[inline(always)]
pub(super) fn contains(pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    let mut inside = [0.0; LANES];
    for i in 0..LANES {
        let (x, y) = (x[i] - 0.5, y[i] - 0.5);
        let is_inside = (x >= 0.0) & (y >= 0.0) & (x < pixels.last[0]) & (y < pixels.last[1]);
        inside[i] = if is_inside { 1.0 } else { 0.0 };
    }
    inside
}

/// The grey values at points, bilinear between the four pixel centres around each (paper III-D). Those outside of the frame have
/// the value of a place at its rim.
#[inline(always)]
pub(super) fn values(pixels: &Pixels, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
    let (mut columns, mut rows) = ([0i32; LANES], [0i32; LANES]);
    let (mut right, mut down) = ([0.0f32; LANES], [0.0f32; LANES]);
    for i in 0..LANES {
        let x = (x[i] - 0.5).max(0.0).min(pixels.last[0] - RIM);
        let y = (y[i] - 0.5).max(0.0).min(pixels.last[1] - RIM);
        (columns[i], rows[i]) = (x as i32, y as i32);
        right[i] = x - columns[i] as f32;
        down[i] = y - rows[i] as f32;
    }
    // A square's four bytes travel as one number, so that taking them apart and making floats of them is done in vectors.
    let mut squares = [0u32; LANES];
    for i in 0..LANES {
        squares[i] = u32::from_le_bytes(pixels.square(columns[i] as usize, rows[i] as usize));
    }
    let mut values = [0.0f32; LANES];
    for i in 0..LANES {
        let upper = between(squares[i], right[i]);
        let lower = between(squares[i] >> 16, right[i]);
        values[i] = upper + (lower - upper) * down[i];
    }
    values
}

/// The value `share` of the way from one pixel, the lowest byte of `pair`, to the next, the second byte.
#[inline(always)]
fn between(pair: u32, share: f32) -> f32 {
    let (left, right) = ((pair & 0xff) as i32 as f32, (pair >> 8 & 0xff) as i32 as f32);
    left + (right - left) * share
}

/// Where values rise above 0 on the way outwards, looked for in steps from the middle to both sides.
pub(crate) struct Crossings {
    /// How far outwards that is; NaN until it is found.
    pub(crate) shifts: [f32; LANES],
    /// 1 while it is looked for, 0 from then on.
    pub(crate) is_open: [f32; LANES],
}

/// The values at the outer place that was looked at and at the inner one.
pub(crate) type Sides = [[f32; LANES]; 2];

impl Crossings {
    /// The `k`-th step of this length, from the values `before` to those `now`; says whether anything is still looked for.
    #[inline(always)]
    pub(super) fn look(&mut self, k: f32, step: f32, before: &Sides, now: &Sides) -> bool {
        let ([outer, inner], [next_outer, next_inner]) = (before, now);
        for i in 0..LANES {
            let (out, within) =
                (next_outer[i] / (next_outer[i] - outer[i]), next_inner[i] / (next_inner[i] - inner[i]));
            let rises_outside = (outer[i] <= 0.0) & (next_outer[i] > 0.0);
            let rises_inside = (next_inner[i] <= 0.0) & (inner[i] > 0.0);
            let outwards = if rises_outside { k - out } else { f32::MAX };
            let inwards = if rises_inside { k - within } else { f32::MAX };
            let nearest = if inwards < outwards { -inwards } else { outwards };
            let is_found = (self.is_open[i] > 0.0) & (rises_outside | rises_inside);
            self.shifts[i] = if is_found { nearest * step } else { self.shifts[i] };
            self.is_open[i] = if is_found { 0.0 } else { self.is_open[i] };
        }
        self.is_open != [0.0; LANES]
    }
}
