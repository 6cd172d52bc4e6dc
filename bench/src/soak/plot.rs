//! Memory and files over time.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::report::{kinds, largest};
use super::run::{Look, Outcome};
use crate::Failure;

const SIZE: (u32, u32) = (1000, 900);

/// A curve's name and its value in each look.
type Curve<'a> = (String, Box<dyn Fn(&Look) -> f64 + 'a>);

/// Three panels: memory of the largest process of each kind, shared memory, open files and threads of all.
pub(crate) fn figure(outcome: &Outcome, path: &Path) -> Result<(), Failure> {
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let own: Vec<Curve> = kinds(outcome)
        .into_iter()
        .map(|kind| -> Curve {
            (kind.name().to_owned(), Box::new(move |look| largest(outcome, look, kind) as f64 / 1024.0))
        })
        .collect();
    let sum =
        |look: &Look, of: fn(&super::usage::Usage) -> u64| look.usages.iter().map(of).sum::<u64>() as f64;
    let shared: Vec<Curve> = vec![
        ("shared memory, written".to_owned(), Box::new(|look| look.stored.touched as f64 / 1048576.0)),
        (
            "all processes, proportional".to_owned(),
            Box::new(|look| sum(look, |usage| usage.proportional_kib) / 1024.0),
        ),
    ];
    let files: Vec<Curve> = vec![
        ("open files of all processes".to_owned(), Box::new(|look| sum(look, |usage| usage.files))),
        ("threads of all processes".to_owned(), Box::new(|look| sum(look, |usage| usage.threads))),
        ("files in shared memory".to_owned(), Box::new(|look| look.stored.files as f64)),
    ];
    let panels = [("own memory of the largest, MiB", own), ("MiB", shared), ("number", files)];
    for (area, (unit, curves)) in area.split_evenly((panels.len(), 1)).iter().zip(&panels) {
        panel(area, unit, &outcome.looks, curves)?;
    }
    Ok(area.present()?)
}

fn panel(
    area: &DrawingArea<SVGBackend, Shift>,
    unit: &str,
    looks: &[Look],
    curves: &[Curve],
) -> Result<(), Failure> {
    let end = looks.last().map_or(1.0, |look| look.seconds) / 60.0;
    let values = looks.iter().flat_map(|look| curves.iter().map(move |(_, value)| value(look)));
    let top = values.fold(0.0, f64::max) * 1.3 + 0.1;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..end, 0.0..top)?;
    chart.configure_mesh().x_desc("minutes").y_desc(unit).draw()?;
    for (place, (name, value)) in curves.iter().enumerate() {
        let color = Palette99::pick(place).to_rgba();
        let points = looks.iter().map(|look| (look.seconds / 60.0, value(look)));
        chart
            .draw_series(LineSeries::new(points, color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}
