//! `tagbus family check`: whether a family is what it says, and how often chance would make a tag of its.

use std::io::{self, Write};

use serde::Serialize;
use tagbus_family::complexity::Metric;
use tagbus_family::{Family, MinimumDistance, Recipe, published};

use super::list::border_name;
use crate::chosen_family::{ChosenFamily, capped};
use crate::outcome::{Failure, Outcome};
use crate::output::Reader;
use crate::tag_json::rounded;

/// Wrong bits for which false accepts are told.
const MOST_HAMMING: u32 = 3;
/// The unit of false accepts.
const QUADS: f64 = 1e6;

/// What was measured.
#[derive(Serialize)]
struct Checked<'a> {
    name: &'a str,
    codes: usize,
    bits: u32,
    border: &'static str,
    tag_cells: usize,
    printed_cells: usize,
    stated_distance: u32,
    /// Between two tags, however they are turned; none for a family of one.
    distance_between_codes: Option<u32>,
    /// Between a tag and itself turned.
    distance_to_own_rotations: u32,
    complexity: Complexity,
    corrections: Vec<Correction>,
    is_sound: bool,
}

#[derive(Serialize)]
struct Complexity {
    metric: &'static str,
    least: u32,
    mean: f64,
    /// What the family's recipe asks for, where it is known.
    asked: Option<u32>,
    codes_below: Option<usize>,
}

/// What it means to ask for so many corrected bits.
#[derive(Serialize)]
struct Correction {
    asked: u32,
    in_force: u32,
    /// For random bits, read in any of four rotations.
    false_accepts_per_million_quads: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<String>,
}

/// Writes what is measured, as text or as a line of JSON.
pub(super) fn execute(chosen: &ChosenFamily, json: bool) -> Result<Outcome, Failure> {
    let checked = check(chosen.family(), recipe_of(chosen).as_ref());
    let mut out = io::stdout().lock();
    if json {
        writeln!(out, "{}", serde_json::to_string(&checked)?)?;
    } else {
        out.write_all(page(&checked, Reader::of_stdout()).as_bytes())?;
    }
    Ok(if checked.is_sound { Outcome::Done } else { Outcome::Failed })
}

/// A file says how its codes were searched; of the published AprilTag families it is known.
fn recipe_of(chosen: &ChosenFamily) -> Option<Recipe> {
    let published = || published::named(chosen.family().name()).ok()?.recipe().ok();
    chosen
        .file
        .recipe
        .clone()
        .or_else(|| published().filter(|recipe| recipe.layout() == chosen.family().layout()))
}

fn check<'a>(family: &'a Family, recipe: Option<&Recipe>) -> Checked<'a> {
    let measured = family.minimum_distance();
    let layout = family.layout();
    let complexity = complexity(family, recipe);
    Checked {
        name: family.name(),
        codes: family.codes().len(),
        bits: layout.bit_count(),
        border: border_name(layout.border()),
        tag_cells: layout.width_at_border(),
        printed_cells: layout.total_width(),
        stated_distance: family.distance(),
        distance_between_codes: measured.between_codes,
        distance_to_own_rotations: measured.own_rotations,
        is_sound: is_far_enough(&measured, family.distance()) && complexity.codes_below.unwrap_or(0) == 0,
        complexity,
        corrections: (0..=MOST_HAMMING).map(|asked| correction(family, asked)).collect(),
    }
}

/// Between its codes: that a tag resembles itself turned makes only its corners doubtful, and the ArUco families that
/// have such tags are what they are.
fn is_far_enough(measured: &MinimumDistance, stated: u32) -> bool {
    measured.between_codes.is_none_or(|bits| bits >= stated)
}

fn complexity(family: &Family, recipe: Option<&Recipe>) -> Complexity {
    let rule = recipe.map(Recipe::rule);
    let metric = rule.map_or(Metric::Ising, |rule| rule.metric);
    let measure = |&code: &u64| metric.of(family.layout(), code, u32::MAX);
    let measured: Vec<u32> = family.codes().iter().map(measure).collect();
    let sum: f64 = measured.iter().copied().map(f64::from).sum();
    let below = |least: u32| measured.iter().filter(|complexity| **complexity < least).count();
    Complexity {
        metric: metric.name(),
        least: measured.iter().copied().min().unwrap_or(0),
        mean: rounded(sum / measured.len() as f64, 2),
        asked: rule.map(|rule| rule.least),
        codes_below: rule.map(|rule| below(rule.least)),
    }
}

fn correction(family: &Family, asked: u32) -> Correction {
    let in_force = asked.min(family.correctable());
    Correction {
        asked,
        in_force,
        false_accepts_per_million_quads: family.false_accept_chance(in_force) * QUADS,
        warning: capped(family, asked),
    }
}

fn page(checked: &Checked, reader: Reader) -> String {
    let Checked { name, codes, bits, border, tag_cells, printed_cells, .. } = checked;
    let mut lines = vec![
        format!("{}: {codes} tags of {bits} bits", reader.bold(name)),
        format!("layout: valid; border {border}, tag size {tag_cells} of {printed_cells} cells"),
        distances(checked),
        complexities(&checked.complexity),
        String::new(),
        "corrected bits   in force   false accepts in a million quads of random bits, all four rotations"
            .to_owned(),
    ];
    for Correction { asked, in_force, false_accepts_per_million_quads: accepts, .. } in &checked.corrections {
        lines.push(format!("{asked:>14}   {in_force:>8}   {accepts:.3}"));
    }
    lines.extend(
        checked
            .corrections
            .iter()
            .filter_map(|line| line.warning.as_ref())
            .map(|text| format!("warning: {text}")),
    );
    lines.push(String::from(if checked.is_sound {
        "the family is what it says"
    } else {
        "the family is NOT what it says"
    }));
    lines.join("\n") + "\n"
}

fn distances(checked: &Checked) -> String {
    let between = checked.distance_between_codes.map_or("(one tag only)".to_owned(), |bits| bits.to_string());
    format!(
        "minimum distance: {between} bits between tags, {} to own rotations; stated {}",
        checked.distance_to_own_rotations, checked.stated_distance
    )
}

fn complexities(complexity: &Complexity) -> String {
    let Complexity { metric, least, mean, asked, codes_below } = complexity;
    let rule = match (asked, codes_below) {
        (Some(asked), Some(below)) => format!("asked {asked}, {below} tags below"),
        _ => "how the family was made is not known".to_owned(),
    };
    format!("complexity ({metric}): least {least}, mean {mean:.1}; {rule}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked_page(name: &str) -> String {
        let chosen = ChosenFamily::published(name).unwrap();
        page(&check(chosen.family(), recipe_of(&chosen).as_ref()), Reader::Program)
    }

    #[test]
    fn a_published_family_is_what_it_says() {
        let page = checked_page("tagCircle21h7");
        assert!(page.contains("7 bits between tags") && page.contains("asked 41, 0 tags below"), "{page}");
        assert!(page.ends_with("the family is what it says\n"), "{page}");
    }

    #[test]
    fn corrections_that_are_not_possible_are_capped_with_a_warning() {
        let page = checked_page("tag16h5");
        assert!(page.contains("\n             3          2   "), "{page}");
        assert!(page.contains("warning: tag16h5: 3 corrected bits"), "{page}");
    }

    #[test]
    fn a_family_that_is_closer_than_it_says_is_found_out() {
        let whole = Family::published("tag16h5").unwrap();
        let claimed = Family::new("claimed", whole.layout().clone(), whole.codes().to_vec(), 7).unwrap();
        assert!(!check(&claimed, None).is_sound);
        assert!(check(&whole, None).is_sound);
    }
}
