//! Tables of phases.

use std::fmt::Write as _;

use super::goals;
use super::measure::{Block, PHASES, PhaseTimes};
use crate::median::median;

/// A Markdown page: goals, then a table a group of frames.
pub(crate) fn page(blocks: &[Block]) -> String {
    let mut text = goals::table(blocks);
    for group in blocks.chunk_by(|a, b| a.group == b.group) {
        let names: Vec<&str> = PHASES.iter().map(|(_, name)| *name).collect();
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "## {}, {} frames of 1296x964{}\n\n| families | decimation | level | {} | all ms | {}\n|{}\n",
            group[0].group,
            group[0].frames,
            if group.iter().all(|block| block.frames == group[0].frames) {
                ""
            } else {
                " a family, with a tag of it"
            },
            names.join(" | "),
            heads(&group[0]),
            "---|".repeat(8 + 3 * group[0].others.len())
        );
        group.iter().for_each(|block| text += &rows(block));
        text.push('\n');
    }
    text
}

fn heads(block: &Block) -> String {
    let head = |(name, _): &(String, _)| format!("{name} ms | times ours, median | least | ");
    block.others.iter().map(head).collect::<String>().trim_end().to_owned()
}

/// A row for every level: medians over pictures of the quickest rounds.
fn rows(block: &Block) -> String {
    let mut text = String::new();
    for (level, times) in &block.levels {
        let phases: Vec<String> = (0..PHASES.len())
            .map(|phase| format!("{:.3}", median(picked(times, |times| times.0[phase])) * 1e-3))
            .collect();
        let totals = picked(times, PhaseTimes::total);
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "| {} | {} | {level} | {} | {:.3} |",
            block.families,
            block.factor,
            phases.join(" | "),
            median(totals.iter().copied()) * 1e-3
        );
        for (_, theirs) in &block.others {
            let ratios: Vec<f64> = totals.iter().zip(theirs).map(|(ours, theirs)| theirs / ours).collect();
            let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
            let _ = write!(
                text,
                " {:.3} | {:.1} | {least:.1} |",
                median(theirs.iter().copied()) * 1e-3,
                median(ratios)
            );
        }
        text.push('\n');
    }
    text
}

fn picked(times: &[PhaseTimes], value: impl Fn(&PhaseTimes) -> f64) -> Vec<f64> {
    times.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tagbus_detector::Level;

    #[test]
    fn rows_hold_medians_over_pictures_and_ratios_of_each_picture() {
        let times = |us: f64| PhaseTimes([us, 2.0 * us, 0.0, us]);
        let block = Block {
            group: "natural",
            frames: 3,
            families: "tag36h11".to_owned(),
            factor: 1.5,
            levels: vec![(Level::SCALAR, vec![times(100.0), times(300.0), times(200.0)])],
            others: vec![("C".to_owned(), vec![4000.0, 6000.0, 8000.0])],
        };
        let expected =
            "| tag36h11 | 1.5 | scalar | 0.200 | 0.400 | 0.000 | 0.200 | 0.800 | 6.000 | 10.0 | 5.0 |\n";
        assert_eq!(rows(&block), expected);
        let columns = |line: &str| line.matches('|').count();
        let page = page(&[block]);
        let lines: Vec<usize> = page.lines().filter(|line| line.starts_with('|')).map(columns).collect();
        assert_eq!(lines, [12, 12, 12], "{page}");
    }
}
