//! What black and white look like across a tag: a plane of grey for each, fitted to cells of known colour (after
//! AprilTag 2).

use nalgebra::{Matrix3, Vector3};
use tagbus_family::{Border, Layout};

use crate::homography::Homography;
use crate::picture::Picture;
use crate::sample::{Sampling, sample};

/// Grey levels as a plane over the tag: a x + b y + c.
#[derive(Clone, Copy, Debug)]
struct Plane(Vector3<f64>);

/// Sums of the least squares fit of a plane.
#[derive(Default)]
struct PlaneFit {
    system: Matrix3<f64>,
    right_side: Vector3<f64>,
}

impl PlaneFit {
    fn add(&mut self, [x, y]: [f64; 2], grey: f64) {
        let row = Vector3::new(x, y, 1.0);
        self.system += row * row.transpose();
        self.right_side += row * grey;
    }

    fn plane(&self) -> Option<Plane> {
        self.system.lu().solve(&self.right_side).map(Plane)
    }
}

impl Plane {
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.0.dot(&Vector3::new(x, y, 1.0))
    }
}

/// Both planes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GreyModel {
    black: Plane,
    white: Plane,
}

impl GreyModel {
    /// From the rings on both sides of the border edge; `None` when one of their cells lies outside the frame, or white is
    /// not brighter than black in the middle.
    pub(crate) fn read(
        picture: &Picture,
        map: &Homography,
        layout: &Layout,
        sampling: Sampling,
    ) -> Option<GreyModel> {
        let (mut inner, mut outer) = (PlaneFit::default(), PlaneFit::default());
        for (fit, cells) in [(&mut inner, ring(layout, 0)), (&mut outer, ring(layout, -1))] {
            for cell in cells {
                let point = centre_of(cell, layout);
                fit.add(point, sample(picture, map.project(point), sampling)?);
            }
        }
        let (inner, outer) = (inner.plane()?, outer.plane()?);
        let (black, white) = match layout.border() {
            Border::Normal => (inner, outer),
            Border::Reversed => (outer, inner),
        };
        (white.at([0.0, 0.0]) > black.at([0.0, 0.0])).then_some(GreyModel { black, white })
    }

    /// The grey level half-way between black and white.
    pub(crate) fn threshold(&self, point: [f64; 2]) -> f64 {
        0.5 * (self.black.at(point) + self.white.at(point))
    }
}

/// The middle of a cell, counted as in [`Layout::bits`], in the plane where the border edge is the square [-1, 1]^2.
pub(crate) fn centre_of(cell: [i32; 2], layout: &Layout) -> [f64; 2] {
    cell.map(|at| (f64::from(at) + 0.5) * 2.0 / layout.width_at_border() as f64 - 1.0)
}

/// The cells of the ring whose top-left one is `[first, first]`, without its corners when that lies outside: a
/// corner of the outer ring touches no side of the border edge.
fn ring(layout: &Layout, first: i32) -> Vec<[i32; 2]> {
    let end = layout.width_at_border() as i32;
    let last = end - 1 - first;
    (0..end).flat_map(|along| [[along, first], [along, last], [first, along], [last, along]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Cell;

    #[test]
    fn rings_have_the_colours_of_the_border() {
        for layout in [Layout::classic(10).unwrap(), Layout::standard(9).unwrap()] {
            let colours = match layout.border() {
                Border::Normal => [Cell::Black, Cell::White],
                Border::Reversed => [Cell::White, Cell::Black],
            };
            for (first, colour) in [0, -1].into_iter().zip(colours) {
                let cells = ring(&layout, first);
                assert!(cells.iter().all(|[x, y]| layout.cell(*x, *y) == colour));
                assert_eq!(cells.len(), 4 * layout.width_at_border());
            }
        }
    }

    #[test]
    fn the_threshold_follows_the_light_across_a_tag() {
        // 10 cells of 8 pixels; light falls off to the right.
        let layout = Layout::classic(10).unwrap();
        let drawn = layout.draw(0x5_a5a5_a5a5);
        let light = |x: usize| 1.0 - x as f64 / 200.0;
        let picture = Picture::computed(80, 80, |x, y| {
            let is_white = drawn.get(x / 8, y / 8) == tagbus_family::Paint::White;
            ((if is_white { 200.0 } else { 40.0 }) * light(x)) as u8
        });
        let map = Homography::of_corners(&[[8.0, 72.0], [72.0, 72.0], [72.0, 8.0], [8.0, 8.0]]).unwrap();
        let model = GreyModel::read(&picture, &map, &layout, Sampling::Bilinear).unwrap();
        for x in [-0.8, 0.0, 0.9] {
            let pixel = map.project([x, 0.3])[0];
            assert!((model.threshold([x, 0.3]) - 120.0 * light(pixel as usize)).abs() < 2.0);
        }
        let reversed = Layout::standard(9).unwrap();
        assert!(
            GreyModel::read(&picture, &map, &reversed, Sampling::Bilinear).is_none(),
            "white inside is not there"
        );
    }
}
