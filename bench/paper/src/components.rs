//! Connected components of black and of white pixels (paper III-C 2, figure 4 step 4, figure 5).
//!
//! Black is 4-connected and white 8-connected, so that a closed black line separates what it encloses. Every pixel is
//! united with those of its neighbours that come before it, row by row:
//!
//! ```text
//!    white  a b c        black    b         b: above
//!           d X                 d X         d: left
//! ```

use crate::threshold::{Shade, Shades};
use crate::union_find::UnionFind;

/// Which unions are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unions {
    /// One for each pair of neighbours of the same colour.
    All,
    /// Only those that the values of the pixels between do not show to be redundant (figure 5).
    WithoutRedundant,
}

/// The component of every pixel. An unsure pixel is one of its own.
pub(crate) struct Components {
    sets: UnionFind,
    width: usize,
    unions: u64,
}

impl Components {
    /// The name of a pixel's component.
    pub(crate) fn at(&mut self, x: usize, y: usize) -> u32 {
        self.sets.find((y * self.width + x) as u32)
    }

    /// Pixels of the component of this name.
    pub(crate) fn size(&self, name: u32) -> u32 {
        self.sets.size(name)
    }

    /// How often two sets were united, or would have been if they had not been one already.
    pub(crate) fn unions(&self) -> u64 {
        self.unions
    }

    fn unite(&mut self, [x, y]: [usize; 2], [other_x, other_y]: [usize; 2]) {
        self.unions += 1;
        self.sets.unite((y * self.width + x) as u32, (other_y * self.width + other_x) as u32);
    }
}

/// Finds all components.
pub(crate) fn components(shades: &Shades, unions: Unions) -> Components {
    let sets = UnionFind::new(shades.width * shades.height);
    let mut components = Components { sets, width: shades.width, unions: 0 };
    for y in 0..shades.height {
        for x in 0..shades.width {
            if shades.at(x, y) != Shade::Unsure {
                unite_with_earlier(shades, [x, y], unions, &mut components);
            }
        }
    }
    components
}

/// Unites a pixel with its neighbours above and to the left, named as in the picture at the top.
fn unite_with_earlier(shades: &Shades, [x, y]: [usize; 2], unions: Unions, components: &mut Components) {
    let own = Some(shades.at(x, y));
    let near = |dx: i64, dy: i64| shades.get(x as i64 + dx, y as i64 + dy);
    let (a, b, c, d) = (near(-1, -1), near(0, -1), near(1, -1), near(-1, 0));
    let all = unions == Unions::All;
    if d == own {
        components.unite([x, y], [x - 1, y]);
    }
    // Figure 5, line 6: with d, a and b alike, X is united with b by way of them. (It calls its first column 1.)
    if b == own && (all || d != a || a != b) {
        components.unite([x, y], [x, y - 1]);
    }
    if own == Some(Shade::White) {
        // The same thought for 8-connected white: a is united by way of b or d, and c by way of b.
        if a == own && (all || (b != own && d != own)) {
            components.unite([x, y], [x - 1, y - 1]);
        }
        if c == own && (all || b != own) {
            components.unite([x, y], [x + 1, y - 1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_scene::Stream;

    /// For each pixel the first pixel of its component, so that equal partitions are equal lists.
    fn partition(shades: &Shades, components: &mut Components) -> Vec<usize> {
        let count = shades.width * shades.height;
        let names: Vec<u32> =
            (0..count).map(|at| components.at(at % shades.width, at / shades.width)).collect();
        names.iter().map(|name| names.iter().position(|other| other == name).unwrap_or(count)).collect()
    }

    /// By flooding from every pixel, which knows nothing of unions.
    fn flooded(shades: &Shades) -> Vec<usize> {
        let (width, count) = (shades.width, shades.width * shades.height);
        let mut first = vec![usize::MAX; count];
        for start in 0..count {
            let mut ahead = vec![start];
            while let Some(at) = ahead.pop().filter(|_| first[start] == usize::MAX || first[start] == start) {
                if first[at] != usize::MAX {
                    continue;
                }
                first[at] = start;
                let shade = shades.at(at % width, at / width);
                for (dx, dy) in reach(shade) {
                    let (x, y) = ((at % width) as i64 + dx, (at / width) as i64 + dy);
                    if shades.get(x, y) == Some(shade) {
                        ahead.push(y as usize * width + x as usize);
                    }
                }
            }
        }
        first
    }

    fn reach(shade: Shade) -> Vec<(i64, i64)> {
        let all = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        match shade {
            Shade::White => all.collect(),
            Shade::Black => all.filter(|(dx, dy)| dx * dy == 0).collect(),
            Shade::Unsure => Vec::new(),
        }
    }

    fn random_shades(seed: u64) -> Shades {
        let mut random = Stream::new(seed);
        let (width, height) = (1 + random.below(14) as usize, 1 + random.below(14) as usize);
        let white = random.below(100);
        let unsure = random.below(30);
        Shades::from_fn(width, height, || match random.below(100) {
            at if at < unsure => Shade::Unsure,
            _ if random.below(100) < white => Shade::White,
            _ => Shade::Black,
        })
    }

    #[test]
    fn components_are_those_of_flooding_with_and_without_redundant_unions() {
        for seed in 0..2000 {
            let shades = random_shades(seed);
            let expected = flooded(&shades);
            for unions in [Unions::All, Unions::WithoutRedundant] {
                let mut found = components(&shades, unions);
                assert_eq!(partition(&shades, &mut found), expected, "seed {seed}, {unions:?}: {shades:?}");
            }
        }
    }

    #[test]
    fn fewer_unions_are_made_without_the_redundant_ones() {
        let white = Shades::from_rows(&["....", "....", "...."]);
        // 9 to the left, 8 above, 6 and 6 across; without redundant ones the first column joins the rows.
        assert_eq!(components(&white, Unions::All).unions(), 29);
        assert_eq!(components(&white, Unions::WithoutRedundant).unions(), 11);
        let black = Shades::from_rows(&["####", "####", "####"]);
        assert_eq!(components(&black, Unions::All).unions(), 17);
        assert_eq!(components(&black, Unions::WithoutRedundant).unions(), 11);
    }

    #[test]
    fn white_is_connected_across_corners_and_black_is_not() {
        let mut found = components(&Shades::from_rows(&["#.", ".#"]), Unions::WithoutRedundant);
        assert_eq!(found.at(1, 0), found.at(0, 1));
        assert_ne!(found.at(0, 0), found.at(1, 1));
        let name = found.at(1, 0);
        assert_eq!(found.size(name), 2);
    }
}
