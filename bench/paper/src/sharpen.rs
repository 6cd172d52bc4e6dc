//! Sharpening of the values that were read (paper III-D, equation 5).

/// The values convolved with I + strength * [0 -1 0; -1 4 -1; 0 -1 0], row after row of a square. What lies outside of the
/// square, or holds no data, is expected to be 0 and counts as such.
pub(crate) fn sharpen(values: &[f64], width: usize, strength: f64) -> Vec<f64> {
    let at = |x: usize, y: usize| if x < width && y < width { values[y * width + x] } else { 0.0 };
    let sharpened = |place: usize| {
        let (x, y) = (place % width, place / width);
        // Below 0 the difference wraps around and is outside as well.
        let around = at(x.wrapping_sub(1), y) + at(x + 1, y) + at(x, y.wrapping_sub(1)) + at(x, y + 1);
        at(x, y) + strength * (4.0 * at(x, y) - around)
    };
    (0..values.len()).map(sharpened).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_value_spreads_as_the_kernel() {
        let mut values = vec![0.0; 9];
        values[4] = 1.0;
        assert_eq!(sharpen(&values, 3, 0.25), [0.0, -0.25, 0.0, -0.25, 2.0, -0.25, 0.0, -0.25, 0.0]);
    }

    #[test]
    fn strength_zero_changes_nothing() {
        let values: Vec<f64> = (0..25).map(|at| f64::from(at * 7 % 11)).collect();
        assert_eq!(sharpen(&values, 5, 0.0), values);
    }

    #[test]
    fn a_grey_cell_among_darker_ones_becomes_white() {
        // Blur has drawn a white cell below the threshold.
        let values = [-9.0, -9.0, -9.0, -9.0, -2.0, -9.0, -9.0, -9.0, -9.0];
        assert!(sharpen(&values, 3, 0.25)[4] > 0.0);
    }
}
