//! Pictures without truth: only time and the number of hits.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use image::imageops::FilterType;
use image::{DynamicImage, GrayImage};
use tagbus_camera::picture::{Picture, load_grey};
use tagbus_scene::Stream;

use super::measure::{ORDER_SEED, Plan, Times, bar, measure};
use crate::peers::{self, Peer};

type Failure = Box<dyn std::error::Error>;

/// The size of the paper's frames, to which every picture is brought as well.
const FRAME: [u32; 2] = [1296, 964];
/// The two sizes at which every picture is searched.
const SIZES: [&str; 2] = ["as it is", "1296x964"];

/// One configuration at one size, over all pictures.
#[derive(Clone, Default)]
struct Totals {
    hits: usize,
    times: Vec<Times>,
}

/// A table over the first pictures of the folder, as many as the plan says.
pub(crate) fn sweep(folder: &Path, family: &str, plan: &Plan) -> Result<String, Failure> {
    let mut paths = pictures_in(folder)?;
    paths.truncate(plan.frames);
    let mut peers = peers::sweep(family, &plan.detectors)?;
    peers.push(peers::none());
    let mut totals = vec![[Totals::default(), Totals::default()]; peers.len()];
    let bar = bar(paths.len(), "natural");
    let mut random = Stream::new(ORDER_SEED);
    for path in &paths {
        let picture = load_grey(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let scaled = scaled(&picture, FRAME).ok_or_else(|| format!("{} is damaged", path.display()))?;
        for (size, picture) in [picture, scaled].iter().enumerate() {
            for (totals, (hits, times)) in
                totals.iter_mut().zip(measure(&mut peers, picture, plan.rounds, &mut random)?)
            {
                totals[size].hits += hits.len();
                totals[size].times.push(times);
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let rows = peers.iter().zip(&totals);
    let mut text = format!("## {family}, {} pictures\n\n{HEAD}", paths.len());
    for (size, size_name) in SIZES.into_iter().enumerate() {
        let base = Base::of(&peers, &totals, size);
        for (peer, totals) in rows.clone() {
            let (name, factor, variant) = (peer.name(), peer.factor(), peer.variant());
            // Writing to a String cannot fail.
            let _ =
                writeln!(text, "| {size_name} | {name} | {factor} | {variant} {}", totals[size].row(&base));
        }
    }
    Ok(text)
}

/// What all lines of a size are held against, milliseconds.
struct Base {
    /// Sum of the quickest rounds of ours at decimation 1.
    first_ms: f64,
    /// Median of the quickest of ours.
    quickest_ms: f64,
}

impl Base {
    /// Ours come first.
    fn of(peers: &[Box<dyn Peer>], totals: &[[Totals; 2]], size: usize) -> Base {
        let ours = peers.first().map(|peer| peer.name());
        let of_ours = peers.iter().zip(totals).filter(|(peer, _)| Some(peer.name()) == ours);
        Base {
            first_ms: totals.first().map_or(0.0, |first| first[size].sum_ms()),
            quickest_ms: of_ours.map(|(_, totals)| totals[size].median_ms()).fold(f64::INFINITY, f64::min),
        }
    }
}

const HEAD: &str = "\
* CPU median: over pictures, of the median over rounds; CPU mean of minima: over pictures, of the quickest round
* times ours at decimation 1: by means of minima
* times our quickest: by medians. No picture holds a tag, so all of ours find as much as any other
* no detector: a call that does nothing and takes its turns as all others, which is what the bench itself takes for a call

| size | detector | decimation | settings | hits | CPU median ms | CPU mean of minima ms | times ours at decimation 1 | times our quickest |
|---|---|---|---|---|---|---|---|---|
";

impl Totals {
    /// Sum of the quickest rounds, milliseconds.
    fn sum_ms(&self) -> f64 {
        self.times.iter().map(|times| times.min_us).sum::<f64>() * 1e-3
    }

    /// The median over pictures, milliseconds.
    fn median_ms(&self) -> f64 {
        let mut medians: Vec<f64> = self.times.iter().map(|times| times.median_us).collect();
        medians.sort_by(f64::total_cmp);
        medians.get(medians.len() / 2).copied().unwrap_or(0.0) * 1e-3
    }

    fn row(&self, base: &Base) -> String {
        let median_ms = self.median_ms();
        let mean_ms = self.sum_ms() / self.times.len().max(1) as f64;
        let times_first = self.sum_ms() / base.first_ms;
        let times_quickest = median_ms / base.quickest_ms;
        format!("| {} | {median_ms:.4} | {mean_ms:.4} | {times_first:.2} | {times_quickest:.1} |", self.hits)
    }
}

/// All pictures of a folder, their middle parts brought to one size.
pub(crate) fn load_scaled(folder: &Path, size: [u32; 2]) -> Result<Vec<Picture>, Failure> {
    let load = |path: PathBuf| {
        let picture = load_grey(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(scaled(&picture, size).ok_or_else(|| format!("{} is damaged", path.display()))?)
    };
    pictures_in(folder)?.into_iter().map(load).collect()
}

/// Pictures by name, in a fixed order.
pub(crate) fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let is_picture = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_lowercase();
        ["jpg", "jpeg", "png", "pgm", "bmp"].contains(&ending.as_str())
    };
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let entries: Result<Vec<_>, _> = entries.collect();
    let mut paths: Vec<PathBuf> = entries?.into_iter().map(|entry| entry.path()).filter(is_picture).collect();
    paths.sort();
    if paths.is_empty() {
        return Err(format!("{} holds no picture (jpg, png, pgm, bmp)", folder.display()).into());
    }
    Ok(paths)
}

/// The middle part that has the proportions of `size`, brought to that size (Catmull-Rom, which keeps edges sharp
/// without ringing over several pixels). `None` when the grey levels do not fill the picture's own size.
fn scaled(picture: &Picture, size: [u32; 2]) -> Option<Picture> {
    let grey = GrayImage::from_raw(picture.width as u32, picture.height as u32, picture.luma.clone())?;
    let scaled = DynamicImage::from(grey).resize_to_fill(size[0], size[1], FilterType::CatmullRom);
    let [width, height] = size.map(|side| side as usize);
    Some(Picture { width, height, luma: scaled.into_luma8().into_raw() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_is_brought_to_the_papers_size() {
        for [width, height] in [[320, 480], [2000, 1000], [7, 5]] {
            let picture = Picture { width, height, luma: vec![90; width * height] };
            let scaled = scaled(&picture, FRAME).unwrap();
            assert_eq!((scaled.width, scaled.height), (1296, 964));
            assert!(scaled.luma.iter().all(|level| *level == 90));
        }
    }
}
