//! The lines as Markdown.

use std::fmt::Write as _;

use tagbus_paper::Phase;

use super::cases::PAPER;
use super::measure::{Line, Measured};
use crate::accuracy::CornerErrors;
use crate::median::median;
use crate::peers::{Hit, Work};
use crate::sweep::mcnemar;

/// What the columns mean.
pub(crate) const COLUMNS: &str = "\
The first lines are the paper's pipeline written plainly (the crate tagbus-paper), pixel by pixel; each line changes one
step of the line \"the paper\" of its decimation. Its times compare its own lines: it is not written for speed.

* recall: share of the tags that were found with their id, the middle within half a side of the truth
* wrong: hits with an id that is not there
* corners: root mean square and mean error outwards over the tags that the line found; in brackets the root mean square of
  the line \"the paper\" over those of them that it found as well, beside the line's own on the same tags
* only it : only the paper: frames that only the one of both solved; p by McNemar's exact test
* other frames: frames whose hits are not those of the line \"the paper\" (ids, and corners to a millionth of a pixel)
* CPU: median over frames of the quickest round; phases likewise, each by itself
* unions, points, quads: calls of union, boundary points that were sorted, quads that were read, mean over frames

";

/// Corners that are nearer than this differ by rounding only, pixels.
const SAME_PX: f64 = 1e-6;

/// The tables of one set and family.
pub(crate) fn section(title: &str, lines: &[Line]) -> String {
    let frames = lines.first().map_or(0, |line| line.frames.len());
    let mut text = format!("## {title}, {frames} frames\n\n");
    results(lines, &mut text);
    text.push('\n');
    phases(lines, &mut text);
    text.push('\n');
    text
}

// Writing to a String cannot fail.
fn results(lines: &[Line], text: &mut String) {
    text.push_str(
        "| line | decimation | recall | wrong | corner RMS px | outwards px | only it : only the paper | p | other frames | \
         CPU ms |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for line in lines {
        let Line { name, factor, frames } = line;
        let wrong: u32 = frames.iter().map(|frame| frame.score.wrong).sum();
        let paper = paper_of(line, lines);
        let errors = corner_errors(frames.iter());
        let against = paper.map_or_else(|| " |  | ".to_owned(), |paper| against(line, paper));
        let on_the_same = paper.map_or_else(String::new, |paper| on_the_same_tags(line, paper));
        let _ = writeln!(
            text,
            "| {name} | {factor} | {:.3} | {wrong} | {:.3}{on_the_same} | {:+.3} | {against} | {:.2} |",
            recall(frames),
            errors.rms(),
            errors.outwards(),
            median(frames.iter().map(|frame| frame.min_us)) * 1e-3,
        );
    }
}

/// The line that another one is compared with: that of the paper at the same decimation.
fn paper_of<'a>(line: &Line, lines: &'a [Line]) -> Option<&'a Line> {
    let paper = lines.iter().find(|other| other.name == PAPER && other.factor == line.factor);
    paper.filter(|_| line.name != PAPER)
}

fn recall(frames: &[Measured]) -> f64 {
    let sum = |count: fn(&Measured) -> u32| f64::from(frames.iter().map(count).sum::<u32>());
    sum(|frame| frame.score.hits) / sum(|frame| frame.score.tags).max(1.0)
}

fn corner_errors<'a>(frames: impl Iterator<Item = &'a Measured>) -> CornerErrors {
    let mut errors = CornerErrors::default();
    frames.filter_map(|frame| frame.score.found).for_each(|found| errors.merge(&found));
    errors
}

/// Root mean squares of both over the frames in which both found the tag.
fn on_the_same_tags(line: &Line, paper: &Line) -> String {
    let both =
        |(own, other): &(&Measured, &Measured)| own.score.found.is_some() && other.score.found.is_some();
    let pairs = || line.frames.iter().zip(&paper.frames).filter(both);
    let own = corner_errors(pairs().map(|(own, _)| own));
    let other = corner_errors(pairs().map(|(_, other)| other));
    format!(" ({:.3}, the paper {:.3})", own.rms(), other.rms())
}

