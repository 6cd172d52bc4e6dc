//! A sweep as a page and as comma-separated values.

use std::fmt::Write as _;

use super::measure::{Line, Measured};
use super::significance::mcnemar;
use crate::accuracy::CornerErrors;
use crate::sets::Bin;

/// Sums over some frames of a line.
#[derive(Default)]
pub(super) struct Sums {
    frames: usize,
    tags: u32,
    hits: u32,
    wrong: u32,
    errors: CornerErrors,
    medians_us: Vec<f64>,
    minima_us: f64,
}

impl Sums {
    pub(super) fn over<'a>(frames: impl Iterator<Item = &'a Measured>) -> Sums {
        let mut sums = Sums::default();
        for Measured { score, times, .. } in frames {
            sums.frames += 1;
            sums.tags += score.tags;
            sums.hits += score.hits;
            sums.wrong += score.wrong;
            sums.minima_us += times.min_us;
            sums.medians_us.push(times.median_us);
            if let Some(errors) = &score.found {
                sums.errors.merge(errors);
            }
        }
        sums.medians_us.sort_by(f64::total_cmp);
        sums
    }

    /// Share of the tags that were found.
    pub(super) fn recall(&self) -> f64 {
        f64::from(self.hits) / f64::from(self.tags.max(1))
    }

    /// The median over frames of the median over rounds, milliseconds.
    pub(super) fn median_ms(&self) -> f64 {
        self.medians_us.get(self.medians_us.len() / 2).copied().unwrap_or(0.0) * 1e-3
    }

    /// The mean over frames of the quickest round, milliseconds.
    fn mean_minimum_ms(&self) -> f64 {
        self.minima_us * 1e-3 / self.frames.max(1) as f64
    }

    /// RMS and radial bias of corners, or dashes where nothing was found.
    fn corners(&self) -> String {
        match self.hits {
            0 => "- | -".to_owned(),
            _ => format!("{:.3} | {:+.3}", self.errors.rms(), self.errors.outwards()),
        }
    }
}

impl Line {
    pub(super) fn all(&self) -> Sums {
        Sums::over(self.frames.iter())
    }

    pub(super) fn of_bin(&self, bin: Bin) -> Sums {
        Sums::over(self.frames.iter().filter(|measured| measured.bin == bin))
    }

    fn of_tilt(&self, tilt_deg: u32) -> Sums {
        Sums::over(self.frames.iter().filter(|measured| measured.bin.tilt_deg == tilt_deg))
    }

    /// Tilts that occur, in order.
    pub(super) fn tilts(&self) -> Vec<u32> {
        sorted(self.frames.iter().map(|measured| measured.bin.tilt_deg))
    }

    /// Distances that occur, in order.
    pub(super) fn distances(&self) -> Vec<u32> {
        sorted(self.frames.iter().map(|measured| measured.bin.distance_cm))
    }
}

