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
        let weight = self.weight.max(1e-9);
        let (x, y) = (self.x / weight, self.y / weight);
        let (xx, xy, yy) = (self.xx / weight - x * x, self.xy / weight - x * y, self.yy / weight - y * y);
        let half_gap = (((xx - yy) * 0.5).powi(2) + xy * xy).sqrt();
        let (small, large) = ((xx + yy) * 0.5 - half_gap, (xx + yy) * 0.5 + half_gap);
        // The normal is the eigenvector of the smaller eigenvalue; of its two forms the longer one is exact.
        let (a, b) = ([xx - large, xy], [xy, yy - large]);
        let longer = if a[0] * a[0] + a[1] * a[1] > b[0] * b[0] + b[1] * b[1] { a } else { b };
        let length = (longer[0] * longer[0] + longer[1] * longer[1]).max(1e-30).sqrt();
        let normal = [longer[0] / length, longer[1] / length];
        Line { normal, offset: normal[0] * x + normal[1] * y, error: small.max(0.0).sqrt() }
    }
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
