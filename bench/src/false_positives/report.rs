//! The tables as a page and as CSV.

use std::fmt::Write as _;

use super::contenders::{DEFAULTS, SHARE_SAMPLE};
use super::interval::{Bootstrap, DRAWS, Estimate};
use super::matches::expected;
use super::run::{Findings, Outcome, Plan};
use super::variants::{SCALES, TURNS_DEG};
use super::verdict::verdict;

/// Seed of the draws.
const SEED: u64 = 1;
/// A tag may show in any of its four turns.
const TURNS: f64 = 4.0;

/// What the figures were measured with, and how.
pub(crate) fn how(plan: &Plan) -> String {
    format!(
        "tables I and II of the paper by `{}`; the paper's detector as it is written (decimation 1, sharpening 0.25) up to the \
         sampled code of every quad whose border has the polarity of its kind; each picture in {} sizes ({} to {}) and {} \
         rotations ({} to {} degrees), rotated ones cropped to what lies wholly inside",
        command(plan),
        SCALES.len(),
        SCALES[0],
        SCALES[SCALES.len() - 1],
        TURNS_DEG.len(),
        TURNS_DEG[0],
        TURNS_DEG[TURNS_DEG.len() - 1],
    )
}

/// The command without the folders above those of the pictures, which differ from machine to machine.
fn command(plan: &Plan) -> String {
    let names = plan.folders.iter().map(|folder| folder.file_name().unwrap_or_default().to_string_lossy());
    let folders = names.collect::<Vec<_>>().join(",");
    let same_place = match plan.same_place.is_empty() {
        true => String::new(),
        false => format!(" --same-place {}", plan.same_place.join(",")),
    };
    format!("tagbus-bench false-positives --images {folders}{same_place} --seeds {}", plan.seeds)
}

impl Outcome {
    pub(super) fn bootstrap(&self) -> Bootstrap {
        Bootstrap::new(&self.quads, self.seeds(), SEED)
    }

    /// What random bits would give, as the paper prints it: without the four turns.
    fn printed(&self, bits: usize) -> f64 {
        expected(self.quad_count(), self.kind.codes, self.bit_count, bits)
    }

    /// What random bits would give in any of four turns.
    pub(super) fn random(&self, bits: usize) -> f64 {
        TURNS * self.printed(bits)
    }

    /// What the paper found, by what random bits would give in any of four turns.
    fn ratio_of_paper(&self, metric: usize, bits: usize) -> Option<f64> {
        let paper = &self.kind.paper;
        let random = TURNS * expected(paper.quads, self.kind.codes, self.bit_count, bits);
        paper.counts[metric].get(bits).map(|&count| f64::from(count) / random)
    }

    pub(super) fn levels(&self) -> std::ops::RangeInclusive<usize> {
        0..=self.most_bits
    }
}

/// A Markdown page.
pub(crate) fn page(findings: &Findings) -> String {
    let places = findings.outcomes.first().map_or(0, |outcome| outcome.quads.len());
    let mut text = format!("{} pictures of {places} places", findings.pictures);
    if !findings.left_out.is_empty() {
        text += &format!("; left out, because they hold codes: {}", findings.left_out.join(", "));
    }
    text += &format!(".\n\n{}\n", explanation());
    text + &findings.outcomes.iter().map(section).collect::<String>()
}

/// How the tables are to be read.
fn explanation() -> String {
    format!(
        "Counted are quads whose nearest code differs in exactly so many bits, up to what can be corrected without doubt. All \
         families of a table have the same layout, distance, number of codes and seeds; they differ in the complexity that \
         codes are held to. The limits of the library let pass about the same share of random codes, as near as whole numbers \
         allow ({} of them tell it); because that is not very near, a second limit to the Ising energy is added for each other \
         metric: the highest that lets pass no less than that metric does.\n\n\
         Quads of one picture, and of one place or board, resemble each other, and families of other seeds differ: intervals \
         (95 %) are bootstraps that draw both places and seeds anew, {DRAWS} times, the same for all families. Each stands for itself; \
         none is widened because there are many. [0, 0] says that nothing was found, not that nothing would be.\n\n\
         \"Random bits\" are what quads of random bits would give. The paper's row leaves out that a tag may show in any of four \
         turns: quads * codes * C(n, k) / 2^n. The row below it is four times that, and what ratios refer to.\n",
        thousands(SHARE_SAMPLE)
    )
}

