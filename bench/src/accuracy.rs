//! How far corners are from the truth.

use tagbus_scene::Point;

/// Errors of corners, added up over tags.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CornerErrors {
    corners: f64,
    squares: f64,
    outwards: f64,
    right: f64,
    down: f64,
    worst: f64,
}

impl CornerErrors {
    /// Adds the four corners of a tag, given in the same order as the truth.
    pub(crate) fn add(&mut self, found: &[Point; 4], truth: &[Point; 4]) {
        let middle = [0, 1].map(|axis| truth.iter().map(|corner| corner[axis]).sum::<f64>() * 0.25);
        for (found, truth) in found.iter().zip(truth) {
            let (dx, dy) = (found[0] - truth[0], found[1] - truth[1]);
            let (ox, oy) = (truth[0] - middle[0], truth[1] - middle[1]);
            self.corners += 1.0;
            self.squares += dx * dx + dy * dy;
            self.outwards += (dx * ox + dy * oy) / ox.hypot(oy);
            self.right += dx;
            self.down += dy;
            self.worst = self.worst.max(dx.hypot(dy));
        }
    }

    pub(crate) fn merge(&mut self, other: &CornerErrors) {
        self.corners += other.corners;
        self.squares += other.squares;
        self.outwards += other.outwards;
        self.right += other.right;
        self.down += other.down;
        self.worst = self.worst.max(other.worst);
    }

    /// Root of the mean square of the distances from the truth, pixels.
    pub(crate) fn rms(&self) -> f64 {
        self.mean(self.squares).sqrt()
    }

    /// Mean error away from the tag's middle (radial bias), pixels.
    pub(crate) fn outwards(&self) -> f64 {
        self.mean(self.outwards)
    }

    pub(crate) fn right(&self) -> f64 {
        self.mean(self.right)
    }

    pub(crate) fn down(&self) -> f64 {
        self.mean(self.down)
    }

    pub(crate) fn worst(&self) -> f64 {
        self.worst
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / self.corners.max(1.0)
    }
}

/// How far tags as a whole are shifted: for each tag the mean error of its corners, added up over tags.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Offsets {
    tags: f64,
    sums: [f64; 2],
    squares: [f64; 2],
}

impl Offsets {
    /// Adds a tag, its corners given in the same order as the truth.
    pub(crate) fn add(&mut self, found: &[Point; 4], truth: &[Point; 4]) {
        self.tags += 1.0;
        for axis in 0..2 {
            let off = (0..4).map(|k| found[k][axis] - truth[k][axis]).sum::<f64>() / 4.0;
            self.sums[axis] += off;
            self.squares[axis] += off * off;
        }
    }

    /// Mean to the right and its standard error, pixels.
    pub(crate) fn right(&self) -> (f64, f64) {
        self.along(0)
    }

    /// Mean downwards and its standard error, pixels.
    pub(crate) fn down(&self) -> (f64, f64) {
        self.along(1)
    }

    fn along(&self, axis: usize) -> (f64, f64) {
        let tags = self.tags.max(1.0);
        let mean = self.sums[axis] / tags;
        let variance = (self.squares[axis] / tags - mean * mean).max(0.0);
        (mean, (variance / (tags - 1.0).max(1.0)).sqrt())
    }
}

/// `found` in the order of the truth: of the eight ways to go round a quad the one that fits best. Detectors differ in
/// where they start and which way round they go.
pub(crate) fn in_order_of(truth: &[Point; 4], found: &[Point; 4]) -> [Point; 4] {
    let turned = |start: usize| [0, 1, 2, 3].map(|corner| found[(start + corner) % 4]);
    let mirrored = |start: usize| [0, 1, 2, 3].map(|corner| found[(start + 4 - corner) % 4]);
    let distance = |order: &[Point; 4]| {
        let square = |(a, b): (&Point, &Point)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        order.iter().zip(truth).map(square).sum::<f64>()
    };
    let all = (0..4).flat_map(|start| [turned(start), mirrored(start)]);
    all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(*found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [Point; 4] = [[10.0, 20.0], [20.0, 20.0], [20.0, 10.0], [10.0, 10.0]];

    #[test]
    fn any_order_of_going_round_is_brought_into_that_of_the_truth() {
        let near = TRUTH.map(|[x, y]| [x + 0.3, y - 0.2]);
        for start in 0..4 {
            let turned = [0, 1, 2, 3].map(|corner| near[(start + corner) % 4]);
            let mirrored = [3, 2, 1, 0].map(|corner| near[(start + corner) % 4]);
            assert_eq!(in_order_of(&TRUTH, &turned), near);
            assert_eq!(in_order_of(&TRUTH, &mirrored), near);
        }
    }

    #[test]
    fn a_quad_that_is_too_large_has_an_error_outwards_and_none_to_the_right() {
        let large = TRUTH.map(|[x, y]| [15.0 + (x - 15.0) * 1.2, 15.0 + (y - 15.0) * 1.2]);
        let mut errors = CornerErrors::default();
        errors.add(&large, &TRUTH);
        assert!((errors.outwards() - 2_f64.sqrt()).abs() < 1e-9);
        assert!((errors.rms() - 2_f64.sqrt()).abs() < 1e-9);
        assert!(errors.right().abs() < 1e-9 && errors.down().abs() < 1e-9);
    }

    #[test]
    fn a_shift_of_all_tags_is_their_mean_offset_and_scatter_its_error() {
        let mut offsets = Offsets::default();
        for scatter in [-0.1, 0.1, -0.1, 0.1, 0.0] {
            offsets.add(&TRUTH.map(|[x, y]| [x + 0.5 + scatter, y - 0.25]), &TRUTH);
        }
        let ((right, right_error), (down, down_error)) = (offsets.right(), offsets.down());
        assert!((right - 0.5).abs() < 1e-9 && (down + 0.25).abs() < 1e-9);
        // A variance of 0.04 / 4 over five tags.
        assert!((right_error - (0.01f64 / 5.0).sqrt()).abs() < 1e-9 && down_error < 1e-6);
    }
}
