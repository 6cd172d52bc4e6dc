//! Bit planes of dark and of bright pixels, made in strips that threads share.

use std::slice::ChunksMut;

use super::cuts::Cuts;
use super::noise;
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
    /// For each row whether it is known to have neither dark nor bright pixels, and no thresholds.
    pub(crate) blank: Vec<bool>,
    /// The threshold of every tile.
    pub(crate) cuts: Cuts,
    /// The contrast that the frame's noise asked for, grey levels.
    pub(crate) contrast_limit: u8,
    /// At least one for each strip.
    scratches: Vec<Scratch>,
    /// What is filled now: rows that are blank in the next frame too need not be cleared again if that has the same shape.
    shape: Option<Shape>,
}

/// What lies where in the planes.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Shape {
    tile: usize,
    width: usize,
    height: usize,
    colours: Colours,
}

/// Which bit planes are asked for: at least one.
#[derive(Clone, Copy, PartialEq, Eq)]
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
const STRIPS_A_THREAD: usize = 4;
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
    let strip = |number: usize| Strip::<R, TILE>::new(level, raster, number * length, length, measures);
    if measures {
        let scratches = &mut planes.scratches[..tile_rows.div_ceil(length)];
        threads.each(scratches.iter_mut().enumerate(), |(number, scratch)| {
            level.run(Measure { strip: strip(number), scratch });
        });
        let ranges = scratches.iter().map(|scratch| &scratch.ranges);
        planes.contrast_limit = noise::contrast_limit(ranges, R::ARE_AVERAGES);
    } else if let Contrast::Least(least) = request.contrast {
        planes.contrast_limit = least;
    }
    let limit = planes.contrast_limit;
    threads.each(planes.parts(request, length), |(number, part)| {
        level.run(Threshold { strip: strip(number), limit, part });
    });
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
        let fetched =
            Strip::<R, TILE>::new(request.level, request.raster, 0, length, request.measures).fetched();
        self.scratches[..strips].iter_mut().for_each(|scratch| scratch.resize(TILE, width, length, fetched));
        let shape = Shape { tile: TILE, width, height, colours: request.colours };
        if self.shape.replace(shape) != Some(shape) {
            self.blank.clear();
            self.blank.resize(height, false);
        }
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
    ) -> impl ExactSizeIterator<Item = (usize, Part<'_>)> + DoubleEndedIterator + Send {
        let Self { words, dark, bright, blank, cuts, scratches, .. } = self;
        let of_strip = length * TILE * *words;
        let Colours { dark: wants_dark, bright: wants_bright } = request.colours;
        let strips = cuts.chunks_mut(length).zip(blank.chunks_mut(length * TILE));
        let strips = scratches.iter_mut().zip(strips).enumerate();
        let dark = PlaneParts::new(dark, wants_dark, of_strip, strips.len());
        let bright = PlaneParts::new(bright, wants_bright, of_strip, strips.len());
        strips.zip(dark.zip(bright)).map(|((number, (scratch, (cuts, blank))), (dark, bright))| {
            (number, Part { dark, bright, blank, cuts, scratch })
        })
    }
}

/// A plane's part for each of some strips, or that many times none if it is not wanted.
struct PlaneParts<'p> {
    parts: ChunksMut<'p, u64>,
    strips: usize,
}

impl<'p> PlaneParts<'p> {
    fn new(plane: &'p mut [u64], is_wanted: bool, of_strip: usize, strips: usize) -> Self {
        let plane = if is_wanted { plane } else { &mut [] };
        Self { parts: plane.chunks_mut(of_strip), strips }
    }
}

impl<'p> Iterator for PlaneParts<'p> {
    type Item = Option<&'p mut [u64]>;

    fn next(&mut self) -> Option<Self::Item> {
        self.strips = self.strips.checked_sub(1)?;
        Some(self.parts.next())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.strips, Some(self.strips))
    }
}

impl DoubleEndedIterator for PlaneParts<'_> {
    fn next_back(&mut self) -> Option<Self::Item> {
        self.strips = self.strips.checked_sub(1)?;
        Some(self.parts.next_back())
    }
}

impl ExactSizeIterator for PlaneParts<'_> {}

#[cfg(test)]
mod tests {
    use super::super::raster::Sampled;
    use super::*;
    use crate::view::{Geometry, LumaView};

