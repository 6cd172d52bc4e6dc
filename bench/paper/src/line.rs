//! Lines through points, and how far the points are from them (paper III-C 3).
//!
//! The line that leaves the least sum of squared distances runs through the points' mean along the longer axis of their
//! covariance; the mean of the squared distances is the covariance's smaller eigenvalue.

use std::ops::{Add, Sub};

use crate::outline::QUARTERS;

/// How the mean squared distance from the best line is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError {
    /// As the smaller eigenvalue of the covariance: one square root.
    Eigenvalue,
    /// As before: the normal from its angle, then the variance along it.
    Normal,
}

/// Sums over points in quarter pixels. Whole numbers, so that differences of running sums are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Moments {
    count: i64,
    x: i64,
    y: i64,
    xx: i64,
    xy: i64,
    yy: i64,
}

impl Moments {
    fn of([x, y]: [i64; 2]) -> Moments {
        Moments { count: 1, x, y, xx: x * x, xy: x * y, yy: y * y }
    }

    pub(crate) fn count(&self) -> f64 {
        self.count as f64
    }

    fn mean_px(&self) -> [f64; 2] {
        [self.x, self.y].map(|sum| sum as f64 / self.count as f64 / QUARTERS)
    }

    fn covariance_px(&self) -> Covariance {
        let count = i128::from(self.count);
        let entry = |square: i64, a: i64, b: i64| {
            let scaled = count * i128::from(square) - i128::from(a) * i128::from(b);
            scaled as f64 / (self.count as f64 * QUARTERS).powi(2)
        };
        let (x, y) = (self.x, self.y);
        Covariance { xx: entry(self.xx, x, x), xy: entry(self.xy, x, y), yy: entry(self.yy, y, y) }
    }

    /// Mean squared distance of the points from the line that fits them best, square pixels.
    pub(crate) fn line_error(&self, how: LineError) -> f64 {
        let covariance = self.covariance_px();
        match how {
            LineError::Eigenvalue => covariance.smaller_eigenvalue(),
            LineError::Normal => covariance.variance_along_normal(),
        }
    }

    /// The line that fits the points best, pixels from the outline's middle.
    pub(crate) fn line(&self) -> Line {
        Line { point: self.mean_px(), direction: self.covariance_px().longer_axis() }
    }
}

impl Add for Moments {
    type Output = Moments;

    fn add(self, other: Moments) -> Moments {
        Moments {
            count: self.count + other.count,
            x: self.x + other.x,
            y: self.y + other.y,
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
        }
    }
}

impl Sub for Moments {
    type Output = Moments;

    fn sub(self, other: Moments) -> Moments {
        Moments {
            count: self.count - other.count,
            x: self.x - other.x,
            y: self.y - other.y,
            xx: self.xx - other.xx,
            xy: self.xy - other.xy,
            yy: self.yy - other.yy,
        }
    }
}

/// Running sums over a closed row of points, so that any stretch of it costs one subtraction.
pub(crate) struct RunningMoments {
    /// Place i holds the sums over the first i points.
    sums: Vec<Moments>,
}

impl RunningMoments {
    pub(crate) fn over(points: &[[i64; 2]]) -> RunningMoments {
        let mut sums = vec![Moments::default()];
        sums.extend(points.iter().scan(Moments::default(), |sum, point| {
            *sum = *sum + Moments::of(*point);
            Some(*sum)
        }));
        RunningMoments { sums }
    }

    /// Points in the row.
    pub(crate) fn count(&self) -> usize {
        self.sums.len() - 1
    }

    /// The sums from point `first` to point `last`, both included, over the end of the row where `last` lies before
    /// `first`.
    pub(crate) fn stretch(&self, first: usize, last: usize) -> Moments {
        let direct = self.sums[last + 1] - self.sums[first];
        if first <= last { direct } else { direct + self.sums[self.count()] }
    }
}

/// Of x and y, square pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Covariance {
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) yy: f64,
}

impl Covariance {
    /// Half the difference of both eigenvalues.
    fn half_spread(&self) -> f64 {
        (0.5 * (self.xx - self.yy)).hypot(self.xy)
    }

    fn smaller_eigenvalue(&self) -> f64 {
        0.5 * (self.xx + self.yy) - self.half_spread()
    }

    fn variance_along_normal(&self) -> f64 {
        let angle_rad = 0.5 * (-2.0 * self.xy).atan2(self.yy - self.xx);
        let (sine, cosine) = angle_rad.sin_cos();
        cosine * cosine * self.xx + 2.0 * cosine * sine * self.xy + sine * sine * self.yy
    }

