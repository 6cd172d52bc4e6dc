//! Found against distance, as the paper's range would look if it were drawn.

use std::path::Path;

use plotters::prelude::*;

use super::measure::{Failure, Line, Seen};
use super::report::LEVELS;
use crate::sweep::plot::{SIZE, Series, Words, draw};

/// One panel: the first detector's three tags and any of them; another one: any tag, all detectors.
pub(crate) fn figure(lines: &[Line], path: &Path) -> Result<(), Failure> {
    let Some(first) = lines.first() else { return Ok(()) };
    let area = SVGBackend::new(path, (SIZE.0, SIZE.1 * 2)).into_drawing_area();
    area.fill(&WHITE)?;
    let panels = area.split_evenly((2, 1));
    let axes = ["distance, m", "share of frames"];
    let near = first.distances.first().map_or(0.01, |seen| seen.distance_m * 0.95);
    let far = first.distances.last().map_or(1.0, |seen| seen.distance_m * 1.05);
    let contents = [
        (format!("The nested tag: {}, decimation {}", first.name, first.factor), levels_of(first)),
        ("Any of its tags".to_owned(), lines.iter().map(any_of).collect()),
    ];
    for (panel, (title, series)) in panels.iter().zip(&contents) {
        let words = Words { title, axes, legend: SeriesLabelPosition::LowerLeft };
        draw(panel, &words, (near..far).log_scale(), series)?;
    }
    Ok(area.present()?)
}

fn levels_of(line: &Line) -> Vec<Series> {
    let of_level = |(level, name): (usize, &&str)| curve(line, (*name).to_owned(), |seen| seen.levels[level]);
    let any = curve(line, "any of them".to_owned(), |seen| seen.found);
    LEVELS.iter().enumerate().map(of_level).chain([any]).collect()
}

fn any_of(line: &Line) -> Series {
    curve(line, format!("{}, decimation {}", line.name, line.factor), |seen| seen.found)
}

fn curve(line: &Line, name: String, count: impl Fn(&Seen) -> u32) -> Series {
    let share = |seen: &Seen| f64::from(count(seen)) / f64::from(seen.frames.max(1));
    Series { name, points: line.distances.iter().map(|seen| (seen.distance_m, share(seen))).collect() }
}
