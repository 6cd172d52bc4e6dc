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

/// What the columns of the main table mean.
const COLUMNS: &str = "\
* recall: share of the tags that were found with their id, the middle within half a side of the truth
* wrong: hits with an id that is not there
* corners: those of the tags that the detector itself found, in whichever order of going round fits best; outwards is the
  mean error away from the tag's middle
* CPU median: over frames, of the median over rounds; CPU mean of minima: over frames, of the quickest round
* times ours: its CPU median against our first line of the same decimation, and against our quickest line that finds at
  least as many tags
* only it : only ours: frames that only the one of both solved, against the first line; p by McNemar's exact test

";

/// Tables for every family. The lines of a family start with ours at decimation 1, which others are compared with.
pub(crate) fn page(lines: &[Line]) -> String {
    let mut text = String::from(COLUMNS);
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
         CPU mean of minima ms | times ours | times ours at its recall | only it : only ours | p |\n|{}",
        "---|".repeat(13 + tilts.len())
    );
    for line in lines {
        let sums = line.all();
        let of_tilts: String =
            tilts.iter().map(|tilt| format!(" {:.3} |", line.of_tilt(*tilt).recall())).collect();
        let Line { name, factor, variant, .. } = line;
        let _ = writeln!(
            text,
            "| {name} | {factor} | {variant} | {:.3} |{of_tilts} {} | {} | {:.3} | {:.3} | {} | {} | {} |",
            sums.recall(),
            sums.wrong,
            sums.corners(),
            sums.median_ms(),
            sums.mean_minimum_ms(),
            times_ours(line, &sums, lines),
            times_ours_at_its_recall(line, &sums, lines),
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

/// How many times the CPU median of the quickest of our lines that finds at least as much; empty for our own lines, and
/// a dash where none of ours finds as much.
fn times_ours_at_its_recall(line: &Line, sums: &Sums, lines: &[Line]) -> String {
    let ours = lines.first().map_or("", |first| &first.name);
    if line.name == ours {
        return String::new();
    }
    let as_good = lines.iter().filter(|other| other.name == ours).map(Line::all);
    let times = as_good.filter(|other| other.hits >= sums.hits).map(|other| other.median_ms());
    match times.min_by(f64::total_cmp) {
        Some(quickest) => format!("{:.1}", sums.median_ms() / quickest),
        None => "-".to_owned(),
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
        [it, us] => format!("{it} : {us} | {:.3}", mcnemar(it, us)),
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

#[cfg(test)]
mod tests {
    use super::super::measure::Times;
    use super::super::score::Score;
    use super::*;

    /// A line with one frame a number; tags are found where it is true.
    fn line(name: &str, found: &[bool], median_us: f64) -> Line {
        let measured = |(index, found): (usize, &bool)| Measured {
            bin: Bin { tilt_deg: 45 * (index as u32 % 2), distance_cm: 20 },
            score: Score { tags: 1, hits: u32::from(*found), ..Score::default() },
            times: Times { min_us: median_us / 2.0, median_us },
        };
        let frames = found.iter().enumerate().map(measured).collect();
        Line {
            family: "tag36h11".to_owned(),
            name: name.to_owned(),
            factor: 1.0,
            variant: String::new(),
            frames,
        }
    }

    #[test]
    fn a_row_holds_recall_by_tilt_time_and_both_ratios() {
        let ours = line("ours", &[true, true, true, false], 2000.0);
        let slow = line("slow", &[true, false, true, false], 30_000.0);
        let page = page(&[ours, slow]);
        let row = page.lines().find(|row| row.starts_with("| slow")).unwrap();
        assert!(
            row.contains(
                "| 0.500 | 1.000 | 0.000 | 0 | 0.000 | +0.000 | 30.000 | 15.000 | 15.0 | 15.0 | 0 : 1 | 1.000 |"
            ),
            "{row}"
        );
    }

    #[test]
    fn where_none_of_ours_finds_as_much_there_is_no_ratio() {
        let lines = [line("ours", &[true, false], 1.0), line("other", &[true, true], 2.0)];
        assert_eq!(times_ours_at_its_recall(&lines[1], &lines[1].all(), &lines), "-");
    }

    #[test]
    fn csv_has_one_row_for_every_line_and_bin() {
        let text = csv(&[line("ours", &[true, false, true], 1.0), line("other", &[true, true], 2.0)]);
        assert_eq!(text.lines().count(), 1 + 2 + 2);
        assert!(text.contains("tag36h11,ours,1,,20,0,2,2,2,0,"), "{text}");
    }
}
