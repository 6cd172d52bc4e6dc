//! A smaller picture (paper III-C 1, figure 4 step 2).

use crate::picture::Picture;

/// How a pixel of the smaller picture is made from n x n pixels of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The top-left one of them: the paper's choice, which keeps edges sharp.
    PointSampling,
    /// Their mean: AprilTag 2's choice.
    Box,
}

/// From points of the decimated picture to points of the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    factor: f64,
    filter: Filter,
}

impl Scale {
    pub(crate) fn new(factor: usize, filter: Filter) -> Scale {
        Scale { factor: factor as f64, filter }
    }

    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    /// A sampled pixel's value belongs to that pixel's centre, a mean to the middle of what it covers. Treating the
    /// former as the latter moves every corner by (n - 1) / 2 pixels.
    pub(crate) fn to_frame(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let place = |v: f64| match self.filter {
            Filter::PointSampling => (v - 0.5) * self.factor + 0.5,
            Filter::Box => v * self.factor,
        };
        [place(x), place(y)]
    }
}

/// The picture of every `factor`-th column and row, or of the means of whole boxes.
pub(crate) fn decimate(picture: &Picture, factor: usize, filter: Filter) -> Picture {
    match filter {
        Filter::PointSampling => {
            let [width, height] = [picture.width(), picture.height()].map(|side| side.div_ceil(factor));
            Picture::computed(width, height, |x, y| picture.at(x * factor, y * factor))
        }
        Filter::Box => {
            let [width, height] = [picture.width(), picture.height()].map(|side| (side / factor).max(1));
            Picture::computed(width, height, |x, y| mean_of_box(picture, factor, [x, y]))
        }
    }
}

/// The rounded mean of box `[x, y]`; a picture that is narrower than a box is covered by what there is of it.
fn mean_of_box(picture: &Picture, factor: usize, [x, y]: [usize; 2]) -> u8 {
    let columns = x * factor..((x + 1) * factor).min(picture.width());
    let rows = y * factor..((y + 1) * factor).min(picture.height());
    let pixels = columns.len() * rows.len();
    let sum: usize = rows.flat_map(|y| columns.clone().map(move |x| usize::from(picture.at(x, y)))).sum();
    ((sum + pixels / 2) / pixels) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sampled_picture_holds_every_nth_pixel_and_a_box_its_mean() {
        let ramp = Picture::computed(5, 4, |x, y| (10 * x + y) as u8);
        assert_eq!(
            decimate(&ramp, 2, Filter::PointSampling),
            Picture::new(3, 2, vec![0, 20, 40, 2, 22, 42]).unwrap()
        );
        // Means of 0, 10, 1, 11 and so on: 5.5, rounded up.
        assert_eq!(decimate(&ramp, 2, Filter::Box), Picture::new(2, 2, vec![6, 26, 8, 28]).unwrap());
    }

    #[test]
    fn factor_one_changes_nothing() {
        let picture = Picture::computed(7, 3, |x, y| (x * 31 + y * 57) as u8);
        for filter in [Filter::PointSampling, Filter::Box] {
            assert_eq!(decimate(&picture, 1, filter), picture);
            assert_eq!(Scale::new(1, filter).to_frame([3.25, 1.5]), [3.25, 1.5]);
        }
    }

    #[test]
    fn grey_levels_of_a_ramp_stay_where_they_were() {
        // A ramp's value at a pixel's centre tells where that centre is; both filters must agree with it.
        let ramp = Picture::computed(64, 1, |x, _| (3 * x) as u8);
        for filter in [Filter::PointSampling, Filter::Box] {
            for factor in [1, 2, 3, 4] {
                let small = decimate(&ramp, factor, filter);
                for x in 0..small.width() - 1 {
                    let [centre, _] = Scale::new(factor, filter).to_frame([x as f64 + 0.5, 0.5]);
                    let expected = 3.0 * (centre - 0.5);
                    let off = (f64::from(small.at(x, 0)) - expected).abs();
                    assert!(off <= 0.5, "{filter:?} by {factor}: {off} grey levels");
                }
            }
        }
    }

    #[test]
    fn a_picture_smaller_than_a_box_is_its_own_mean() {
        let small = Picture::new(2, 1, vec![10, 20]).unwrap();
        assert_eq!(decimate(&small, 4, Filter::Box), Picture::new(1, 1, vec![15]).unwrap());
    }
}
