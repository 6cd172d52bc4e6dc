//! Tables of threads.

use std::fmt::Write as _;

use super::measure::{Line, Times};
use crate::median::median;

/// Frames that take one thread longer than this are counted apart, milliseconds.
const LONG_MS: f64 = 3.0;

/// A Markdown table: a row for each group of frames and number of threads.
pub(crate) fn page(blocks: &[Vec<Line>]) -> String {
    let mut text = String::from(
        "Times are medians over a group's pictures of the quickest and of the middle round; how many times sooner is told by the \
         quickest rounds of each picture.\n\n\
         | frames | pictures | tags | threads | quickest ms | middle ms | sooner, median | least | over 3 ms | sooner, median | \
         least |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for lines in blocks {
        lines.iter().for_each(|line| text += &row(line, &lines[0]));
    }
    text
}

fn row(line: &Line, one: &Line) -> String {
    let Line { group, threads, tags, times } = line;
    let ratio = |(one, times): (&Times, &Times)| (one.least, one.least / times.least);
    let ratios: Vec<(f64, f64)> = one.times.iter().zip(times).map(ratio).collect();
    let all: Vec<f64> = ratios.iter().map(|(_, ratio)| *ratio).collect();
    let long: Vec<f64> = ratios.iter().filter(|(ms, _)| *ms > LONG_MS).map(|(_, ratio)| *ratio).collect();
    let (least, middle): (Vec<f64>, Vec<f64>) = times.iter().map(|times| (times.least, times.median)).unzip();
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "| {group} | {} | {tags} | {threads} | {:.3} | {:.3} | {} | {} | {} |",
        times.len(),
        median(least),
        median(middle),
        sooner(&all),
        long.len(),
        sooner(&long),
    );
    text
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
    use super::*;

    #[test]
    fn rows_compare_picture_by_picture_and_count_long_frames_apart() {
        let line = |threads, least: [f64; 3]| Line {
            group: "natural 640x480".to_owned(),
            threads,
            tags: 7,
            times: least.map(|least| Times { least, median: least + 1.0 }).to_vec(),
        };
        let (one, two) = (line(1, [4.0, 1.0, 9.0]), line(2, [2.0, 1.0, 6.0]));
        assert_eq!(
            row(&two, &one),
            "| natural 640x480 | 3 | 7 | 2 | 2.000 | 3.000 | 1.50 | 1.00 | 2 | 2.00 | 1.50 |\n"
        );
        let short = line(1, [1.0, 1.0, 1.0]);
        assert!(row(&short, &short).ends_with("| 1.00 | 1.00 | 0 |  |  |\n"), "{}", row(&short, &short));
    }
}
