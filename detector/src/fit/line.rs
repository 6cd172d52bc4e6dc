//! Lines through weighted points (paper III-C, by the smaller eigenvalue of the covariance).

use super::rules::PARALLEL_SINE;

/// Sums over weighted points, from which the best line follows. Points are taken relative to the component's centre and
/// summed in f64: with absolute coordinates the variance would drown in rounding.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    weight: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Moments {
    #[inline(always)]
    pub(super) fn add(&mut self, x: f64, y: f64, weight: f64) {
        let (wx, wy) = (weight * x, weight * y);
        self.weight += weight;
        self.x += wx;
        self.y += wy;
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
    }

    /// The sums of the points that `self` has more than `earlier`, and of `wrapped` besides.
    pub(super) fn since(&self, earlier: &Moments, wrapped: &Moments) -> Moments {
        Moments {
            weight: self.weight - earlier.weight + wrapped.weight,
            x: self.x - earlier.x + wrapped.x,
            y: self.y - earlier.y + wrapped.y,
            xx: self.xx - earlier.xx + wrapped.xx,
            xy: self.xy - earlier.xy + wrapped.xy,
            yy: self.yy - earlier.yy + wrapped.yy,
        }
    }

    /// The line with the least mean squared distance from the points.
    #[inline(always)]
    pub(super) fn line(&self) -> Line {
        let [a, b, offset, error] = best_line([self.weight, self.x, self.y, self.xx, self.xy, self.yy]);
        Line { normal: [a, b], offset, error }
    }
}

/// The line of each: four at once take little longer than one, as vectors divide four numbers at a time.
#[inline(always)]
pub(super) fn lines(moments: &[Moments; 4]) -> [Line; 4] {
    let mut sums = [[0.0; 4]; 6];
    for k in 0..4 {
        let Moments { weight, x, y, xx, xy, yy } = moments[k];
        for (sums, sum) in sums.iter_mut().zip([weight, x, y, xx, xy, yy]) {
            sums[k] = sum;
        }
    }
    let mut found = [[0.0; 4]; 4];
    for k in 0..4 {
        let of_one = best_line([sums[0][k], sums[1][k], sums[2][k], sums[3][k], sums[4][k], sums[5][k]]);
        for (found, value) in found.iter_mut().zip(of_one) {
            found[k] = value;
        }
    }
    let mut lines = [Line::default(); 4];
    for (k, line) in lines.iter_mut().enumerate() {
        *line = Line { normal: [found[0][k], found[1][k]], offset: found[2][k], error: found[3][k] };
    }
    lines
}

/// Normal, offset and error of the line with the least mean squared distance from points with these sums. Without branches, so
/// that four can be found at once.
#[inline(always)]
fn best_line([weight, x, y, xx, xy, yy]: [f64; 6]) -> [f64; 4] {
    let weight = weight.max(1e-9);
    let (x, y) = (x / weight, y / weight);
    let (xx, xy, yy) = (xx / weight - x * x, xy / weight - x * y, yy / weight - y * y);
    let (half, middle) = ((xx - yy) * 0.5, (xx + yy) * 0.5);
    let half_gap = (half * half + xy * xy).sqrt();
    let (small, large) = (middle - half_gap, middle + half_gap);
    // The normal is the eigenvector of the smaller eigenvalue; of its two forms the longer one is exact.
    let (a, b) = ([xx - large, xy], [xy, yy - large]);
    let is_longer = a[0] * a[0] + a[1] * a[1] > b[0] * b[0] + b[1] * b[1];
    let (u, v) = (if is_longer { a[0] } else { b[0] }, if is_longer { a[1] } else { b[1] });
    let length = (u * u + v * v).max(1e-30).sqrt();
    let (u, v) = (u / length, v / length);
    [u, v, u * x + v * y, small.max(0.0).sqrt()]
}

/// The points whose product with `normal` is `offset`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub(super) normal: [f64; 2],
    pub(super) offset: f64,
    /// Root mean square distance of the points that it was fitted to.
    pub(super) error: f64,
}

impl Line {
    /// Where two lines meet; `None` where they are nearly parallel.
    #[inline(always)]
    pub(super) fn meet(&self, other: &Line) -> Option<[f64; 2]> {
        let ([a, b], [c, d]) = (self.normal, other.normal);
        let sine = a * d - b * c;
        (sine.abs() >= PARALLEL_SINE).then(|| {
            [(self.offset * d - b * other.offset) / sine, (a * other.offset - self.offset * c) / sine]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line_through(points: &[[f64; 2]]) -> Line {
        let mut moments = Moments::default();
        for [x, y] in points {
            moments.add(*x, *y, 2.0);
        }
        moments.line()
    }

    #[test]
    fn lines_through_points_meet_where_they_cross() {
        for angle in 0..36 {
            let (sin, cos) = (f64::from(angle) * 0.0873).sin_cos();
            let along = |t: f64| [3.0 + t * cos, -2.0 + t * sin];
            let across = |t: f64| [3.0 - t * sin, -2.0 + t * cos];
            let a = line_through(&[along(-5.0), along(1.0), along(7.0)]);
            let b = line_through(&[across(2.0), across(4.0), across(9.0)]);
            let [x, y] = a.meet(&b).unwrap();
            assert!((x - 3.0).abs() < 1e-9 && (y + 2.0).abs() < 1e-9, "{x}, {y} at {angle}");
            assert!(a.error < 1e-6, "{}", a.error);
        }
    }

    #[test]
    fn parallel_lines_do_not_meet() {
        let a = line_through(&[[0.0, 0.0], [5.0, 0.1]]);
        let b = line_through(&[[0.0, 3.0], [5.0, 3.0]]);
        assert_eq!(a.meet(&b), None);
    }
}
