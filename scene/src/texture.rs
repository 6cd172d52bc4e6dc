//! Textures without pictures: value noise, and what a tag may lie on.

use crate::canvas::Canvas;
use crate::random::{key_for, number_at, unit_from};
use crate::room::{paint_full_room, paint_room};

/// What is behind the tags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// One grey level, 0..=255.
    Plain(f32),
    /// A linear gradient from the top-left corner of the picture to the bottom-right one.
    Gradient {
        /// Grey level in the top-left corner.
        top_left: f32,
        /// Grey level in the bottom-right corner.
        bottom_right: f32,
    },
    /// Cloudy structure at many sizes, from a third of the picture's height down to two pixels; it follows the
    /// picture's seed.
    Textured {
        /// Mean grey level.
        level: f32,
        /// Largest deviation from the mean.
        amplitude: f32,
    },
    /// A room of its own for every seed: wall, floor, pictures, boxes and cables, with structure on everything.
    Room,
    /// The same room, lived in: hundreds of things of every size, and a carpet with grain.
    FullRoom,
}

impl Background {
    /// Fills the canvas, which is the whole picture.
    pub(crate) fn fill(&self, canvas: &mut Canvas, seed: u64) {
        let (width, height) = (canvas.window.width, canvas.window.height);
        match *self {
            Background::Plain(level) => canvas.pixels.fill(level),
            Background::Gradient { top_left, bottom_right } => {
                let share_at = |index: usize, length: usize| (index as f32 + 0.5) / length as f32 / 2.0;
                for (y, row) in canvas.pixels.chunks_exact_mut(width).enumerate() {
                    for (x, pixel) in row.iter_mut().enumerate() {
                        let share = share_at(x, width) + share_at(y, height);
                        *pixel = top_left + share * (bottom_right - top_left);
                    }
                }
            }
            Background::Textured { level, amplitude } => {
                canvas.pixels.fill(level);
                Clouds::new(seed, height as f32 / 3.0).add_to(canvas, amplitude);
            }
            Background::Room => *canvas = paint_room(canvas.window, seed),
            Background::FullRoom => *canvas = paint_full_room(canvas.window, seed),
        }
    }
}

/// Value noise: octaves of random heights on square lattices, each half as coarse and weaker than the one before.
pub(crate) struct Clouds {
    /// Key, lattice spacing in pixels and weight of each octave; the weights add up to 1.
    octaves: Vec<(u64, f32, f32)>,
}

impl Clouds {
    /// The finest lattice, in pixels; finer structure would be noise.
    const FINEST_PX: f32 = 2.0;
    /// The weight of an octave against the next coarser one.
    const ROUGHNESS: f32 = 0.6;

    /// Noise whose largest structures are `coarsest_px` wide.
    pub(crate) fn new(seed: u64, coarsest_px: f32) -> Clouds {
        let spacings =
            std::iter::successors(Some(coarsest_px.max(Clouds::FINEST_PX)), |spacing| Some(spacing / 2.0));
        let weights = std::iter::successors(Some(1.0_f32), |weight| Some(weight * Clouds::ROUGHNESS));
        let mut octaves: Vec<(u64, f32, f32)> = spacings
            .take_while(|&spacing| spacing >= Clouds::FINEST_PX)
            .zip(weights)
            .zip(0..)
            .map(|((spacing, weight), octave)| (key_for(seed, octave), spacing, weight))
            .collect();
        let sum: f32 = octaves.iter().map(|octave| octave.2).sum();
        octaves.iter_mut().for_each(|octave| octave.2 /= sum);
        Clouds { octaves }
    }

    /// Adds `amplitude` times the noise, which lies between -1 and 1, to the canvas.
    pub(crate) fn add_to(&self, canvas: &mut Canvas, amplitude: f32) {
        let window = canvas.window;
        let mut heights = Vec::new();
        for y in window.rows() {
            let row = canvas.row_mut(y, window.columns());
            for &(key, spacing, weight) in &self.octaves {
                let reach = (window.width as f32 / spacing) as u64 + 2;
                heights.clear();
                heights.extend((0..reach).map(|column| height_at(key, column, y as f32 / spacing)));
                add_between(&heights, spacing, amplitude * weight, row);
            }
        }
    }
}

/// Adds the heights of one octave along a row, those between two lattice columns by a smooth blend.
fn add_between(heights: &[f32], spacing: f32, amplitude: f32, row: &mut [f32]) {
    for (x, pixel) in row.iter_mut().enumerate() {
        let column = x as f32 / spacing;
        let before = column as usize;
        *pixel += amplitude * blend(heights[before], heights[before + 1], column - before as f32);
    }
}

/// The height of a lattice column at a place (not negative) between lattice rows.
fn height_at(key: u64, column: u64, row: f32) -> f32 {
    let before = row as u64;
    blend(lattice_height(key, column, before), lattice_height(key, column, before + 1), row - before as f32)
}

/// The random height at a lattice point, between -1 and 1.
fn lattice_height(key: u64, column: u64, row: u64) -> f32 {
    (2.0 * unit_from(number_at(key, row << 32 | column)) - 1.0) as f32
}

/// From one height to the next on a curve that is level at both ends.
fn blend(from: f32, to: f32, share: f32) -> f32 {
    from + (to - from) * share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Window;

    fn filled(background: Background, seed: u64) -> Canvas {
        let mut canvas = Canvas::plain(Window::whole(120, 90), 0.0);
        background.fill(&mut canvas, seed);
        canvas
    }

    #[test]
    fn a_textured_background_stays_within_its_amplitude_and_uses_it() {
        let canvas = filled(Background::Textured { level: 100.0, amplitude: 40.0 }, 4);
        let low = canvas.pixels.iter().copied().fold(f32::INFINITY, f32::min);
        let high = canvas.pixels.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!(low >= 60.0 && high <= 140.0, "{low}..{high}");
        assert!(high - low > 30.0, "{low}..{high}");
    }

    #[test]
    fn neighbours_in_a_texture_are_alike_and_other_seeds_differ() {
        let background = Background::Textured { level: 100.0, amplitude: 40.0 };
        let (one, other) = (filled(background, 4), filled(background, 5));
        let change = one.pixels.windows(2).map(|pair| (pair[0] - pair[1]).abs()).sum::<f32>();
        let difference = one.pixels.iter().zip(&other.pixels).map(|(a, b)| (a - b).abs()).sum::<f32>();
        assert!(change < difference / 2.0, "{change} against {difference}");
    }

    #[test]
    fn a_gradient_rises_from_corner_to_corner() {
        let canvas = filled(Background::Gradient { top_left: 20.0, bottom_right: 220.0 }, 0);
        let (first, last) = (canvas.pixels[0], canvas.pixels[120 * 90 - 1]);
        assert!((first - 20.0).abs() < 2.0 && (last - 220.0).abs() < 2.0);
    }

    #[test]
    fn a_room_as_background_fills_the_picture_and_follows_the_seed() {
        for background in [Background::Room, Background::FullRoom] {
            let [one, other] = [1, 2].map(|seed| filled(background, seed));
            assert_eq!(one.window, Window::whole(120, 90));
            assert_ne!(one.pixels, other.pixels);
        }
    }
}
