//! Bit planes of dark and of bright pixels, made in strips that threads share.

use super::cuts::Cuts;
use super::noise::{self, Ranges};
use super::raster::Raster;
use super::strip::{Measure, Part, Scratch, Strip, Threshold};
use crate::simd::Level;
use crate::threads::Threads;

/// Dark and bright pixels of the search grid, one bit each. Rows have a bit more than they need, which is never set,
/// so that every run of pixels ends inside its row.
#[derive(Default)]
pub(crate) struct Planes {
    /// Words of 64 pixels a row.
    pub(crate) words: usize,
    /// Pixels that black cells may be made of. Stale unless asked for.
    pub(crate) dark: Vec<u64>,
    /// Pixels that white cells may be made of. Stale unless asked for.
    pub(crate) bright: Vec<u64>,
    /// For each row whether it is known to have neither dark nor bright pixels.
    pub(crate) blank: Vec<bool>,
    /// The threshold of every tile.
    pub(crate) cuts: Cuts,
    /// The contrast that the frame's noise asked for, grey levels.
    pub(crate) contrast_limit: u8,
    /// At least one for each strip.
    scratches: Vec<Scratch>,
}

/// Which bit planes are asked for: at least one.
#[derive(Clone, Copy)]
pub(crate) struct Colours {
    pub(crate) dark: bool,
    pub(crate) bright: bool,
}

/// How wide and high the tiles are whose extremes give a pixel its threshold, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Scale {
    Four(Contrast),
    /// Sees a white margin of two pixels beside something brighter.
    Two(Contrast),
}

impl Scale {
    /// How far extremes must be apart at this scale.
    pub(crate) fn contrast(self) -> Contrast {
        match self {
            Self::Four(contrast) | Self::Two(contrast) => contrast,
        }
    }
}

/// How far the extremes around a tile must be apart.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Contrast {
    /// As far as the frame's noise asks for, which tiles of four pixels say; those of two use what was found before.
    Measured,
    /// Grey levels.
    Least(u8),
}

/// Strips that a thread is dealt.
const STRIPS_A_THREAD: usize = 2;
/// A raster of fewer pixels is binarized before another thread is awake.
const LEAST_TO_DEAL: usize = 600_000;

/// Fills `planes` from `raster`.
pub(crate) fn binarize<R: Raster>(
    level: Level,
    threads: &mut Threads,
    raster: R,
    colours: Colours,
    scale: Scale,
    planes: &mut Planes,
) {
    match scale {
        Scale::Four(contrast) => {
            let measures = matches!(contrast, Contrast::Measured);
            fill(threads, &Request::<R, 4> { level, raster, colours, contrast, measures }, planes);
        }
        Scale::Two(contrast) => {
            fill(threads, &Request::<R, 2> { level, raster, colours, contrast, measures: false }, planes);
        }
    }
}

/// What is asked for, with tiles of `TILE` pixels.
struct Request<R, const TILE: usize> {
    level: Level,
    raster: R,
    colours: Colours,
    contrast: Contrast,
    /// Whether the frame's noise is measured.
    measures: bool,
}

/// The frame's noise from some rows of tiles, then one pass in which thresholds follow a row of tiles behind the extremes,
/// while its pixels are still in the nearest cache. A frame that comes from memory comes with the first pass, line by line.
fn fill<R: Raster, const TILE: usize>(
    threads: &mut Threads,
    request: &Request<R, TILE>,
    planes: &mut Planes,
) {
    let Request { level, raster, measures, .. } = *request;
    let tile_rows = raster.height().div_ceil(TILE);
    let length = strip_length(threads, raster.width() * raster.height(), tile_rows);
    planes.resize(request, length);
    let strip = |number: usize| Strip::<R, TILE>::new(level, raster, number * length, length);
    if measures {
        let scratches = &mut planes.scratches[..tile_rows.div_ceil(length)];
        threads.each(scratches.iter_mut().enumerate(), |(number, scratch)| {
            level.run(Measure { strip: strip(number), scratch });
        });
        planes.contrast_limit = noise::contrast_limit(&ranges_of(scratches), R::ARE_AVERAGES);
    } else if let Contrast::Least(least) = request.contrast {
        planes.contrast_limit = least;
    }
    let limit = planes.contrast_limit;
    threads.each(planes.parts(request, length), |(number, part)| {
        level.run(Threshold { strip: strip(number), are_measured: measures, limit, part });
    });
}

/// What strips have measured, together.
fn ranges_of(scratches: &[Scratch]) -> Ranges {
    let mut sum = Ranges::default();
    scratches.iter().for_each(|scratch| sum.add_all(&scratch.ranges));
    sum
}

/// Rows of tiles a strip: all have as many but for the last.
fn strip_length(threads: &Threads, pixels: usize, tile_rows: usize) -> usize {
    let is_worth_it = threads.count() > 1 && pixels >= LEAST_TO_DEAL;
    tile_rows.div_ceil(if is_worth_it { STRIPS_A_THREAD * threads.count() } else { 1 })
}

impl Planes {
    /// Makes room for strips of so many rows of tiles.
    fn resize<R: Raster, const TILE: usize>(&mut self, request: &Request<R, TILE>, length: usize) {
        let (width, height) = (request.raster.width(), request.raster.height());
        let (tiles, tile_rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        self.words = width / 64 + 1;
        self.cuts.resize(TILE, tiles, tile_rows);
        let strips = tile_rows.div_ceil(length);
        if self.scratches.len() < strips {
            self.scratches.resize_with(strips, Scratch::default);
        }
        self.scratches[..strips].iter_mut().for_each(|scratch| scratch.resize(TILE, width, length));
        self.blank.resize(height, false);
        let Colours { dark, bright } = request.colours;
        for (plane, is_wanted) in [(&mut self.dark, dark), (&mut self.bright, bright)] {
            if is_wanted {
                plane.resize(self.words * height, 0);
            }
        }
    }

    /// What each strip fills, numbered.
    fn parts<R: Raster, const TILE: usize>(
        &mut self,
        request: &Request<R, TILE>,
        length: usize,
    ) -> impl ExactSizeIterator<Item = (usize, Part<'_>)> + Send {
        let Self { words, dark, bright, blank, cuts, scratches, .. } = self;
        let of_strip = length * TILE * *words;
        let (mut dark, mut bright) = (dark.chunks_mut(of_strip), bright.chunks_mut(of_strip));
        let Colours { dark: wants_dark, bright: wants_bright } = request.colours;
        let strips = cuts.chunks_mut(length).zip(blank.chunks_mut(length * TILE));
        let parts = scratches.iter_mut().zip(strips).map(move |(scratch, (cuts, blank))| Part {
            dark: dark.next().filter(|_| wants_dark),
            bright: bright.next().filter(|_| wants_bright),
            blank,
            cuts,
            scratch,
        });
        parts.enumerate()
    }
}