fn section(outcome: &Outcome) -> String {
    let kind = outcome.kind;
    let mut text = format!(
        "\n## {}\n\n{} quads; the first {} codes of each family, {} families of each line, seeds from 0 on{}.\n",
        kind.name,
        thousands(outcome.quad_count()),
        thousands(kind.codes),
        outcome.seeds(),
        passed_over(outcome)
    );
    let bootstrap = outcome.bootstrap();
    text += &found(outcome, &bootstrap);
    text += &ratios(outcome, &bootstrap);
    text += &differences(outcome, &bootstrap);
    text + &verdict(outcome, &bootstrap)
}

fn passed_over(outcome: &Outcome) -> String {
    match outcome.passed_over.as_slice() {
        [] => String::new(),
        seeds => format!(" but {seeds:?}, which give some line too few codes"),
    }
}

fn found(outcome: &Outcome, bootstrap: &Bootstrap) -> String {
    let title = "False positives a family by exactly so many corrected bits, mean over the families:";
    let mut text = head(outcome, title, "codes held to | random codes that pass");
    for line in &outcome.lines {
        let name = format!("{} | {:.3}", line.contender.name(), line.share);
        text += &row(&name, outcome.levels().map(|bits| shown(bootstrap.estimate(&line.counts, bits))));
    }
    let printed = outcome.levels().map(|bits| number(outcome.printed(bits)));
    text += &row("random bits, as the paper prints them |", printed);
    text + &row(
        "random bits in any of four turns |",
        outcome.levels().map(|bits| number(outcome.random(bits))),
    )
}

fn ratios(outcome: &Outcome, bootstrap: &Bootstrap) -> String {
    let mut text = head(outcome, "The same divided by random bits in any of four turns:", "codes held to");
    for line in &outcome.lines {
        let ratio = |bits| shown(bootstrap.estimate(&line.counts, bits).over(outcome.random(bits)));
        text += &row(&line.contender.name(), outcome.levels().map(ratio));
    }
    for (place, metric) in ["rectangles", "components", "Ising"].into_iter().enumerate() {
        let ratio = |bits| outcome.ratio_of_paper(place, bits).map_or("-".to_owned(), number);
        text += &row(&format!("the paper's {metric}, limit unknown"), outcome.levels().map(ratio));
    }
    text
}

fn differences(outcome: &Outcome, bootstrap: &Bootstrap) -> String {
    let mut text = head(outcome, "Ising minus the other, on the same draws:", "Ising | other");
    for pair in &outcome.pairs {
        let [ising, other] = [pair.ising, pair.other].map(|place| &outcome.lines[place]);
        let difference = |bits| shown(bootstrap.difference([&ising.counts, &other.counts], bits));
        let name = format!("{} | {}", ising.contender.name(), other.contender.name());
        text += &row(&name, outcome.levels().map(difference));
    }
    text
}

/// Title and head of a table with a column for each number of bits.
fn head(outcome: &Outcome, title: &str, first: &str) -> String {
    let columns = outcome.levels().map(|bits| format!("{bits} bits"));
    let rule = "|---".repeat(first.split('|').count()) + &"|---:".repeat(outcome.most_bits + 1);
    format!("\n{title}\n\n{}{rule}|\n", row(first, columns))
}

fn row(first: &str, cells: impl Iterator<Item = String>) -> String {
    cells.fold(format!("| {first} |"), |text, cell| text + " " + &cell + " |") + "\n"
}

