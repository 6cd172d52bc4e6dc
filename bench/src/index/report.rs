//! What was measured, as text.

use std::fmt::Write as _;

use super::lookup::LookupNs;
use super::measure::{Line, Outcome};

/// A Markdown page: all together, then a row for each family.
pub(crate) fn page(outcome: &Outcome) -> String {
    let load = &outcome.load;
    let (first, least, median) = [load.first_us, load.times.min_us, load.times.median_us].map(ms).into();
    let indexes: usize = outcome.lines.iter().map(|line| line.bytes).sum();
    let mut text = format!(
        "All nine families together:\n\n\
         * memory: {} bytes held, of which the indexes say that {} are theirs; {} at most meanwhile\n\
         * ready after {least:.2} ms (least), {median:.2} ms (median), {first:.2} ms (the first time in the process)\n\
         * a random code looked up in all of them, one after the other: {} ns (least), {} (median)\n\n",
        thousands(load.held),
        thousands(indexes),
        thousands(load.peak),
        ns(outcome.in_all.least),
        ns(outcome.in_all.median),
    );
    text += "| family | codes | corrected bits | index bytes | random code ns, least | median | tag ns, least | median | probes | of \
             them tags | same as brute force | brute force CPU s |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    outcome.lines.iter().for_each(|line| text += &row(line));
    text
}

fn row(line: &Line) -> String {
    let Line { name, codes, hamming, bytes, random, tags, agreement } = line;
    let mut text = format!("| {name} | {} | {hamming} | {} |", thousands(*codes), thousands(*bytes));
    for LookupNs { least, median } in [random, tags] {
        // Writing to a String cannot fail.
        let _ = write!(text, " {} | {} |", ns(*least), ns(*median));
    }
    for count in [agreement.probes, agreement.tags, agreement.same] {
        let _ = write!(text, " {} |", thousands(count as usize));
    }
    text + &format!(" {:.1} |\n", agreement.cpu_s)
}

fn ms(us: f64) -> f64 {
    us * 1e-3
}

fn ns(value: f64) -> String {
    format!("{value:.0}")
}

/// Digits in groups of three.
fn thousands(value: usize) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::measure::{Plan, run};
    use super::*;

    #[test]
    fn the_page_has_a_row_for_each_family_and_as_many_cells_in_each() {
        let outcome = run(&Plan { hamming: 3, rounds: 1, probes: 10, seed: 1 }).unwrap();
        assert_eq!(outcome.disagreements(), 0);
        let page = page(&outcome);
        let cells: Vec<usize> =
            page.lines().filter(|line| line.starts_with('|')).map(|line| line.matches('|').count()).collect();
        assert_eq!(cells, [13; 11], "{page}");
        assert!(page.contains("| tagCircle49h12 | 65,698 | 3 |"), "{page}");
        assert!(page.contains("| tag16h5 | 30 | 2 |"), "{page}");
    }

    #[test]
    fn digits_are_grouped_from_the_right() {
        assert_eq!([0, 999, 1000, 1_234_567].map(thousands), ["0", "999", "1,000", "1,234,567"]);
    }
}
