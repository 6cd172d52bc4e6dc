//! Frames without tags that are full of edges.

use tagbus_camera::picture::Picture;
use tagbus_scene::Stream;

/// Grey levels of black and white, as in the data sets.
const INK: [u8; 2] = [35, 215];

/// What a frame shows, sizes in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    /// Every grey level as likely as any other, in every pixel.
    Noise,
    /// Squares of this width.
    Checker(usize),
    /// Stripes that are this high.
    Lying(usize),
    /// Stripes that are this wide.
    Standing(usize),
    /// Stripes from the top right to the bottom left, this wide along a row.
    Diagonal(usize),
    /// Bright squares of this width on dark, a third of it apart. On a checkerboard bright squares touch at their corners
    /// and count as one thing; here each is one of its own, which is what costs a family with a bright border.
    Squares(usize),
}

/// All that are measured.
pub(super) const PATTERNS: [Pattern; 20] = [
    Pattern::Noise,
    Pattern::Checker(1),
    Pattern::Checker(2),
    Pattern::Checker(4),
    Pattern::Checker(8),
    Pattern::Checker(16),
    Pattern::Lying(1),
    Pattern::Lying(2),
    Pattern::Lying(4),
    Pattern::Lying(8),
    Pattern::Standing(1),
    Pattern::Standing(2),
    Pattern::Standing(4),
    Pattern::Standing(8),
    // A pixel wide they are the finest checkerboard.
    Pattern::Diagonal(2),
    Pattern::Diagonal(4),
    Pattern::Diagonal(8),
    Pattern::Diagonal(16),
    Pattern::Squares(6),
    Pattern::Squares(9),
];

impl Pattern {
    pub(super) fn name(self) -> String {
        match self {
            Self::Noise => "uniform noise".to_owned(),
            Self::Checker(width) => format!("checkerboard {width} px"),
            Self::Lying(width) => format!("horizontal stripes {width} px"),
            Self::Standing(width) => format!("vertical stripes {width} px"),
            Self::Diagonal(width) => format!("diagonal stripes {width} px"),
            Self::Squares(width) => format!("bright squares {width} px"),
        }
    }

    pub(super) fn picture(self, [width, height]: [usize; 2]) -> Picture {
        let mut random = Stream::new(1);
        let mut luma = Vec::with_capacity(width * height);
        for y in 0..height {
            luma.extend((0..width).map(|x| match self.parity(x, y) {
                Some(parity) => INK[parity],
                None => random.below(256) as u8,
            }));
        }
        Picture { width, height, luma }
    }

    /// Black or white; `None` when chance decides.
    fn parity(self, x: usize, y: usize) -> Option<usize> {
        match self {
            Self::Noise => None,
            Self::Checker(width) => Some((x / width + y / width) % 2),
            Self::Lying(width) => Some(y / width % 2),
            Self::Standing(width) => Some(x / width % 2),
            Self::Diagonal(width) => Some((x + y) / width % 2),
            Self::Squares(width) => {
                let is_bright = |at: usize| at % (width + width / 3) >= width / 3;
                Some(usize::from(is_bright(x) && is_bright(y)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(pattern: Pattern) -> Vec<String> {
        let picture = pattern.picture([4, 4]);
        let text = |row: &[u8]| row.iter().map(|level| if *level < 128 { '#' } else { '.' }).collect();
        picture.luma.chunks_exact(4).map(text).collect()
    }

    #[test]
    fn patterns_look_like_their_names() {
        assert_eq!(drawn(Pattern::Checker(2)), ["##..", "##..", "..##", "..##"]);
        assert_eq!(drawn(Pattern::Lying(1)), ["####", "....", "####", "...."]);
        assert_eq!(drawn(Pattern::Standing(1)), ["#.#.", "#.#.", "#.#.", "#.#."]);
        assert_eq!(drawn(Pattern::Diagonal(2)), ["##..", "#..#", "..##", ".##."]);
        assert_eq!(drawn(Pattern::Squares(3)), ["####", "#...", "#...", "#..."]);
    }

    #[test]
    fn noise_has_all_grey_levels_alike() {
        let luma = Pattern::Noise.picture([256, 256]).luma;
        let mut counts = [0; 256];
        luma.iter().for_each(|level| counts[usize::from(*level)] += 1);
        // 256 each, standard deviation 16.
        assert!(counts.iter().all(|count| (160..360).contains(count)));
    }
}
