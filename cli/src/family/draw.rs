//! Layouts and tags as text.

use tagbus_family::{Cell, Grid, Layout, Paint};

/// The layout's rows as letters `w`, `b`, `d`, `x`.
pub(super) fn letters(layout: &Layout) -> Vec<String> {
    rows(layout, |cell, _, _| {
        String::from(match cell {
            Cell::White => "w",
            Cell::Black => "b",
            Cell::Data => "d",
            Cell::Ignored => "x",
        })
    })
}

/// The layout's rows, two letters a cell so that cells look square.
pub(super) fn layout(layout: &Layout) -> Vec<String> {
    rows(layout, |cell, _, _| {
        String::from(match cell {
            Cell::White => "..",
            Cell::Black => "##",
            Cell::Data => "[]",
            Cell::Ignored => "  ",
        })
    })
}

/// The layout's rows with the number of each data bit, 0 being the most significant.
pub(super) fn numbered(layout: &Layout) -> Vec<String> {
    rows(layout, |cell, x, y| match cell {
        Cell::White => " ..".to_owned(),
        Cell::Black => " ##".to_owned(),
        Cell::Ignored => "   ".to_owned(),
        Cell::Data => {
            let number = layout.bits().iter().position(|bit| *bit == [x, y]).unwrap_or_default();
            format!("{number:>3}")
        }
    })
}

fn rows(layout: &Layout, text: impl Fn(Cell, i32, i32) -> String) -> Vec<String> {
    let first = -(layout.margin() as i32);
    let cells = first..first + layout.total_width() as i32;
    let row = |y| cells.clone().map(|x| text(layout.cell(x, y), x, y)).collect();
    cells.clone().map(row).collect()
}

/// The tag in half blocks, two rows of cells a line: white is lit, black is not, a dot is not part of the tag.
pub(super) fn tag(grid: &Grid) -> Vec<String> {
    let line = |y: usize| {
        let below = |x| if y + 1 < grid.width() { grid.get(x, y + 1) } else { Paint::Clear };
        (0..grid.width()).map(|x| half_blocks(grid.get(x, y), below(x))).collect()
    };
    (0..grid.width()).step_by(2).map(line).collect()
}

fn half_blocks(upper: Paint, lower: Paint) -> char {
    match (upper, lower) {
        (Paint::White, Paint::White) => '█',
        (Paint::White, _) => '▀',
        (_, Paint::White) => '▄',
        (Paint::Clear, Paint::Clear) => '·',
        _ => ' ',
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_family::Family;

    #[test]
    fn letters_are_the_layout_that_they_draw() {
        for name in Family::PUBLISHED {
            let family = Family::published(name).unwrap();
            assert_eq!(Layout::parse(&letters(family.layout()).concat()).as_ref(), Ok(family.layout()));
        }
    }

    #[test]
    fn every_bit_has_its_number_once() {
        for name in Family::PUBLISHED {
            let family = Family::published(name).unwrap();
            let rows = numbered(family.layout()).join("\n");
            let mut numbers: Vec<u32> =
                rows.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            numbers.sort_unstable();
            assert_eq!(numbers, (0..family.layout().bit_count()).collect::<Vec<_>>(), "{name}");
        }
    }

    #[test]
    fn a_drawn_tag_shows_two_rows_of_cells_a_line() {
        let grid = Family::published("tag16h5").unwrap().grid(0).unwrap();
        let lines = tag(&grid);
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0], "█▀▀▀▀▀▀█");
        let round = Family::published("tagCircle21h7").unwrap().grid(0).unwrap();
        assert_eq!(tag(&round)[4].chars().next(), Some('·'));
    }
}
