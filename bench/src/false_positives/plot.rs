//! False positives beside those of random bits.

use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::contenders::DEFAULTS;
use super::interval::Estimate;
use super::report::thousands;
use super::run::{Findings, Outcome};
use crate::sweep::plot::SIZE;

type Failure = Box<dyn std::error::Error>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Fewer expected by chance than this are no ground for a ratio.
const LEAST_EXPECTED: f64 = 1.0;
/// No metric, rectangles, components, Ising: told apart by readers of every colour sense, and on white.
const COLOURS: [RGBColor; 4] =
    [RGBColor(120, 120, 120), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(0, 90, 178)];
/// Bars of one number of bits stand side by side, or they would hide each other.
const BESIDE: f64 = 0.05;

/// False positives of one contender as multiples of random bits, by corrected bits.
struct Curve {
    name: String,
    colour: RGBColor,
    points: Vec<(f64, Estimate)>,
}

/// One panel a layout, one curve for each of the library's defaults: false positives as multiples of what random bits give in
/// any of four turns.
pub(crate) fn figure(findings: &Findings, path: &Path) -> Result<(), Failure> {
    let outcomes = &findings.outcomes;
    let area = SVGBackend::new(path, (SIZE.0, SIZE.1 * outcomes.len() as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, outcome) in area.split_evenly((outcomes.len(), 1)).iter().zip(outcomes) {
        draw(panel, outcome)?;
    }
    Ok(area.present()?)
}

fn draw(area: &Area, outcome: &Outcome) -> Result<(), Failure> {
    let curves = curves(outcome);
    let highs = curves.iter().flat_map(|curve| curve.points.iter().map(|(_, ratio)| ratio.high));
    let highest = highs.fold(0.5, f64::max) * 1.05;
    let (quads, seeds) = (thousands(outcome.quad_count()), outcome.seeds());
    let title = format!("{}: {quads} quads without tags, {seeds} families a line", outcome.kind.name);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d(-0.25..outcome.most_bits as f64 + 0.25, 0.0..highest)?;
    let whole = |bits: &f64| if bits.fract() == 0.0 { format!("{bits:.0}") } else { String::new() };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_label_formatter(&whole)
        .x_desc("corrected bits, exactly")
        .y_desc("times random bits in any of four turns (95 % intervals)")
        .light_line_style(WHITE.mix(0.0))
        .draw()?;
    curves.iter().try_for_each(|curve| add(&mut chart, curve))?;
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

fn add(chart: &mut Chart, Curve { name, colour, points }: &Curve) -> Result<(), Failure> {
    let colour = *colour;
    let values = points.iter().map(|(bits, ratio)| (*bits, ratio.value));
    chart
        .draw_series(LineSeries::new(values, colour.stroke_width(2)).point_size(3))?
        .label(name)
        .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(3)));
    let bar = |(bits, ratio): &(f64, Estimate)| {
        PathElement::new(vec![(*bits, ratio.low), (*bits, ratio.high)], colour.stroke_width(1))
    };
    chart.draw_series(points.iter().map(bar))?;
    Ok(())
}

fn curves(outcome: &Outcome) -> Vec<Curve> {
    let bootstrap = &outcome.bootstrap();
    let middle = (COLOURS.len() - 1) as f64 / 2.0;
    let curve = |index: usize| {
        let line = &outcome.lines[index];
        let levels = outcome.levels().filter(|bits| outcome.random(*bits) >= LEAST_EXPECTED);
        let ratio = |bits| bootstrap.estimate(&line.counts, bits).over(outcome.random(bits));
        let place = |bits: usize| bits as f64 + (index as f64 - middle) * BESIDE;
        Curve {
            name: line.contender.name(),
            colour: COLOURS[index],
            points: levels.map(|bits| (place(bits), ratio(bits))).collect(),
        }
    };
    DEFAULTS.map(curve).collect()
}

#[cfg(test)]
mod tests {
    use super::super::verdict::tests::outcome;
    use super::*;

    #[test]
    fn curves_leave_out_what_chance_hardly_gives_and_do_not_hide_each_other() {
        let outcome = outcome([40, 30, 20, 10]);
        let curves = curves(&outcome);
        assert_eq!(curves.len(), 4);
        for curve in &curves {
            // 800 quads: random bits give 0.05, 1.1, 11 and 71.
            let bits: Vec<f64> = curve.points.iter().map(|(bits, _)| bits.round()).collect();
            assert_eq!(bits, [1.0, 2.0, 3.0]);
        }
        let [none, ising] = [0, 3].map(|curve: usize| curves[curve].points[1]);
        assert!(none.0 < ising.0 && (none.1.value / ising.1.value - 4.0).abs() < 1e-9);
    }

    #[test]
    fn a_figure_is_drawn_with_a_panel_for_each_layout() {
        let path = std::env::temp_dir().join(format!("tagbus-false-positives-{}.svg", std::process::id()));
        let outcomes = vec![outcome([40, 30, 20, 10]), outcome([4, 3, 2, 1])];
        figure(&Findings { pictures: 8, left_out: Vec::new(), outcomes }, &path).unwrap();
        let svg = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(svg.matches("800 quads without tags").count(), 2);
        assert_eq!(svg.matches("no metric").count(), 2);
    }
}
