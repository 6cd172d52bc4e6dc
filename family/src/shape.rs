//! The named shapes: which letter stands in which cell. Sizes are not judged here, `Layout` does that.
//!
//! `ring` is the distance of a cell to the nearest edge of the print, counted in cells: 0 for the outermost ring.

/// White ring, black ring, data inside: the classic AprilTag and ArUco look.
pub(crate) fn classic(total_width: usize) -> String {
    draw(total_width, |x, y| match ring(total_width, x, y) {
        0 => 'w',
        1 => 'b',
        _ => 'd',
    })
}

/// A ring of data outside the black ring, a white ring inside it, data in the middle.
pub(crate) fn standard(total_width: usize) -> String {
    draw(total_width, |x, y| match ring(total_width, x, y) {
        1 => 'b',
        2 => 'w',
        _ => 'd',
    })
}

/// As `standard`, cut to a disc, with the black ring as far out as its corners still fit into the disc.
pub(crate) fn circle(total_width: usize) -> String {
    let middle = total_width as f64 / 2.0;
    // A quarter of a cell less than the half width, so that a round cut leaves some slack.
    let radius = middle - 0.25;
    let border_ring = (middle - radius * 0.5_f64.sqrt() - 0.5).ceil() as usize;
    draw(total_width, |x, y| {
        let ring = ring(total_width, x, y);
        let from_middle = (x as f64 + 0.5 - middle).hypot(y as f64 + 0.5 - middle);
        if ring == border_ring {
            'b'
        } else if ring == border_ring + 1 {
            'w'
        } else if from_middle <= radius {
            'd'
        } else {
            'x'
        }
    })
}

fn draw(total_width: usize, letter: impl Fn(usize, usize) -> char) -> String {
    let letter = &letter;
    (0..total_width).flat_map(|y| (0..total_width).map(move |x| letter(x, y))).collect()
}

fn ring(total_width: usize, x: usize, y: usize) -> usize {
    let last = total_width - 1;
    x.min(y).min(last - x).min(last - y)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_small_classic_tag_is_drawn_ring_by_ring() {
        assert_eq!(super::classic(6), "wwwwwwwbbbbwwbddbwwbddbwwbbbbwwwwwww");
    }

    #[test]
    fn a_circle_of_nine_cells_has_its_corners_cut_off() {
        let rows =
            "xxxdddxxx xbbbbbbbx xbwwwwwbx dbwdddwbd dbwdddwbd dbwdddwbd xbwwwwwbx xbbbbbbbx xxxdddxxx";
        assert_eq!(super::circle(9), rows.replace(' ', ""));
    }
}
