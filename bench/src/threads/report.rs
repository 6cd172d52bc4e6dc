//! Tables of threads.

use std::fmt::Write as _;

use super::measure::Line;
use crate::median::median;

/// Frames that take one thread longer than this are counted apart, milliseconds.
const LONG_MS: f64 = 3.0;

/// A Markdown table: a row for each group of frames and number of threads.
pub(crate) fn page(blocks: &[Vec<Line>]) -> String {
    let mut text = String::from(
        "Times are medians over a group's pictures of the quickest and of the middle round; how many times sooner is told by the \
         quickest rounds of each picture. Workers keep off the core that the caller is kept to. Not kept: the same where the kernel \
         puts threads. Apart: the same of as many detectors with one thread each, all at once on one picture, which is what the \
         machine gave to so many threads.\n\n\
         | frames | pictures | tags | threads | quickest ms | middle ms | sooner, median | least | over 3 ms | sooner, median | \
         least | not kept, median | apart, median |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for lines in blocks {
        lines.iter().for_each(|line| text += &row(line, &lines[0]));
    }
    text
}

fn row(line: &Line, one: &Line) -> String {
    let Line { group, threads, tags, times, free, apart } = line;
    let sooner_by = |factor: f64, others: &[f64]| -> Vec<f64> {
        one.times.iter().zip(others).map(|(one, other)| factor * one.least / other).collect()
    };
    let of_long = |ratios: &[f64]| -> Vec<f64> {
        let all = one.times.iter().zip(ratios);
        all.filter(|(one, _)| one.least > LONG_MS).map(|(_, ratio)| *ratio).collect()
    };
    let (least, middle): (Vec<f64>, Vec<f64>) = times.iter().map(|times| (times.least, times.median)).unzip();
    let pinned = sooner_by(1.0, &least);
    let long = of_long(&pinned);
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "| {group} | {} | {tags} | {threads} | {:.3} | {:.3} | {} | {} | {} | {} | {} |",
        times.len(),
        median(least),
        median(middle),
        sooner(&pinned),
        long.len(),
        sooner(&long),
        middle_of(&of_long(&sooner_by(1.0, free))),
        middle_of(&of_long(&sooner_by(*threads as f64, apart))),
    );
    text
}

/// Empty of nothing.
fn middle_of(ratios: &[f64]) -> String {
    if ratios.is_empty() { String::new() } else { format!("{:.2}", median(ratios.iter().copied())) }
}

/// Median and least as two cells; empty ones of nothing.
fn sooner(ratios: &[f64]) -> String {
    match ratios.iter().copied().reduce(f64::min) {
        Some(least) => format!("{:.2} | {least:.2}", median(ratios.iter().copied())),
        None => " | ".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::measure::Times;
    use super::*;

    #[test]
    fn rows_compare_picture_by_picture_and_count_long_frames_apart() {
        let line = |threads, least: [f64; 3]| Line {
            group: "natural 640x480".to_owned(),
            threads,
            tags: 7,
            times: least.map(|least| Times { least, median: least + 1.0 }).to_vec(),
            free: least.map(|least| 2.0 * least).to_vec(),
            apart: least.map(|least| 2.5 * least).to_vec(),
        };
        let (one, two) = (line(1, [4.0, 1.0, 9.0]), line(2, [2.0, 1.0, 6.0]));
        assert_eq!(
            row(&two, &one),
            "| natural 640x480 | 3 | 7 | 2 | 2.000 | 3.000 | 1.50 | 1.00 | 2 | 2.00 | 1.50 | 1.00 | 1.60 |\n"
        );
        let short = line(1, [1.0, 1.0, 1.0]);
        assert!(
            row(&short, &short).ends_with("| 1.00 | 1.00 | 0 |  |  |  |  |\n"),
            "{}",
            row(&short, &short)
        );
    }
}