fn sorted(values: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Tables for every family. The lines of a family start with ours at decimation 1, which others are compared with.
pub(crate) fn page(lines: &[Line]) -> String {
    let mut text = String::new();
    for family in lines.chunk_by(|a, b| a.family == b.family) {
        if let [ours, ..] = family {
            main_table(ours, family, &mut text);
            distance_table(ours, family, &mut text);
        }
    }
    text
}

// Writing to a String cannot fail.
fn main_table(ours: &Line, lines: &[Line], text: &mut String) {
    let tilts = ours.tilts();
    let _ = writeln!(text, "## {}, {} frames\n", ours.family, ours.frames.len());
    let tilt_heads: String = tilts.iter().map(|tilt| format!(" at {tilt}\u{b0} |")).collect();
    let _ = writeln!(
        text,
        "| detector | decimation | settings | recall |{tilt_heads} wrong | corner RMS px | outwards px | CPU median ms | \
         CPU mean of minima ms | times ours | only it : only ours | p |\n|{}",
        "---|".repeat(12 + tilts.len())
    );
    for line in lines {
        let sums = line.all();
        let of_tilts: String =
            tilts.iter().map(|tilt| format!(" {:.3} |", line.of_tilt(*tilt).recall())).collect();
        let Line { name, factor, variant, .. } = line;
        let _ = writeln!(
            text,
            "| {name} | {factor} | {variant} | {:.3} |{of_tilts} {} | {} | {:.3} | {:.3} | {} | {} |",
            sums.recall(),
            sums.wrong,
            sums.corners(),
            sums.median_ms(),
            sums.mean_minimum_ms(),
            times_ours(line, &sums, lines),
            against(ours, line),
        );
    }
}

/// How many times the CPU median of our first line of the same decimation; empty for our own lines.
fn times_ours(line: &Line, sums: &Sums, lines: &[Line]) -> String {
    let ours = lines.first().map_or("", |first| &first.name);
    let same = lines.iter().find(|other| other.name == ours && other.factor == line.factor);
    match same.filter(|_| line.name != ours) {
        Some(same) => format!("{:.1}", sums.median_ms() / same.all().median_ms()),
        None => String::new(),
    }
}

/// Frames that only the one of both solved, and McNemar's p.
fn against(ours: &Line, line: &Line) -> String {
    let pairs = ours.frames.iter().zip(&line.frames);
    let counts = pairs.fold([0_u32; 2], |[it, us], (our, its)| match (our.score.hits, its.score.hits) {
        (0, 1..) => [it + 1, us],
        (1.., 0) => [it, us + 1],
        _ => [it, us],
    });
    match counts {
        [0, 0] => "0 : 0 |".to_owned(),
        [it, us] => format!("{it} : {us} | {:.2}", mcnemar(it, us)),
    }
}

fn distance_table(ours: &Line, lines: &[Line], text: &mut String) {
    let (tilts, distances) = (ours.tilts(), ours.distances());
    let heads: String = distances.iter().map(|distance| format!(" {distance} |")).collect();
    let names: Vec<String> = tilts.iter().map(|tilt| format!("{tilt}\u{b0}")).collect();
    let _ = writeln!(
        text,
        "\nRecall by distance in cm, at {}:\n\n| detector | decimation | settings |{heads}\n|---|---|---|{}",
        names.join(" / "),
        "---|".repeat(distances.len())
    );
    for line in lines {
        let Line { name, factor, variant, .. } = line;
        let cell = |distance_cm: &u32| {
            let recall = |tilt_deg: &u32| {
                format!("{:.2}", line.of_bin(Bin { tilt_deg: *tilt_deg, distance_cm: *distance_cm }).recall())
            };
            format!(" {} |", tilts.iter().map(recall).collect::<Vec<_>>().join("/"))
        };
        let cells: String = distances.iter().map(cell).collect();
        let _ = writeln!(text, "| {name} | {factor} | {variant} |{cells}");
    }
    text.push('\n');
}

/// One row for every line and bin.
pub(crate) fn csv(lines: &[Line]) -> String {
    let mut text = String::from(
        "family,detector,decimation,settings,distance_cm,tilt_deg,frames,tags,found,wrong,rms_px,outwards_px,\
         cpu_median_us,cpu_mean_of_minima_us\n",
    );
    for line in lines {
        for tilt_deg in line.tilts() {
            for distance_cm in line.distances() {
                let bin = Bin { tilt_deg, distance_cm };
                let _ = writeln!(text, "{}", csv_row(line, bin));
            }
        }
    }
    text
}

fn csv_row(line: &Line, bin: Bin) -> String {
    let Line { family, name, factor, variant, .. } = line;
    let sums = line.of_bin(bin);
    format!(
        "{family},{name},{factor},{variant},{},{},{},{},{},{},{:.4},{:.4},{:.1},{:.1}",
        bin.distance_cm,
        bin.tilt_deg,
        sums.frames,
        sums.tags,
        sums.hits,
        sums.wrong,
        sums.errors.rms(),
        sums.errors.outwards(),
        sums.median_ms() * 1e3,
        sums.mean_minimum_ms() * 1e3,
    )
}
