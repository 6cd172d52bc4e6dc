//! The goals, and whether they were met.

use std::fmt::Write as _;

use super::report::ratio;
use super::run::{ManyFloor, Outcome, PipeLine};
use super::way::Way;

/// At most so many times what the Unix socket takes, by number of receivers.
const RATIOS: [(usize, f64); 3] = [(1, 0.15), (4, 0.18), (16, 0.15)];
/// What the bus adds to a detector with one client, microseconds.
const OVERHEAD_US: f64 = 60.0;
/// What each further client adds to a client's wake-up, microseconds.
const CLIENT_US: f64 = 10.0;

/// A number, what it may be at most, and what it is; nothing where it was not measured.
pub(super) struct Goal {
    name: String,
    most: f64,
    seen: f64,
}

impl Goal {
    fn is_met(&self) -> bool {
        self.seen <= self.most
    }
}

/// All goals that were measured.
pub(super) fn goals(outcome: &Outcome) -> Vec<Goal> {
    let mut goals = Vec::new();
    for (receivers, most) in RATIOS {
        let is_it = |line: &&super::run::Line| line.way == Way::Bus && line.receivers == receivers;
        if let Some(seen) = outcome.lines.iter().find(is_it).and_then(|line| ratio(outcome, line)) {
            let name = format!("published to awake p50, times Unix socket, {receivers} receivers");
            goals.push(Goal { name, most, seen });
        }
    }
    let Some(one) = outcome.pipelines.iter().find(|pipeline| pipeline.clients == 1) else { return goals };
    let seen = one.times(|hops| hops.overhead()).median_us();
    goals.push(Goal { name: "overhead p50 with one client, us".to_owned(), most: OVERHEAD_US, seen });
    for more in outcome.pipelines.iter().filter(|pipeline| pipeline.clients > 1) {
        let seen = (wake_us(more) - wake_us(one)) / (more.clients - 1) as f64;
        let name = format!("a client's wake-up p50, each further client to {}, us", more.clients);
        goals.push(Goal { name, most: CLIENT_US, seen });
    }
    goals
}

fn wake_us(pipeline: &PipeLine) -> f64 {
    pipeline.times(|hops| hops.client).median_us()
}

/// A line each goal, and how far from the floor a wake-up is.
pub(super) fn table(outcome: &Outcome) -> String {
    let mut text = String::from("| goal | at most | seen | |\n|---|---:|---:|---|\n");
    for goal in goals(outcome) {
        let verdict = if goal.is_met() { "met" } else { "**missed**" };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| {} | {} | {:.3} | {verdict} |", goal.name, goal.most, goal.seen);
    }
    text + &distance(outcome)
}

fn distance(outcome: &Outcome) -> String {
    let is_it = |line: &&super::run::Line| line.way == Way::Bus && line.receivers == 1;
    let Some(line) = outcome.lines.iter().find(is_it) else { return String::new() };
    let ours = line.times(|taken| taken.awake).median_us();
    let floor = outcome.floors.iter().map(|floor| floor.times()[1].median_us()).fold(f64::INFINITY, f64::min);
    format!(
        "\nOne receiver is awake {ours:.1} us after sending (p50); at the same rate the quickest of the floors takes {floor:.1} us: \
         {:.1} us are left.\n{}",
        ours - floor,
        floor_of_many(outcome)
    )
}

/// What each further process adds where it does nothing but wake.
fn floor_of_many(outcome: &Outcome) -> String {
    let median_us = |floor: &ManyFloor| floor.times().median_us();
    let Some(one) = outcome.many_floors.iter().find(|floor| floor.sleepers == 1) else {
        return String::new();
    };
    let more = outcome.many_floors.iter().filter(|floor| floor.sleepers > 1);
    let adds = more.map(|floor| {
        let each_us = (median_us(floor) - median_us(one)) / (floor.sleepers - 1) as f64;
        format!("{each_us:.1} us to {}", floor.sleepers)
    });
    let adds: Vec<String> = adds.collect();
    format!("Where processes do nothing but wake, each further one adds {} (p50).\n", adds.join(", "))
}
