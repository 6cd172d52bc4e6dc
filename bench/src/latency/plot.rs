//! How wake-ups are distributed, and how they grow with the number of receivers.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::figures::Times;
use super::run::{Line, Outcome};
use crate::Failure;
use crate::sweep::plot::{SIZE, Series, Words, draw};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Parts of the frames at which a curve of a distribution has a point.
const PARTS: [f64; 20] = [
    0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995,
    0.999,
];

/// A panel with distributions for each number of receivers, and one with medians against receivers.
pub(crate) fn figure(outcome: &Outcome, path: &Path) -> Result<(), Failure> {
    let mut counts: Vec<usize> = outcome.lines.iter().map(|line| line.receivers).collect();
    counts.sort_unstable();
    counts.dedup();
    let panels = counts.len() + 1;
    let area = SVGBackend::new(path, (SIZE.0, SIZE.1 * panels as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    let areas = area.split_evenly((panels, 1));
    for (panel, &receivers) in areas.iter().zip(&counts) {
        distribution(panel, outcome, receivers)?;
    }
    if let Some(panel) = areas.last() {
        against_receivers(panel, outcome)?;
    }
    Ok(area.present()?)
}

fn curve(name: &str, times: &Times) -> Series {
    let points = PARTS.iter().map(|&part| (times.quantile_us(part).max(0.1), part)).collect();
    Series { name: name.to_owned(), points }
}

fn distribution(panel: &Area, outcome: &Outcome, receivers: usize) -> Result<(), Failure> {
    let lines = outcome.lines.iter().filter(|line| line.receivers == receivers);
    let mut series: Vec<Series> = lines.map(|line| curve(line.way.name(), &awake(line))).collect();
    let pipelines = outcome.pipelines.iter().filter(|pipeline| pipeline.clients == receivers);
    series.extend(pipelines.map(|pipeline| curve("message to client", &pipeline.times(|hops| hops.client))));
    if receivers == 1 {
        series.extend(outcome.floors.iter().map(|floor| curve(floor.bell.name(), &floor.times()[1])));
    }
    let title = format!("Frame sent to receiver awake, {receivers} at once");
    let axes = ["us", "share of frames"];
    let words = Words { title: &title, axes, legend: SeriesLabelPosition::LowerRight };
    let (low, high) = span(&series, |point| point.0);
    draw(panel, &words, (low..high).log_scale(), &series)
}

fn awake(line: &Line) -> Times {
    line.times(|taken| taken.awake)
}

/// A little more than what there is.
fn span(series: &[Series], of: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
    let values = || series.iter().flat_map(|series| &series.points).map(&of);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    if low < high { (low * 0.8, high * 1.25) } else { (1.0, 10.0) }
}

fn against_receivers(panel: &Area, outcome: &Outcome) -> Result<(), Failure> {
    let mut series: Vec<Series> = Vec::new();
    let mut add = |name: &str, count: usize, time_us: f64| {
        let point = (count as f64, time_us.max(0.1));
        match series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => series.push(Series { name: name.to_owned(), points: vec![point] }),
        }
    };
    for line in &outcome.lines {
        add(line.way.name(), line.receivers, awake(line).median_us());
    }
    for pipeline in &outcome.pipelines {
        add("message to client", pipeline.clients, pipeline.times(|hops| hops.client).median_us());
    }
    let (left, right) = span(&series, |point| point.0);
    let (low, high) = span(&series, |point| point.1);
    let mut chart = ChartBuilder::on(panel)
        .caption("Median against the number of receivers", ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(60)
        .build_cartesian_2d((left..right).log_scale(), (low..high).log_scale())?;
    chart.configure_mesh().x_desc("receivers").y_desc("us").light_line_style(WHITE.mix(0.0)).draw()?;
    for (place, series) in series.iter().enumerate() {
        let colour = Palette99::pick(place).to_rgba();
        chart
            .draw_series(
                LineSeries::new(series.points.iter().copied(), colour.stroke_width(2)).point_size(3),
            )?
            .label(series.name.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}
