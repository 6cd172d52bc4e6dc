//! `tagbus family choose`: which published family suits, and why not the others.

use std::cmp::Reverse;
use std::io::{self, Write};

use clap::ValueEnum;
use serde::Serialize;
use tagbus_family::Family;

use super::show::is_round;
use crate::outcome::{Failure, Outcome};
use crate::output::Reader;

/// More false accepts than this in a million quads of random bits are too many: a busy picture has some hundred quads.
const MOST_FALSE_ACCEPTS: f64 = 10.0;

/// What the print looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shape {
    /// Any print
    Square,
    /// Fits into a disc
    Circle,
    /// Has a hole in the middle that a smaller tag fits into
    Hole,
}

/// A family and what speaks for it.
#[derive(Clone, Debug, Serialize)]
struct Candidate {
    family: &'static str,
    ids: usize,
    distance: u32,
    cells: usize,
    corrected_by_default: u32,
    false_accepts_per_million_quads: f64,
    /// Why another is better; none for the best.
    #[serde(skip_serializing_if = "Option::is_none")]
    why_not: Option<String>,
}

/// Writes the recommendation and the others of that shape, as text or a line of JSON each, the best first.
pub(super) fn execute(ids: usize, shape: Shape, json: bool) -> Result<Outcome, Failure> {
    let candidates = ranked(ids, shape)?;
    let mut out = io::stdout().lock();
    if json {
        for candidate in &candidates {
            writeln!(out, "{}", serde_json::to_string(candidate)?)?;
        }
    } else {
        out.write_all(page(&candidates, Reader::of_stdout()).as_bytes())?;
    }
    Ok(Outcome::Done)
}

fn ranked(ids: usize, shape: Shape) -> Result<Vec<Candidate>, Failure> {
    let mut candidates = Vec::new();
    for name in Family::PUBLISHED {
        let family = Family::published(name)?;
        if has_shape(&family, shape) {
            candidates.push(Candidate::of(name, &family));
        }
    }
    let most = candidates.iter().map(|candidate| candidate.ids).max().unwrap_or(0);
    if ids > most {
        return Err(Failure::new(format!(
            "no published family of that shape has {ids} tags: the largest has {most}; ask for fewer, for another --shape, or search a \
             family of your own with `tagbus family generate`"
        )));
    }
    candidates.sort_by_key(|candidate| candidate.rank(ids));
    explain(&mut candidates, ids);
    Ok(candidates)
}

fn has_shape(family: &Family, shape: Shape) -> bool {
    match shape {
        Shape::Square => true,
        Shape::Circle => is_round(family.layout()),
        Shape::Hole => family.layout().hole_width() > 0,
    }
}

impl Candidate {
    fn of(name: &'static str, family: &Family) -> Candidate {
        let hamming = family.default_hamming();
        Candidate {
            family: name,
            ids: family.codes().len(),
            distance: family.distance(),
            cells: family.layout().total_width(),
            corrected_by_default: hamming,
            false_accepts_per_million_quads: family.false_accept_chance(hamming) * 1e6,
            why_not: None,
        }
    }

    fn has_too_many_false_accepts(&self) -> bool {
        self.false_accepts_per_million_quads > MOST_FALSE_ACCEPTS
    }

    /// Enough ids, then few false accepts, then large cells, then a large distance.
    fn rank(&self, ids: usize) -> (bool, bool, usize, Reverse<u32>) {
        (self.ids < ids, self.has_too_many_false_accepts(), self.cells, Reverse(self.distance))
    }
}

/// Tells of each but the first what puts it behind that.
fn explain(candidates: &mut [Candidate], ids: usize) {
    let Some((best, others)) = candidates.split_first_mut() else { return };
    for other in others {
        let why = if other.ids < ids {
            format!("has {} tags only", other.ids)
        } else if other.has_too_many_false_accepts() && !best.has_too_many_false_accepts() {
            format!("chance makes {:.0} tags of a million quads", other.false_accepts_per_million_quads)
        } else if other.cells > best.cells {
            format!("{} cells instead of {} across the same print: seen less far", other.cells, best.cells)
        } else {
            format!("tags differ in {} bits, not {}", other.distance, best.distance)
        };
        other.why_not = Some(why);
    }
}

fn page(candidates: &[Candidate], reader: Reader) -> String {
    let mut lines = Vec::new();
    for candidate in candidates {
        let Candidate { family, ids, distance, cells, corrected_by_default, .. } = candidate;
        let accepts = candidate.false_accepts_per_million_quads;
        match &candidate.why_not {
            None => lines.extend([
                format!("{}: {ids} tags, {distance} bits apart, {cells} cells across the print", reader.bold(family)),
                format!(
                    "  corrects {corrected_by_default} wrong bits by default; chance then makes {accepts:.2} tags of a million quads of \
                     random bits"
                ),
            ]),
            Some(why) => lines.push(format!("not {family}: {why}")),
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(ids: usize, shape: Shape) -> &'static str {
        ranked(ids, shape).unwrap()[0].family
    }

    #[test]
    fn the_best_family_has_enough_ids_and_the_shape() {
        assert_eq!(best(30, Shape::Square), "tagStandard41h12");
        assert_eq!(best(3000, Shape::Square), "tagStandard52h13");
        assert_eq!(best(60_000, Shape::Square), "tagCircle49h12");
        assert_eq!(best(5, Shape::Circle), "tagCircle49h12");
        assert_eq!(best(5, Shape::Hole), "tagCustom48h12");
    }

    #[test]
    fn the_others_are_told_with_why_not() {
        let ranked = ranked(100, Shape::Square).unwrap();
        assert_eq!(ranked.len(), Family::PUBLISHED.len());
        assert!(ranked[0].why_not.is_none() && ranked[1..].iter().all(|other| other.why_not.is_some()));
        let page = page(&ranked, Reader::Program);
        assert!(page.contains("not tag16h5: has 30 tags only"), "{page}");
    }

    #[test]
    fn an_impossible_wish_names_what_is_possible() {
        let message = ranked(70_000, Shape::Circle).unwrap_err().to_string();
        assert!(message.contains("65698"), "{message}");
    }
}