    /// Unit vector to the larger eigenvalue; of the two rows that give it, the one that is longer is more exact. Along x
    /// where all directions are alike.
    pub(crate) fn longer_axis(&self) -> [f64; 2] {
        let (half_difference, spread) = (0.5 * (self.xx - self.yy), self.half_spread());
        let [x, y] = match half_difference >= 0.0 {
            true => [half_difference + spread, self.xy],
            false => [self.xy, spread - half_difference],
        };
        let length = x.hypot(y);
        if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] }
    }
}

/// A line in the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// A point on it.
    pub(crate) point: [f64; 2],
    /// Its direction, of length 1; which of both is by chance.
    pub(crate) direction: [f64; 2],
}

impl Line {
    /// Where two lines meet; `None` when they are parallel.
    pub(crate) fn meet(&self, other: &Line) -> Option<[f64; 2]> {
        let ([ax, ay], [bx, by]) = (self.direction, other.direction);
        let turn = ax * by - ay * bx;
        if turn.abs() < 1e-3 {
            return None;
        }
        let [dx, dy] = [other.point[0] - self.point[0], other.point[1] - self.point[1]];
        let along = (dx * by - dy * bx) / turn;
        Some([self.point[0] + along * ax, self.point[1] + along * ay])
    }

    /// Cosine of the angle between two lines, 0 to 1.
    pub(crate) fn cosine(&self, other: &Line) -> f64 {
        (self.direction[0] * other.direction[0] + self.direction[1] * other.direction[1]).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::Stream;

    /// Points near a random line.
    fn points(random: &mut Stream) -> Vec<[i64; 2]> {
        let (sine, cosine) = random.between(-4.0, 4.0).sin_cos();
        let (shift, spread) = (random.between(-3000.0, 3000.0), random.between(0.0, 30.0));
        let count = 3 + random.below(60);
        (0..count)
            .map(|_| {
                let (along, across) =
                    (random.between(-400.0, 400.0), shift + random.between(-spread, spread));
                [along * cosine - across * sine, along * sine + across * cosine].map(|v| v.round() as i64)
            })
            .collect()
    }

    /// From the definition: the mean of the squared distances, point by point.
    fn mean_square_from(line: &Line, points: &[[i64; 2]]) -> f64 {
        let distance = |point: &[i64; 2]| {
            let [x, y] = [0, 1].map(|axis| point[axis] as f64 / QUARTERS - line.point[axis]);
            x * line.direction[1] - y * line.direction[0]
        };
        points.iter().map(|point| distance(point).powi(2)).sum::<f64>() / points.len() as f64
    }

    #[test]
    fn the_line_error_is_the_mean_of_squared_distances_in_both_ways() {
        let mut random = Stream::new(3);
        for _ in 0..500 {
            let points = points(&mut random);
            let all = RunningMoments::over(&points).stretch(0, points.len() - 1);
            let expected = mean_square_from(&all.line(), &points);
            for how in [LineError::Eigenvalue, LineError::Normal] {
                assert!((all.line_error(how) - expected).abs() < 1e-8, "{how:?}: {expected}");
            }
        }
    }

    #[test]
    fn no_turned_or_shifted_line_fits_better() {
        let mut random = Stream::new(4);
        for _ in 0..300 {
            let points = points(&mut random);
            let all = RunningMoments::over(&points).stretch(0, points.len() - 1);
            let line = all.line();
            let best = mean_square_from(&line, &points);
            let (sine, cosine) = random.between(-0.1, 0.1).sin_cos();
            let [x, y] = line.direction;
            let other = Line {
                point: [0, 1].map(|axis| line.point[axis] + random.between(-0.5, 0.5)),
                direction: [x * cosine - y * sine, x * sine + y * cosine],
            };
            assert!(mean_square_from(&other, &points) >= best - 1e-9);
        }
    }

    #[test]
    fn a_stretch_over_the_end_is_the_rest_of_the_row() {
        let points = points(&mut Stream::new(5));
        let running = RunningMoments::over(&points);
        let last = points.len() - 1;
        assert_eq!(running.stretch(last, 0), Moments::of(points[last]) + Moments::of(points[0]));
        assert_eq!(running.stretch(1, 0), running.stretch(0, last));
        assert_eq!(running.stretch(1, 1), Moments::of(points[1]));
    }

    #[test]
    fn lines_meet_in_a_point_of_both_unless_they_are_parallel() {
        let line = |point, angle: f64| Line { point, direction: [angle.cos(), angle.sin()] };
        let meeting = line([1.0, 2.0], 0.3).meet(&line([4.0, -1.0], 1.9)).unwrap();
        for (point, angle) in [([1.0, 2.0], 0.3_f64), ([4.0, -1.0], 1.9)] {
            let across = (meeting[0] - point[0]) * angle.sin() - (meeting[1] - point[1]) * angle.cos();
            assert!(across.abs() < 1e-9);
        }
        assert!(line([0.0, 0.0], 0.3).meet(&line([1.0, 0.0], 0.3)).is_none());
    }
}
