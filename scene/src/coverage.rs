//! How much of each pixel is covered by painted shapes: exact area, not samples.
//!
//! A shape is given by its directed edges. Every edge adds its weight times the area to its right, and the edges of a
//! closed shape add up to the area of the shape in each pixel:
//!
//! ```text
//!   left edge, going down: +      right edge, going up: -       sum
//!       |#############                      |#####
//!       |#############        -             |#####       =       |####|
//! ```
//!
//! While edges are added, a pixel holds only the *change* of coverage against its left neighbour, so that an edge
//! touches nothing but the pixels it runs through; one running sum over each row ends the work. (Font renderers know
//! this as the accumulation buffer.) Homographies keep lines straight, so the edges of a tag's cells are exact too.

use crate::canvas::Window;
use crate::homography::Point;

/// Two coverages at once, as edge weights and as results: painted in any colour, and painted black.
pub(crate) type Layers = [f32; 2];

/// The coverage of a window's pixels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage {
    window: Window,
    /// Rows of one more entry than the window is wide: an edge also changes the pixel after its own.
    changes: Vec<Layers>,
}

impl Coverage {
    /// Starts anew with nothing covered.
    pub(crate) fn clear_to(&mut self, window: Window) {
        self.window = window;
        self.changes.clear();
        self.changes.resize((window.width + 1) * window.height, [0.0; 2]);
    }

    /// Adds an edge that has `weight` to the right of it where it goes down, and the opposite where it goes up.
    pub(crate) fn add_edge(&mut self, from: Point, to: Point, weight: Layers) {
        if from[1] <= to[1] {
            self.add_descending(from, to, weight);
        } else {
            self.add_descending(to, from, weight.map(|value| -value));
        }
    }

    /// Adds a polygon whose inside has this weight, whichever way round its corners go.
    pub(crate) fn add_polygon(&mut self, corners: &[Point], weight: Layers) {
        let sense = sense_of(corners);
        for (&from, &to) in corners.iter().zip(following(corners)) {
            self.add_edge(from, to, weight.map(|value| value * sense));
        }
    }

    /// The coverages of a row of the picture, from the window's first column on.
    pub(crate) fn row(&self, y: usize) -> impl Iterator<Item = Layers> {
        let stride = self.window.width + 1;
        let start = (y - self.window.top) * stride;
        self.changes[start..start + self.window.width].iter().scan([0.0; 2], |sum, change| {
            add_to(sum, *change, 1.0);
            Some(*sum)
        })
    }

    /// Cuts the edge into its pieces row by row.
    fn add_descending(&mut self, from: Point, to: Point, weight: Layers) {
        let [left, top] = [self.window.left as f64, self.window.top as f64];
        let (x, y) = (from[0] - left, from[1] - top);
        let (end, height) = (to[1] - top, to[1] - from[1]);
        if height <= 0.0 {
            return;
        }
        let slope = (to[0] - from[0]) / height;
        let (first, last) = (y.max(0.0), end.min(self.window.height as f64));
        let mut upper = first;
        while upper < last {
            let row = upper.floor();
            let lower = last.min(row + 1.0);
            let piece = [x + (upper - y) * slope, x + (lower - y) * slope];
            self.add_in_row(row as usize, piece, lower - upper, weight);
            upper = lower;
        }
    }

    /// Cuts a piece within one row at the columns it crosses. `ends` are its x at both ends, in either order.
    fn add_in_row(&mut self, row: usize, ends: [f64; 2], height: f64, weight: Layers) {
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let height_per_column = if high > low { height / (high - low) } else { 0.0 };
        let width = self.window.width as f64;
        if high <= 0.0 {
            return self.add_in_pixel(row, 0, 0.0, height, weight);
        }
        if low < 0.0 {
            self.add_in_pixel(row, 0, 0.0, -low * height_per_column, weight);
        }
        let mut left = low.max(0.0);
        if low == high && low < width {
            return self.add_in_pixel(row, low as usize, low - low.floor(), height, weight);
        }
        while left < high.min(width) {
            let column = left.floor();
            let right = high.min(column + 1.0);
            let middle = (left + right) / 2.0 - column;
            self.add_in_pixel(row, column as usize, middle, (right - left) * height_per_column, weight);
            left = right;
        }
    }