fn number(value: f64) -> String {
    let sign = if value < 0.0 { "-" } else { "" };
    match value.abs() {
        size if size >= 1000.0 => format!("{sign}{}", thousands(size.round() as usize)),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn shown(Estimate { value, low, high }: Estimate) -> String {
    format!("{} [{}, {}]", number(value), number(low), number(high))
}

/// With commas.
pub(super) fn thousands(count: usize) -> String {
    match count {
        0..1000 => count.to_string(),
        _ => format!("{},{:03}", thousands(count / 1000), count % 1000),
    }
}

/// A line for each layout, contender and number of corrected bits.
pub(crate) fn csv(findings: &Findings) -> String {
    let mut text = String::from(
        "layout,codes_held_to,share_of_random_codes,corrected_bits,false_positives,low,high,random_as_printed,random_four_turns,\
         quads,places,families,is_default\n",
    );
    for outcome in &findings.outcomes {
        let bootstrap = outcome.bootstrap();
        for (place, bits) in
            (0..outcome.lines.len()).flat_map(|place| outcome.levels().map(move |bits| (place, bits)))
        {
            let line = &outcome.lines[place];
            let Estimate { value, low, high } = bootstrap.estimate(&line.counts, bits);
            let (layout, name, share) = (outcome.kind.name, line.contender.name(), line.share);
            let (printed, random) = (outcome.printed(bits), outcome.random(bits));
            let (quads, places, families) = (outcome.quad_count(), outcome.quads.len(), outcome.seeds());
            let is_default = DEFAULTS.contains(&place);
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{layout},{name},{share:.4},{bits},{value:.4},{low:.4},{high:.4},{printed:.4},{random:.4},{quads},{places},{families},{is_default}"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::verdict::tests::outcome;
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn the_command_names_no_folder_of_this_machine() {
        let folders = ["/home/somebody/data/wild", "../boards/"].map(PathBuf::from).to_vec();
        let plan =
            Plan { folders, same_place: vec!["hall".to_owned(), "yard".to_owned()], seeds: 20, threads: 1 };
        let wanted = "tagbus-bench false-positives --images wild,boards --same-place hall,yard --seeds 20";
        assert_eq!(command(&plan), wanted);
        assert!(!how(&plan).contains("somebody"));
    }

    #[test]
    fn numbers_have_commas_and_as_many_digits_as_mean_something() {
        assert_eq!([0, 999, 1000, 1_002_003].map(thousands), ["0", "999", "1,000", "1,002,003"]);
        let shown = [0.126, -12.34, 123.4, 5216.4].map(number);
        assert_eq!(shown, ["0.13", "-12.3", "123", "5,216"]);
        assert_eq!(number(-5216.4), "-5,216");
    }

    #[test]
    fn every_row_has_as_many_cells_as_its_head() {
        let outcome = outcome([4, 4, 4, 1]);
        let findings =
            Findings { pictures: 9, left_out: vec!["grid.png".to_owned()], outcomes: vec![outcome] };
        let page = page(&findings);
        let tables: Vec<Vec<usize>> = page
            .split("\n\n")
            .filter(|part| part.starts_with('|'))
            .map(|table| table.trim().lines().map(|line| line.matches('|').count()).collect())
            .collect();
        assert_eq!(tables.len(), 3);
        assert!(tables.iter().all(|rows| rows.iter().all(|cells| *cells == rows[0])), "{page}");
        assert!(page.contains("grid.png"), "{page}");
        let columns: Vec<usize> = csv(&findings).lines().map(|line| line.matches(',').count()).collect();
        assert!(columns.iter().all(|&count| count == columns[0]) && columns.len() == 1 + 4 * 4);
    }

    #[test]
    fn the_ratios_of_the_paper_are_those_of_its_tables_to_four_times_its_last_row() {
        let outcome = outcome([4, 4, 4, 1]);
        let ratios = [0, 1, 2].map(|metric| outcome.ratio_of_paper(metric, 2).unwrap());
        let wanted = [40_462.0, 45_052.0, 22_266.0].map(|count: f64| count / (4.0 * 21_479.1));
        assert!(ratios.iter().zip(&wanted).all(|(ratio, wanted)| (ratio / wanted - 1.0).abs() < 1e-4));
        assert_eq!(outcome.ratio_of_paper(0, 4), None);
    }
}
