//! What was found, in words and figures.

use std::fmt::Write as _;

use super::measure::{FARTHEST_M, Line, NEAREST_M, Seen};

/// The tags from the outermost to the innermost.
pub(super) const LEVELS: [&str; 3] = ["outermost", "middle", "innermost"];
/// Every so many distances are shown on the page; the CSV has all.
const SHOWN_EVERY: usize = 10;

/// A Markdown page: the range of every detector, the range of every tag, and some distances of the first detector.
pub(crate) fn page(lines: &[Line]) -> String {
    let mut text = String::from(
        "| detector | decimation | distances from 0.08 to 16.15 m | found in 9 of 10 frames at | missed | without a gap to | \
         last seen at | wrong hits |\n|---|---|---|---|---|---|---|---|\n",
    );
    for line in lines {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", range_row(line));
    }
    text += "\nDistances in metres at which each tag is found in 9 of 10 frames, and at how many between them it is not:\n\n\
             | detector | decimation | tag | from | to | missed between |\n|---|---|---|---|---|---|\n";
    for line in lines {
        for level in 0..LEVELS.len() {
            let _ = writeln!(text, "{}", level_row(line, level));
        }
    }
    if let Some(first) = lines.first() {
        text += &distances_of(first);
    }
    text
}

fn range_row(line: &Line) -> String {
    let within = line.distances.iter().filter(|seen| seen.distance_m <= FARTHEST_M);
    let missed: Vec<&Seen> = within.clone().filter(|seen| !seen.is_enough(seen.found)).collect();
    let all = within.count();
    let list: Vec<String> = missed
        .iter()
        .map(|seen| format!("{:.3} m ({} of {})", seen.distance_m, seen.found, seen.frames))
        .collect();
    let gapless = line.distances.iter().take_while(|seen| seen.is_enough(seen.found)).last();
    let last = line.distances.iter().rfind(|seen| seen.found > 0);
    let metres =
        |seen: Option<&Seen>| seen.map_or_else(|| "-".to_owned(), |seen| format!("{:.2} m", seen.distance_m));
    let wrong: u32 = line.distances.iter().map(|seen| seen.wrong).sum();
    let missed_list = if list.is_empty() { "none".to_owned() } else { list.join(", ") };
    format!(
        "| {} | {} | {all} | {} | {missed_list} | {} | {} | {wrong} |",
        line.name,
        line.factor,
        all - missed.len(),
        metres(gapless),
        metres(last)
    )
}

fn level_row(line: &Line, level: usize) -> String {
    let is_found = |seen: &&Seen| seen.is_enough(seen.levels[level]);
    let first = line.distances.iter().position(|seen| is_found(&seen));
    let last = line.distances.iter().rposition(|seen| is_found(&seen));
    let head = format!("| {} | {} | {}", line.name, line.factor, LEVELS[level]);
    let (Some(first), Some(last)) = (first, last) else { return format!("{head} | - | - | |") };
    let between = &line.distances[first..=last];
    let missed = between.iter().filter(|seen| !is_found(seen)).count();
    let [from, to] = [first, last].map(|index| line.distances[index].distance_m);
    format!("{head} | {from:.3} | {to:.2} | {missed} |")
}

fn distances_of(line: &Line) -> String {
    let mut text = format!(
        "\n{}, decimation {}, frames in which a tag was found, every tenth distance (the CSV has all):\n\n\
         | metres | frames | any | outermost | middle | innermost |\n|---|---|---|---|---|---|\n",
        line.name, line.factor
    );
    for Seen { distance_m, frames, found, levels: [outermost, middle, innermost], .. } in
        line.distances.iter().step_by(SHOWN_EVERY)
    {
        // Writing to a String cannot fail.
        let _ =
            writeln!(text, "| {distance_m:.3} | {frames} | {found} | {outermost} | {middle} | {innermost} |");
    }
    text
}

/// Whether the first detector is found at every distance of the paper's range.
pub(crate) fn verdict(lines: &[Line]) -> String {
    let Some(line) = lines.first() else { return String::new() };
    let missed: Vec<String> = line
        .distances
        .iter()
        .filter(|seen| seen.distance_m <= FARTHEST_M && !seen.is_enough(seen.found))
        .map(|seen| format!("{:.3}", seen.distance_m))
        .collect();
    match missed.is_empty() {
        true => format!("found at every distance from {NEAREST_M} to {FARTHEST_M} m\n"),
        false => format!("MISSED at these distances in metres: {}\n", missed.join(", ")),
    }
}

/// All distances of all detectors.
pub(crate) fn csv(lines: &[Line]) -> String {
    let mut text =
        String::from("detector,decimation,distance_m,frames,found,outermost,middle,innermost,wrong_hits\n");
    for line in lines {
        for Seen { distance_m, frames, found, levels: [outermost, middle, innermost], wrong } in
            &line.distances
        {
            let Line { name, factor, .. } = line;
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{name},{factor},{distance_m:.4},{frames},{found},{outermost},{middle},{innermost},{wrong}"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(found: &[u32]) -> Line {
        let seen = |(index, found): (usize, &u32)| Seen {
            distance_m: 1.0 + index as f64,
            frames: 10,
            found: *found,
            levels: [*found, 0, 0],
            wrong: 0,
        };
        Line { name: "x".to_owned(), factor: 1.0, distances: found.iter().enumerate().map(seen).collect() }
    }

    #[test]
    fn a_missed_distance_is_named_and_ends_the_gapless_range() {
        let lines = [line(&[10, 9, 8, 10, 1, 0])];
        assert_eq!(
            range_row(&lines[0]),
            "| x | 1 | 6 | 3 | 3.000 m (8 of 10), 5.000 m (1 of 10), 6.000 m (0 of 10) | 2.00 m | 5.00 m | 0 |"
        );
        assert_eq!(level_row(&lines[0], 0), "| x | 1 | outermost | 1.000 | 4.00 | 1 |");
        assert_eq!(level_row(&lines[0], 1), "| x | 1 | middle | - | - | |");
        assert_eq!(verdict(&lines), "MISSED at these distances in metres: 3.000, 5.000, 6.000\n");
        assert!(verdict(&[line(&[9, 10])]).starts_with("found at every distance"));
    }
}
