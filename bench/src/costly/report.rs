//! Tables over frames, and the worst of them.

use std::fmt::Write as _;

use super::measure::{Group, Row};

/// A costly frame may cost so many times a natural one of its size.
const GOAL: f64 = 6.0;

/// A Markdown page: what is worst, then a table a size and choice of families.
pub(crate) fn page(groups: &[Group]) -> String {
    let mut text = String::from(
        "| size | decimation | families | natural frame, CPU mean ms | worst frame | times natural | above 6 times | most memory, \
         bytes a pixel | hits |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for group in groups {
        text += &summary(group);
    }
    for group in groups {
        text += &table(group);
    }
    text
}

impl Group {
    /// Times our mean over natural pictures, quickest rounds.
    fn ratio(&self, row: &Row) -> f64 {
        row.times[0].min_us / self.natural[0].min_us
    }

    fn bytes_per_pixel(&self, row: &Row) -> f64 {
        row.bytes as f64 / (self.size[0] * self.size[1]) as f64
    }
}

fn summary(group: &Group) -> String {
    let Some(worst) = group.rows.iter().max_by(|a, b| group.ratio(a).total_cmp(&group.ratio(b))) else {
        return String::new();
    };
    let Group { size: [width, height], factor, families, .. } = group;
    let (ratio, natural_ms) = (group.ratio(worst), group.natural[0].min_us * 1e-3);
    let answer = above_the_goal(group);
    let memory = group.rows.iter().map(|row| group.bytes_per_pixel(row)).fold(0.0, f64::max);
    let hits: usize = group.rows.iter().map(|row| row.hits).sum();
    format!(
        "| {width}x{height} | {factor} | {families} | {natural_ms:.3} | {} | {ratio:.1} | {answer} | {memory:.1} | {hits} |\n",
        worst.frame
    )
}

/// The frames that cost too much, or that there are none.
fn above_the_goal(group: &Group) -> String {
    let above = group.rows.iter().filter(|row| group.ratio(row) > GOAL);
    let names: Vec<String> = above.map(|row| format!("{} ({:.1})", row.frame, group.ratio(row))).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn table(group: &Group) -> String {
    let Group { size: [width, height], factor, families, natural, natural_count, .. } = group;
    let mut text = format!(
        "\n## {families}, {width}x{height}, decimation {factor}\n\n| frame | bytes a pixel | {} |\n|---|---|{}\n",
        heads(&group.detectors),
        "---|---|---|".repeat(group.detectors.len())
    );
    // Writing to a String cannot fail.
    let _ = writeln!(text, "| natural (mean of {natural_count}) | | {} |", cells(natural, group));
    for row in &group.rows {
        let memory = group.bytes_per_pixel(row);
        let _ = writeln!(text, "| {} | {memory:.1} | {} |", row.frame, cells(&row.times, group));
    }
    text
}

fn heads(detectors: &[String]) -> String {
    let head = |name: &String| format!("{name}: min ms | median ms | times its natural");
    detectors.iter().map(head).collect::<Vec<_>>().join(" | ")
}

fn cells(times: &[crate::sweep::Times], group: &Group) -> String {
    let cell = |(times, natural): (&crate::sweep::Times, &crate::sweep::Times)| {
        let (min, median) = (times.min_us * 1e-3, times.median_us * 1e-3);
        format!("{min:.3} | {median:.3} | {:.1}", times.min_us / natural.min_us)
    };
    times.iter().zip(&group.natural).map(cell).collect::<Vec<_>>().join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Times;

    fn group(costly_us: f64) -> Group {
        let times = |us: f64| vec![Times { min_us: us, median_us: us }];
        Group {
            size: [10, 10],
            factor: 1.0,
            families: "tag36h11",
            detectors: vec!["ours".to_owned()],
            natural: times(1000.0),
            natural_count: 3,
            rows: [500.0, costly_us]
                .map(|us| Row { frame: format!("{us} us"), times: times(us), hits: 0, bytes: 250 })
                .into(),
        }
    }

    #[test]
    fn the_worst_frame_is_held_to_the_goal() {
        let expected = |answer: &str| format!("| 10x10 | 1 | tag36h11 | 1.000 | {answer} | 2.5 | 0 |\n");
        assert_eq!(summary(&group(6000.0)), expected("6000 us | 6.0 | none"));
        assert_eq!(summary(&group(6100.0)), expected("6100 us | 6.1 | 6100 us (6.1)"));
    }
}
