//! How many times our time the C library is to take, and takes.

use super::measure::Block;
use crate::median::median;

/// A floor under the median ratio over a group's pictures.
struct Goal {
    group: &'static str,
    factor: f64,
    families: Families,
    /// `None` for the best level.
    level: Option<&'static str>,
    least: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Families {
    /// Each alone.
    One,
    /// Both polarities in one detector.
    Both,
}

const GOALS: [Goal; 6] = [
    Goal { group: "natural", factor: 1.0, families: Families::One, level: None, least: 22.0 },
    Goal { group: "textured", factor: 1.0, families: Families::One, level: None, least: 38.0 },
    Goal { group: "wall", factor: 1.0, families: Families::One, level: None, least: 400.0 },
    Goal { group: "natural", factor: 2.0, families: Families::One, level: None, least: 17.0 },
    Goal { group: "natural", factor: 1.0, families: Families::Both, level: None, least: 13.0 },
    Goal { group: "natural", factor: 1.0, families: Families::One, level: Some("avx2"), least: 16.0 },
];

/// A row for every goal and block that it is about; none without other detectors.
pub(super) fn table(blocks: &[Block]) -> String {
    let rows: Vec<String> =
        GOALS.iter().flat_map(|goal| blocks.iter().filter_map(|block| row(goal, block))).collect();
    if rows.is_empty() {
        return String::new();
    }
    format!(
        "| frames | families | decimation | level | at least | median of ratios | least ratio | reached |\n\
         |---|---|---|---|---|---|---|---|\n{}\n",
        rows.join("")
    )
}

fn row(goal: &Goal, block: &Block) -> Option<String> {
    let families = if block.families.contains('+') { Families::Both } else { Families::One };
    if block.group != goal.group || block.factor != goal.factor || families != goal.families {
        return None;
    }
    let (level, ours) = match goal.level {
        None => block.levels.last()?,
        Some(name) => block.levels.iter().find(|(level, _)| level.name() == name)?,
    };
    let (_, theirs) = block.others.first()?;
    let ratios: Vec<f64> = ours.iter().zip(theirs).map(|(ours, theirs)| theirs / ours.total()).collect();
    let (middle, worst) =
        (median(ratios.iter().copied()), ratios.iter().copied().fold(f64::INFINITY, f64::min));
    let reached = if middle >= goal.least { "yes" } else { "NO" };
    let Goal { group, factor, least, .. } = goal;
    Some(format!(
        "| {group} | {} | {factor} | {level} | {least} | {middle:.1} | {worst:.1} | {reached} |\n",
        block.families
    ))
}

#[cfg(test)]
mod tests {
    use super::super::measure::PhaseTimes;
    use super::*;
    use tagbus_detector::Level;

    #[test]
    fn a_goal_is_about_the_median_of_ratios() {
        let block = |theirs: Vec<f64>| Block {
            group: "wall",
            frames: 3,
            families: "tag36h11".to_owned(),
            factor: 1.0,
            levels: vec![(Level::SCALAR, vec![PhaseTimes([1.0, 0.0, 0.0, 0.0]); 3])],
            others: vec![("C".to_owned(), theirs)],
        };
        let reached = table(&[block(vec![10.0, 400.0, 900.0])]);
        assert!(
            reached.ends_with("| wall | tag36h11 | 1 | scalar | 400 | 400.0 | 10.0 | yes |\n\n"),
            "{reached}"
        );
        assert!(table(&[block(vec![10.0, 399.0, 900.0])]).contains("| 399.0 | 10.0 | NO |"));
    }
}