    /// Adds a piece that stays in one pixel: `middle` is its mean x from the pixel's left side, 0..=1. Of this pixel
    /// the part right of the piece is covered, of all later ones the whole.
    fn add_in_pixel(&mut self, row: usize, column: usize, middle: f64, height: f64, weight: Layers) {
        let at = row * (self.window.width + 1) + column;
        let (here, after) = ((height * (1.0 - middle)) as f32, (height * middle) as f32);
        add_to(&mut self.changes[at], weight, here);
        add_to(&mut self.changes[at + 1], weight, after);
    }
}

fn add_to(sum: &mut Layers, weight: Layers, share: f32) {
    *sum = [sum[0] + weight[0] * share, sum[1] + weight[1] * share];
}

/// 1 for a polygon that goes round left edge down, right edge up (counter-clockwise as seen in the picture), else -1.
pub(crate) fn sense_of(polygon: &[Point]) -> f32 {
    let turning: f64 = polygon.iter().zip(following(polygon)).map(|(a, b)| a[1] * b[0] - a[0] * b[1]).sum();
    if turning > 0.0 { 1.0 } else { -1.0 }
}

/// The corner after each corner.
fn following(polygon: &[Point]) -> impl Iterator<Item = &Point> {
    polygon.iter().cycle().skip(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// Sums of a few hundred single-precision numbers below 1.
    const ROUNDING: f32 = 1e-5;

    fn covered(window: Window, corners: &[Point]) -> Vec<f32> {
        let mut coverage = Coverage::default();
        coverage.clear_to(window);
        coverage.add_polygon(corners, [1.0, 0.0]);
        window.rows().flat_map(|y| coverage.row(y).map(|layers| layers[0]).collect::<Vec<_>>()).collect()
    }

    #[test]
    fn an_upright_rectangle_covers_its_exact_share_of_each_pixel() {
        let rectangle = [[1.25, 0.5], [1.25, 1.75], [3.5, 1.75], [3.5, 0.5]];
        let found = covered(Window::whole(4, 2), &rectangle);
        assert_eq!(found, [0.0, 0.375, 0.5, 0.25, 0.0, 0.5625, 0.75, 0.375]);
    }

    #[test]
    fn the_window_may_lie_anywhere_in_the_picture() {
        let rectangle = [[1.25, 0.5], [1.25, 1.75], [3.5, 1.75], [3.5, 0.5]];
        let found = covered(Window { left: 2, top: 1, width: 2, height: 1 }, &rectangle);
        assert_eq!(found, [0.75, 0.375]);
    }

    #[test]
    fn the_coverage_of_a_triangle_adds_up_to_its_area() {
        let mut stream = Stream::new(31);
        for _ in 0..500 {
            let mut corner = || [stream.between(1.0, 19.0), stream.between(1.0, 19.0)];
            let [a, b, c] = [corner(), corner(), corner()];
            let area = ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs() / 2.0;
            let sum: f32 = covered(Window::whole(20, 20), &[a, b, c]).iter().sum();
            assert!((sum - area as f32).abs() < 200.0 * ROUNDING, "{sum} for {area}");
        }
    }

    #[test]
    fn what_sticks_out_of_the_window_changes_nothing_inside() {
        let mut stream = Stream::new(32);
        let (large, small) = (Window::whole(30, 30), Window { left: 8, top: 9, width: 11, height: 7 });
        for _ in 0..500 {
            let mut corner = || [stream.between(0.0, 30.0), stream.between(0.0, 30.0)];
            let corners = [corner(), corner(), corner(), corner()];
            let (outer, inner) = (covered(large, &corners), covered(small, &corners));
            for (index, value) in inner.iter().enumerate() {
                let (x, y) = (small.left + index % small.width, small.top + index / small.width);
                assert!((outer[y * large.width + x] - value).abs() < ROUNDING);
            }
        }
    }

    #[test]
    fn shapes_that_share_an_edge_leave_no_seam() {
        let (top, bottom) = ([4.3, 0.0], [7.9, 10.0]);
        let left = [[0.0, 0.0], [0.0, 10.0], bottom, top];
        let right = [top, bottom, [12.0, 10.0], [12.0, 0.0]];
        let window = Window::whole(12, 10);
        for (one, other) in covered(window, &left).iter().zip(covered(window, &right)) {
            assert!((one + other - 1.0).abs() < ROUNDING);
        }
    }
}