    /// A flat frame with some bright and some dark bars, at other places in each.
    fn frame(width: usize, height: usize, state: &mut u64) -> Vec<u8> {
        let mut below = |limit: usize| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*state >> 33) as usize % limit
        };
        let mut pixels = vec![100; width * height];
        for _ in 0..below(3) {
            let (left, top, value) = (below(width - 8), below(height - 8), [20, 220][below(2)]);
            for y in top..top + 1 + below(7) {
                pixels[y * width + left..][..8].fill(value);
            }
        }
        pixels
    }

    fn fill_from(raster: Sampled, colours: Colours, scale: Scale, planes: &mut Planes) {
        binarize(Level::best(), &mut Threads::start(1).unwrap(), raster, colours, scale, planes);
    }

    /// The frame itself, or every second pixel of every second row of a frame of which it is these.
    fn spread_out(pixels: &[u8], size: [usize; 2], factor: usize, larger: &mut Vec<u8>) -> Geometry {
        let [width, height] = size.map(|side| (side - 1) * factor + 1);
        larger.clear();
        larger.resize(width * height, 255);
        for (i, pixel) in pixels.iter().enumerate() {
            larger[i / size[0] * factor * width + i % size[0] * factor] = *pixel;
        }
        Geometry { offset: 0, width, height, row_stride: width, pixel_step: 1 }
    }

    #[test]
    fn planes_that_were_filled_with_other_frames_are_those_of_new_ones_and_of_decimated_frames() {
        let (mut used, mut state, mut blank, mut bytes) = (Planes::default(), 5, [0; 2], Vec::new());
        for round in 0..400 {
            let size = [[70, 40], [70, 40], [64, 40], [70, 45]][round / 7 % 4];
            let colours = [[true, false], [true, true], [false, true]][round / 11 % 3];
            let colours = Colours { dark: colours[0], bright: colours[1] };
            let scale = [Scale::Four(Contrast::Measured), Scale::Two(Contrast::Least(9))][round / 5 % 2];
            let (pixels, factor) = (frame(size[0], size[1], &mut state), 1 + round / 13 % 2);
            let mut new = Planes::default();
            let geometry = spread_out(&pixels, size, factor, &mut bytes);
            fill_from(
                Sampled::new(&LumaView::new(&bytes, geometry).unwrap(), factor),
                colours,
                scale,
                &mut used,
            );
            let view = LumaView::grey(&pixels, size[0], size[1]).unwrap();
            fill_from(Sampled::new(&view, 1), colours, scale, &mut new);
            assert!(!colours.dark || used.dark[..new.dark.len()] == new.dark, "round {round}");
            assert!(!colours.bright || used.bright[..new.bright.len()] == new.bright, "round {round}");
            assert_eq!((&used.blank, used.contrast_limit), (&new.blank, new.contrast_limit), "round {round}");
            for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                assert_eq!(used.cuts.at(x, y), new.cuts.at(x, y), "round {round}");
            }
            new.blank.iter().for_each(|is_blank| blank[usize::from(*is_blank)] += 1);
        }
        assert!(blank.iter().all(|count| *count > 1000), "{blank:?} rows that are not blank, and that are");
    }

    /// Rows of a wall on which light falls off by a grey level every so many pixels, with a dark square, that have dark pixels.
    fn rows_with_content(pixels_a_level: usize, factor: usize) -> usize {
        let (width, height, mut planes) = (800, 640, Planes::default());
        let noise = |x: usize, y: usize| (x.wrapping_mul(40_503) ^ y.wrapping_mul(30_011)) / 7 % 5;
        let pixel = |x: usize, y: usize| {
            let is_dark = (300..420).contains(&x) && (320..440).contains(&y);
            (if is_dark { 20 } else { 70 } + (x + y) / pixels_a_level + noise(x, y)) as u8
        };
        let bytes: Vec<u8> = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
        let raster = Sampled::new(&LumaView::grey(&bytes, width, height).unwrap(), factor);
        fill_from(
            raster,
            Colours { dark: true, bright: false },
            Scale::Four(Contrast::Measured),
            &mut planes,
        );
        planes.dark.chunks(planes.words).filter(|row| row.iter().any(|word| *word > 0)).count()
    }

    #[test]
    fn light_that_falls_off_is_no_content_of_a_decimated_picture_but_a_square_is() {
        for factor in [4, 8, 10] {
            let (even, uneven) = (rows_with_content(usize::MAX, factor), rows_with_content(10, factor));
            assert!(even >= 120 / factor && even < 120 / factor + 20, "factor {factor}: {even} rows");
            assert_eq!(uneven, even, "factor {factor}");
        }
    }
}
