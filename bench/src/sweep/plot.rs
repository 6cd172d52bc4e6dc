//! Figures 7 and 8 of the paper.

use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use super::measure::Line;
use crate::sets::Bin;

type Failure = Box<dyn std::error::Error>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A named curve.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// Size of a figure in pixels.
pub(crate) const SIZE: (u32, u32) = (1100, 640);

/// Speed against recall of the lines of one family, one curve for every detector and its settings, decimation changing along it.
pub(crate) fn figure_7(lines: &[Line], title: &str, path: &Path) -> Result<(), Failure> {
    let series = curves_of_recall_against_time(lines);
    let times = || series.iter().flat_map(|series| series.points.iter().map(|point| point.0));
    let low = times().fold(f64::INFINITY, f64::min) * 0.8;
    let high = times().fold(f64::NEG_INFINITY, f64::max) * 1.25;
    if low.is_nan() || low >= high {
        return Ok(());
    }
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let axes = ["CPU time, ms a frame (median)", "recall"];
    let words = Words { title, axes, legend: SeriesLabelPosition::LowerRight };
    draw(&area, &words, (low..high).log_scale(), &series)?;
    Ok(area.present()?)
}

fn curves_of_recall_against_time(lines: &[Line]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for line in lines {
        // Variants that differ in a number are points of one curve.
        let kind = line.variant.split(" from ").next().unwrap_or_default();
        let name = format!("{} {kind}", line.name);
        let sums = line.all();
        let point = (sums.median_ms(), sums.recall());
        match series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => series.push(Series { name, points: vec![point] }),
        }
    }
    series
}

/// Recall against distance of the lines of one family, one panel a tilt: of each detector the configuration that finds most.
pub(crate) fn figure_8(lines: &[Line], title: &str, path: &Path) -> Result<(), Failure> {
    let Some(first) = lines.first() else { return Ok(()) };
    let (tilts, distances) = (first.tilts(), first.distances());
    let (Some(near), Some(far)) = (distances.first(), distances.last()) else { return Ok(()) };
    let best = best_of_each_detector(lines);
    let area = SVGBackend::new(path, (SIZE.0, SIZE.1 * tilts.len() as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, tilt_deg) in area.split_evenly((tilts.len(), 1)).iter().zip(&tilts) {
        let series: Vec<Series> = best.iter().map(|line| recall_against_distance(line, *tilt_deg)).collect();
        let title = format!("{title}, {tilt_deg}\u{b0}");
        let span = f64::from(*near) - 1.0..f64::from(*far) + 1.0;
        let axes = ["distance, cm", "recall"];
        draw(panel, &Words { title: &title, axes, legend: SeriesLabelPosition::LowerLeft }, span, &series)?;
    }
    Ok(area.present()?)
}

fn best_of_each_detector(lines: &[Line]) -> Vec<&Line> {
    let mut best: Vec<&Line> = Vec::new();
    for line in lines {
        let same = |other: &&mut &Line| other.name == line.name;
        match best.iter_mut().find(same) {
            Some(other) if other.all().recall() < line.all().recall() => *other = line,
            Some(_) => {}
            None => best.push(line),
        }
    }
    best
}

fn recall_against_distance(line: &Line, tilt_deg: u32) -> Series {
    let point =
        |distance_cm: u32| (f64::from(distance_cm), line.of_bin(Bin { tilt_deg, distance_cm }).recall());
    Series {
        name: format!("{}, decimation {}, {}", line.name, line.factor, line.variant),
        points: line.distances().into_iter().map(point).collect(),
    }
}

/// What is written around the curves, and where the kind of figure leaves room for the legend.
pub(crate) struct Words<'a> {
    pub(crate) title: &'a str,
    pub(crate) axes: [&'a str; 2],
    pub(crate) legend: SeriesLabelPosition,
}

/// Axes, curves and legend.
pub(crate) fn draw<'a, X>(area: &Area<'a>, words: &Words, span: X, series: &[Series]) -> Result<(), Failure>
where
    X: AsRangedCoord<Value = f64> + 'a,
    X::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(words.title, ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d(span, 0.0..1.05)?;
    chart
        .configure_mesh()
        .x_desc(words.axes[0])
        .y_desc(words.axes[1])
        .light_line_style(WHITE.mix(0.0))
        .draw()?;
    for (index, series) in series.iter().enumerate() {
        let colour = Palette99::pick(index).to_rgba();
        chart
            .draw_series(
                LineSeries::new(series.points.iter().copied(), colour.stroke_width(2)).point_size(3),
            )?
            .label(series.name.trim_end_matches([' ', ',']))
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .position(words.legend.clone())
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::measure::{Measured, Times};
    use super::super::score::Score;
    use super::*;

    fn lines() -> Vec<Line> {
        let frame = |distance_cm: u32, hits: u32, time_us: f64| Measured {
            bin: Bin { tilt_deg: 0, distance_cm },
            score: Score { tags: 1, hits, ..Score::default() },
            times: Times { min_us: time_us, median_us: time_us },
        };
        let line = |factor: f64, far: u32, time_us: f64| Line {
            family: "tag36h11".to_owned(),
            name: "ours".to_owned(),
            factor,
            variant: "edges".to_owned(),
            frames: vec![frame(20, 1, time_us), frame(40, far, time_us)],
        };
        vec![line(1.0, 1, 900.0), line(2.0, 0, 300.0)]
    }

    #[test]
    fn decimations_are_points_of_one_curve_and_the_best_one_stands_for_its_detector() {
        let lines = lines();
        let curves = curves_of_recall_against_time(&lines);
        assert_eq!(curves.len(), 1);
        assert_eq!(curves[0].points, [(0.9, 1.0), (0.3, 0.5)]);
        assert_eq!(best_of_each_detector(&lines)[0].factor, 1.0);
    }

    #[test]
    fn both_figures_are_svg_with_a_legend() {
        let folder = std::env::temp_dir().join(format!("tagbus-bench-plots-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for (name, draw) in [("7", figure_7 as fn(&[Line], &str, &Path) -> _), ("8", figure_8)] {
            let path = folder.join(name);
            draw(&lines(), "title", &path).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(
                text.starts_with("<svg") && text.contains("title") && text.contains("ours"),
                "figure {name}"
            );
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
