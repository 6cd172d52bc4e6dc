//! The figures as a page and as CSV.

use std::fmt::Write as _;

use super::figures::{SHOWN, Times};
use super::noise::Calm;
use super::run::{Line, Outcome, PipeLine};
use super::way::Way;
use super::{verdict, zeromq};
use crate::median::median;

/// Quantiles in the CSV.
const QUANTILES: [f64; 12] = [0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.995, 0.999, 1.0];

/// All tables.
pub(crate) fn page(outcome: &Outcome) -> String {
    let mut text = noise(outcome);
    text += "\n## Frames to receivers\n\n";
    text += &ways(outcome);
    text += "\n## Camera, detector, clients\n\n";
    text += &pipelines(outcome);
    text += "\n## The floor\n\n";
    text += &floors(outcome);
    text += "\n## Goals\n\n";
    text + &verdict::table(outcome)
}

fn noise(outcome: &Outcome) -> String {
    let noise = &outcome.noise;
    let calm = noise.calm.iter().copied().fold(Calm::default(), Calm::and);
    let mut text = format!(
        "* load average: {} before, {} after; other processes used {:.1} % of the processors, the host took {:.1} %\n\
         * a loop that only reads the clock lost at most {:.2} % of its time, {:.0} us at once ({} looks at each processor)\n",
        noise.loads[0],
        noise.loads[1],
        noise.others * 100.0,
        noise.stolen * 100.0,
        calm.lost * 100.0,
        calm.longest_us,
        noise.calm.len()
    );
    let warnings = noise.warnings();
    for warning in &warnings {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "* **WARNING, do not believe these figures: {warning}**");
    }
    if warnings.is_empty() {
        text += "* the machine was quiet\n";
    }
    text
}

fn ways(outcome: &Outcome) -> String {
    let shown = SHOWN.map(name_of).join(" / ");
    let mut text = format!(
        "| way | receivers | sent to awake, us: {shown} | from before the frame is written: {shown} | until every byte is read: p50 | p50, times Unix socket | CPU us a frame: sender | each receiver | lost |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for line in &outcome.lines {
        let cpu = |of: fn(&super::run::Part) -> f64| median(line.rounds.iter().map(of));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.1} | {} | {:.1} | {:.1} | {} |",
            line.way.name(),
            line.receivers,
            line.times(|taken| taken.awake).cell(),
            line.times(|taken| taken.written).cell(),
            line.times(|taken| taken.read).median_us(),
            ratio(outcome, line).map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.3}")),
            cpu(|round| round.sender_us),
            cpu(|round| round.receiver_us),
            line.lost()
        );
    }
    let _ = write!(text, "\n{}\n", zeromq::version());
    text
}

/// `p50`, `p99.9`, `max`.
fn name_of(part: f64) -> String {
    if part == 1.0 { "max".to_owned() } else { format!("p{}", (part * 1000.0).round() / 10.0) }
}

/// The median over rounds of how many times the Unix socket's median of the same round a way takes.
pub(super) fn ratio(outcome: &Outcome, line: &Line) -> Option<f64> {
    let same = |other: &&Line| other.way == Way::Unix && other.receivers == line.receivers;
    let socket = outcome.lines.iter().find(same)?;
    let median_us =
        |part: &super::run::Part| Times::of(part.taken.iter().map(|taken| taken.awake)).median_us();
    let ratios =
        line.rounds.iter().zip(&socket.rounds).map(|(ours, socket)| median_us(ours) / median_us(socket));
    Some(median(ratios))
}

fn pipelines(outcome: &Outcome) -> String {
    let shown = SHOWN.map(name_of).join(" / ");
    let mut text = format!(
        "| clients | published to detector awake, us: {shown} | awake to its start: p50 | its end to sent: p50 | sent to client awake: {shown} | overhead (receive to start, and end to client): {shown} | CPU us a frame: camera | detector | each client |\n\
         |---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for pipeline in &outcome.pipelines {
        let cpu = |place: usize| median(pipeline.cpu_us.iter().map(|cpu_us| cpu_us[place]));
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} | {:.2} | {} | {} | {:.1} | {:.1} | {:.1} |",
            pipeline.clients,
            pipeline.times(|hops| hops.receive).cell(),
            pipeline.times(|hops| hops.start).median_us(),
            pipeline.times(|hops| hops.send).median_us(),
            pipeline.times(|hops| hops.client).cell(),
            pipeline.times(|hops| hops.overhead()).cell(),
            cpu(0),
            cpu(1),
            cpu(2) / pipeline.clients.max(1) as f64
        );
    }
    text
}

fn floors(outcome: &Outcome) -> String {
    let shown = SHOWN.map(name_of).join(" / ");
    let mut text = format!(
        "Half of there and back between two processes that do nothing else.\n\n\
         | wakes by | without rest, us: {shown} | at the rate of the frames: {shown} |\n|---|---:|---:|\n"
    );
    for floor in &outcome.floors {
        let [at_once, rested] = floor.times();
        let _ = writeln!(text, "| {} | {} | {} |", floor.bell.name(), at_once.cell(), rested.cell());
    }
    let _ = writeln!(
        text,
        "\nOne eventfd that wakes so many processes by one call, at the rate of the frames, until each of them is awake; they do nothing else.\n\n\
         | processes | us: {shown} |\n|---:|---:|"
    );
    for floor in &outcome.many_floors {
        let _ = writeln!(text, "| {} | {} |", floor.sleepers, floor.times().cell());
    }
    text
}

/// One line each way, number of receivers and hop.
pub(crate) fn csv(outcome: &Outcome) -> String {
    let mut text =
        format!("what,receivers,hop,count,{}\n", QUANTILES.map(|part| format!("q{part}_us")).join(","));
    let mut add = |what: &str, receivers: usize, hop: &str, times: &Times| {
        let quantiles = QUANTILES.map(|part| format!("{:.2}", times.quantile_us(part))).join(",");
        let _ = writeln!(text, "{what},{receivers},{hop},{},{quantiles}", times.count());
    };
    for line in &outcome.lines {
        let name = line.way.name().replace(',', "");
        add(&name, line.receivers, "sent to awake", &line.times(|taken| taken.awake));
        add(&name, line.receivers, "written to awake", &line.times(|taken| taken.written));
        add(&name, line.receivers, "written to read", &line.times(|taken| taken.read));
    }
    for pipeline in &outcome.pipelines {
        for (hop, times) in hops_of(pipeline) {
            add("pipeline", pipeline.clients, hop, &times);
        }
    }
    for floor in &outcome.floors {
        let [at_once, rested] = floor.times();
        add(floor.bell.name(), 1, "without rest", &at_once);
        add(floor.bell.name(), 1, "at the rate of the frames", &rested);
    }
    for floor in &outcome.many_floors {
        add("eventfd for all", floor.sleepers, "at the rate of the frames", &floor.times());
    }
    text
}

fn hops_of(pipeline: &PipeLine) -> [(&'static str, Times); 5] {
    [
        ("published to detector awake", pipeline.times(|hops| hops.receive)),
        ("awake to start", pipeline.times(|hops| hops.start)),
        ("end to sent", pipeline.times(|hops| hops.send)),
        ("sent to client awake", pipeline.times(|hops| hops.client)),
        ("overhead", pipeline.times(|hops| hops.overhead())),
    ]
}
