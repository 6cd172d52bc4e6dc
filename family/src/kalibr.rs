//! The tags of Kalibr's Aprilgrid: tag36h11 with a black border of two cells.

use crate::layout::Layout;
use crate::layout_error::LayoutError;

/// The family's name.
pub const NAME: &str = "kalibr36h11";

/// The cells of a tag on the grid, its tag size being ten of the twelve:
///
/// ```text
///  w w w w w w w w w w w w
///  w b b b b b b b b b b w
///  w b b b b b b b b b b w
///  w b b d d d d d d b b w    6 x 6 data cells
///  ...
/// ```
const LETTERS: &str = "wwwwwwwwwwww wbbbbbbbbbbw wbbbbbbbbbbw wbbddddddbbw wbbddddddbbw wbbddddddbbw \
                       wbbddddddbbw wbbddddddbbw wbbddddddbbw wbbbbbbbbbbw wbbbbbbbbbbw wwwwwwwwwwww";

/// The layout of tags with 6 x 6 data cells and a black border of two cells. The bits lie in the same order as in
/// [`Layout::classic`] of 10 cells, so that the codes of tag36h11 are its codes.
///
/// # Errors
/// [`LayoutError`], never.
pub fn layout() -> Result<Layout, LayoutError> {
    Layout::parse(LETTERS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Family;

    #[test]
    fn the_data_cells_are_those_of_tag36h11_one_cell_further_in() {
        let (thin, thick) = (Layout::classic(10).unwrap(), layout().unwrap());
        let shifted: Vec<[i32; 2]> = thin.bits().iter().map(|[x, y]| [x + 1, y + 1]).collect();
        assert_eq!(thick.bits(), shifted);
        assert_eq!((thick.total_width(), thick.width_at_border(), thick.margin()), (12, 10, 1));
    }

    #[test]
    fn the_codes_are_those_of_tag36h11() {
        let thick = Family::published("Kalibr36h11").unwrap();
        let thin = Family::published("tag36h11").unwrap();
        assert_eq!((thick.name(), thick.codes(), thick.distance()), (NAME, thin.codes(), 11));
    }
}
