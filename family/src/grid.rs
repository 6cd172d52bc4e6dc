//! A tag as a square of painted cells, ready to be drawn by whoever has a screen, a printer or a picture.

/// What a cell of the print shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Paint {
    /// White paper.
    White,
    /// Black ink.
    Black,
    /// Not part of the tag: whatever lies behind shows through, another tag for instance.
    Clear,
}

/// The printed square, cell by cell; (0, 0) is its top-left cell, x goes right and y goes down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    width: usize,
    cells: Vec<Paint>,
}

impl Grid {
    /// `cells` holds `width * width` cells, row after row.
    pub(crate) fn new(width: usize, cells: Vec<Paint>) -> Grid {
        debug_assert_eq!(cells.len(), width * width);
        Grid { width, cells }
    }

    /// Cells along one edge of the print.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The cell in column `x` of row `y`.
    ///
    /// # Panics
    /// When `x` or `y` is not below [`Grid::width`].
    pub fn get(&self, x: usize, y: usize) -> Paint {
        assert!(
            x < self.width && y < self.width,
            "cell ({x}, {y}) lies outside a grid of {0} x {0}",
            self.width
        );
        self.cells[y * self.width + x]
    }

    /// The rows from top to bottom, each from left to right.
    pub fn rows(&self) -> impl Iterator<Item = &[Paint]> {
        self.cells.chunks_exact(self.width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_single_cells_show_the_same() {
        let cells = [Paint::White, Paint::Black, Paint::Clear, Paint::White];
        let grid = Grid::new(2, cells.to_vec());
        assert_eq!(grid.rows().flatten().copied().collect::<Vec<_>>(), cells);
        assert_eq!([grid.get(0, 0), grid.get(1, 0), grid.get(0, 1), grid.get(1, 1)], cells);
    }

    #[test]
    #[should_panic(expected = "cell (2, 0) lies outside a grid of 2 x 2")]
    fn a_cell_outside_is_refused_and_not_taken_from_the_next_row() {
        Grid::new(2, vec![Paint::White; 4]).get(2, 0);
    }
}
