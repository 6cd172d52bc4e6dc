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
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
}

/// Size of a figure in pixels.
const SIZE: (u32, u32) = (1100, 640);

/// Speed against recall, one curve for every detector and its settings, decimation changing along it.
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
    draw(&area, title, axes, (low..high).log_scale(), &series)?;
    Ok(area.present()?)
}

fn curves_of_recall_against_time(lines: &[Line]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for line in lines {
        let name = format!("{} {} {}", line.name, line.variant, line.family);
        let sums = line.all();
        let point = (sums.median_ms(), sums.recall());
        match series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => series.push(Series { name, points: vec![point] }),
        }
    }
    // The C library's other limits of contrast are points of the table; curves of one or two points only hide others.
    series.retain(|series| series.points.len() > 2);
    series
}

/// Recall against distance, one panel a tilt: of each detector the configuration that finds most.
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
        draw(panel, &title, ["distance, cm", "recall"], span, &series)?;
    }
    Ok(area.present()?)
}

fn best_of_each_detector(lines: &[Line]) -> Vec<&Line> {
    let mut best: Vec<&Line> = Vec::new();
    for line in lines {
        let same = |other: &&mut &Line| other.name == line.name && other.family == line.family;
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
        name: format!("{} /{} {} {}", line.name, line.factor, line.variant, line.family),
        points: line.distances().into_iter().map(point).collect(),
    }
}

fn draw<'a, X>(area: &Area<'a>, title: &str, axes: [&str; 2], span: X, series: &[Series]) -> Result<(), Failure>
where
    X: AsRangedCoord<Value = f64> + 'a,
    X::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d(span, 0.0..1.05)?;
    chart.configure_mesh().x_desc(axes[0]).y_desc(axes[1]).light_line_style(WHITE.mix(0.0)).draw()?;
    for (index, series) in series.iter().enumerate() {
        let colour = Palette99::pick(index).to_rgba();
        chart
            .draw_series(
                LineSeries::new(series.points.iter().copied(), colour.stroke_width(2)).point_size(3),
            )?
            .label(series.name.trim())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}