/// Three cells: who solved what, how likely that is by chance, and in how many frames the hits are others.
fn against(line: &Line, paper: &Line) -> String {
    let pairs = || line.frames.iter().zip(&paper.frames);
    let is_solved = |frame: &Measured| frame.score.hits == frame.score.tags;
    let only_it = pairs().filter(|(own, other)| is_solved(own) && !is_solved(other)).count() as u32;
    let only_paper = pairs().filter(|(own, other)| !is_solved(own) && is_solved(other)).count() as u32;
    let others = pairs().filter(|(own, other)| !are_same(&own.hits, &other.hits)).count();
    format!("{only_it} : {only_paper} | {:.3} | {others}", mcnemar(only_it, only_paper))
}

fn are_same(hits: &[Hit], others: &[Hit]) -> bool {
    let is_near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < SAME_PX;
    let is_same = |(hit, other): (&Hit, &Hit)| {
        hit.id == other.id && hit.corners.iter().zip(&other.corners).all(is_near)
    };
    hits.len() == others.len() && hits.iter().zip(others).all(is_same)
}

/// What each phase of the pipeline took.
fn phases(lines: &[Line], text: &mut String) {
    let heads: String = Phase::ALL.iter().map(|phase| format!(" {phase:?} ms |").to_lowercase()).collect();
    let columns = "---|".repeat(Phase::ALL.len() + 5);
    let _ = writeln!(text, "| line | decimation |{heads} unions | points | quads |\n|{columns}");
    for Line { name, factor, frames } in lines {
        let work: Vec<Work> = frames.iter().filter_map(|frame| frame.work).collect();
        if work.is_empty() {
            continue;
        }
        let of_phase = |phase: &Phase| median(work.iter().map(|work| work.phases_us[*phase as usize])) * 1e-3;
        let times: String = Phase::ALL.iter().map(|phase| format!(" {:.2} |", of_phase(phase))).collect();
        let mean = |count: fn(&Work) -> f64| work.iter().map(count).sum::<f64>() / work.len() as f64;
        let _ = writeln!(
            text,
            "| {name} | {factor} |{times} {:.0} | {:.0} | {:.0} |",
            mean(|work| work.counts.unions as f64),
            mean(|work| work.counts.points as f64),
            mean(|work| work.counts.quads as f64),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Score;

    fn hit(shift: f64) -> Hit {
        Hit { id: 3, corners: [[0.0, 9.0], [9.0 + shift, 9.0], [9.0, 0.0], [0.0, 0.0]] }
    }

    fn frame(hits: Vec<Hit>) -> Measured {
        let found = (!hits.is_empty()).then(CornerErrors::default);
        let score = Score { tags: 1, hits: hits.len() as u32, found, wrong: 0 };
        Measured { score, hits, min_us: 2000.0, work: None }
    }

    #[test]
    fn a_line_is_compared_with_the_papers_of_its_decimation() {
        let line = |name: &str, factor: f64, frames| Line { name: name.to_owned(), factor, frames };
        let lines = [
            line(PAPER, 1.0, vec![frame(vec![]), frame(vec![])]),
            line(PAPER, 2.0, vec![frame(vec![hit(0.0)]), frame(vec![])]),
            line("other", 2.0, vec![frame(vec![hit(1e-9)]), frame(vec![hit(0.0)])]),
        ];
        let text = section("set", &lines);
        assert!(text.contains("| the paper | 2 | 0.500 | 0 | 0.000 | +0.000 |  |  |  | 2.00 |"), "{text}");
        assert!(text.contains("| 1 : 0 | 1.000 | 1 | 2.00 |"), "{text}");
    }

    #[test]
    fn hits_are_the_same_up_to_rounding_only() {
        assert!(are_same(&[hit(0.0)], &[hit(1e-9)]));
        assert!(!are_same(&[hit(0.0)], &[hit(1e-3)]));
        assert!(!are_same(&[hit(0.0)], &[]));
        assert!(!are_same(&[hit(0.0)], &[Hit { id: 4, ..hit(0.0) }]));
    }
}
