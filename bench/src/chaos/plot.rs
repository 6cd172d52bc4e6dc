//! How many kills were recovered from after how long.

use std::path::Path;

use plotters::prelude::*;

use super::kills::{Kind, Outcome};
use super::machine::Role;
use super::report::sorted;
use crate::Failure;
use crate::sweep::plot::{SIZE, Series, Words, draw};

/// One panel for each kind of kill, with a curve for each role and a line for the goal.
pub(crate) fn figure(outcome: &Outcome, path: &Path) -> Result<(), Failure> {
    let kinds: Vec<Kind> = [Kind::Running, Kind::StartUp]
        .into_iter()
        .filter(|&kind| outcome.recoveries.iter().any(|one| one.kind == kind))
        .collect();
    let area = SVGBackend::new(path, (SIZE.0, SIZE.1 * kinds.len().max(1) as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, kind) in area.split_evenly((kinds.len().max(1), 1)).iter().zip(kinds) {
        let series = curves(outcome, kind);
        let points = series.iter().flat_map(|series| &series.points);
        let longest = points.map(|point| point.0).fold(0.0, f64::max);
        let title = format!("Killed while {}", kind.name());
        let axes = ["ms from the start of the new process to the first detection", "share of kills"];
        let words = Words { title: &title, axes, legend: SeriesLabelPosition::LowerRight };
        draw(panel, &words, 0.0..longest * 1.05, &series)?;
    }
    Ok(area.present()?)
}

fn curves(outcome: &Outcome, kind: Kind) -> Vec<Series> {
    let mut curves = Vec::new();
    for role in Role::ALL {
        let is_one = |one: &&_| is_of(one, kind, role);
        let times = sorted(outcome.recoveries.iter().filter(is_one), |one| one.first_ms);
        let share = |place: usize| (place + 1) as f64 / times.len() as f64;
        let points = times.iter().enumerate().map(|(place, &ms)| (ms, share(place))).collect();
        curves.push(Series { name: role.name().to_owned(), points });
    }
    let bar = kind.bar_ms();
    curves.push(Series { name: "goal for p99".to_owned(), points: vec![(bar, 0.0), (bar, 1.0)] });
    curves
}

fn is_of(one: &super::kills::Recovery, kind: Kind, role: Role) -> bool {
    one.kind == kind && one.role == role
}
