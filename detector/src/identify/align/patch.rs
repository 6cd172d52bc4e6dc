//! Where a tag lies in the frame.

use super::super::homography::Homography;

/// Coordinates relative to a patch keep all numbers near one.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub(super) middle: [f64; 2],
    /// Pixels per unit: distance of the farthest corner from the middle.
    pub(super) scale: f64,
}

impl Patch {
    pub(super) fn around(corners: &[[f64; 2]; 4]) -> Self {
        let middle = [0, 1].map(|a| corners.iter().map(|corner| corner[a]).sum::<f64>() * 0.25);
        let distance = |corner: &[f64; 2]| (corner[0] - middle[0]).hypot(corner[1] - middle[1]);
        let scale = corners.iter().map(distance).fold(1.0, f64::max);
        Self { middle, scale }
    }

    /// A place in the frame in units of the patch.
    #[inline(always)]
    pub(super) fn place_of(&self, point: [f64; 2]) -> [f32; 2] {
        let scale = 1.0 / self.scale;
        [((point[0] - self.middle[0]) * scale) as f32, ((point[1] - self.middle[1]) * scale) as f32]
    }

    /// A pixel in units of the patch.
    #[inline(always)]
    pub(super) fn unit_step(&self) -> f32 {
        (1.0 / self.scale) as f32
    }

    /// The corners of the tag that the map from patch units to cells describes.
    pub(super) fn corners_of(&self, to_patch: &Homography, width: f64) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [width, 0.0], [width, width], [0.0, width]].map(|cell| {
            let [x, y] = to_patch.project(cell);
            [self.middle[0] + x * self.scale, self.middle[1] + y * self.scale]
        })
    }
}
