//! Contours between a black and a white component (figure 4 step 5).

use std::collections::HashMap;

use crate::components::Components;
use crate::threshold::{Shade, Shades};

/// Components of fewer pixels are dropped early (III-C 2): a readable tag's border ring has more. AprilTag's value.
const MIN_COMPONENT: u32 = 25;

/// A place between a black and a white pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BoundaryPoint {
    /// The middle between both pixels' centres, in half pixels from the top-left corner of the decimated picture.
    pub(crate) at: [i32; 2],
    /// From the black pixel to the white one, in pixels.
    pub(crate) to_white: [i32; 2],
}

/// Each pair of neighbours is looked at once, from the one that comes first: right, and the three below.
const LATER_NEIGHBOURS: [[i32; 2]; 4] = [[1, 0], [-1, 1], [0, 1], [1, 1]];

/// The boundary points of each pair of components that touch, pairs in the order of their first point.
pub(crate) fn contours(shades: &Shades, components: &mut Components) -> Vec<Vec<BoundaryPoint>> {
    let mut places: HashMap<[u32; 2], usize> = HashMap::new();
    let mut contours: Vec<Vec<BoundaryPoint>> = Vec::new();
    // Most points belong to the same pair as the one before.
    let mut last = None;
    for y in 0..shades.height {
        for x in 0..shades.width {
            for step in LATER_NEIGHBOURS {
                let Some((pair, point)) = boundary(shades, components, [x, y], step) else { continue };
                let known = last.filter(|(last_pair, _)| *last_pair == pair).map(|(_, place)| place);
                let place = known.unwrap_or_else(|| {
                    *places.entry(pair).or_insert_with(|| {
                        contours.push(Vec::new());
                        contours.len() - 1
                    })
                });
                last = Some((pair, place));
                contours[place].push(point);
            }
        }
    }
    contours
}

/// The black and the white component that meet between a pixel and its neighbour, and where; `None` unless one of the
/// pixels is black and the other white, both in components of some size.
fn boundary(
    shades: &Shades,
    components: &mut Components,
    [x, y]: [usize; 2],
    [dx, dy]: [i32; 2],
) -> Option<([u32; 2], BoundaryPoint)> {
    let own = shades.at(x, y);
    let other = shades.get(x as i64 + i64::from(dx), y as i64 + i64::from(dy))?;
    let at = [2 * x as i32 + 1 + dx, 2 * y as i32 + 1 + dy];
    // `get` has shown that the neighbour lies inside.
    let [other_x, other_y] = [x as i32 + dx, y as i32 + dy].map(|v| v as usize);
    let (black, white, to_white) = match (own, other) {
        (Shade::Black, Shade::White) => ([x, y], [other_x, other_y], [dx, dy]),
        (Shade::White, Shade::Black) => ([other_x, other_y], [x, y], [-dx, -dy]),
        _ => return None,
    };
    let pair = [black, white].map(|[x, y]| components.at(x, y));
    let is_large = pair.iter().all(|name| components.size(*name) >= MIN_COMPONENT);
    is_large.then_some((pair, BoundaryPoint { at, to_white }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{Unions, components};

    fn contours_of(rows: &[&str]) -> Vec<Vec<BoundaryPoint>> {
        let shades = Shades::from_rows(rows);
        contours(&shades, &mut components(&shades, Unions::WithoutRedundant))
    }

    /// A black square of five by five pixels with a white hole of one pixel, on white.
    const SQUARE: [&str; 8] =
        ["........", "........", "..#####.", "..#####.", "..##.##.", "..#####.", "..#####.", "........"];

    #[test]
    fn a_square_has_one_contour_around_it_and_small_components_have_none() {
        // With the hole the square has 24 pixels, one too few.
        assert!(contours_of(&SQUARE).is_empty());
        let full = SQUARE.map(|row| row.replace("##.##", "#####"));
        let contours = contours_of(&full.each_ref().map(String::as_str));
        assert_eq!(contours.len(), 1);
        // Each side: 5 straight across, 2 diagonals each to the pixels beside; each corner one diagonal.
        assert_eq!(contours[0].len(), 4 * (5 + 2 * 4) + 4);
    }

    #[test]
    fn points_lie_between_the_pixels_and_point_to_white() {
        let full = SQUARE.map(|row| row.replace("##.##", "#####"));
        for point in &contours_of(&full.each_ref().map(String::as_str))[0] {
            // The square covers 4..14 half pixels across and 4..14 down, its middle is at 9.
            let outwards = (0..2).map(|axis| (point.at[axis] - 9) * point.to_white[axis]).sum::<i32>();
            assert!(outwards > 0, "{point:?}");
            let reach = point.at.map(|v| (v - 9).abs());
            assert_eq!(reach[0].max(reach[1]), 5, "{point:?}");
        }
    }

    #[test]
    fn unsure_pixels_have_no_contour() {
        let rows: Vec<String> = SQUARE.iter().map(|row| row.replace('.', "?")).collect();
        assert!(contours_of(&rows.iter().map(String::as_str).collect::<Vec<_>>()).is_empty());
    }
}
