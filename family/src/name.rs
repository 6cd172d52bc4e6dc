//! Names: finding the one that a mistyped name was meant to be.

use crate::{aruco, kalibr, published};
use std::fmt;

/// The known name that is nearest to `name` by edit distance, whatever the case; of equally near ones the last.
/// `None` only when `known` is empty.
///
/// ```
/// assert_eq!(tagbus_family::nearest_name("decimat", &["threads", "decimate"]), Some("decimate"));
/// ```
pub fn nearest_name<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let name = name.to_lowercase();
    known.iter().rev().min_by_key(|known| edit_distance(&name, &known.to_lowercase())).copied()
}

/// Letters to insert, drop or replace to get from `left` to `right` (Levenshtein), one row of the table at a time.
fn edit_distance(left: &str, right: &str) -> usize {
    let mut row: Vec<usize> = (0..=right.chars().count()).collect();
    for (line, from) in left.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = line + 1;
        for (column, to) in right.chars().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[column + 1];
            row[column + 1] = replaced.min(diagonal + 1).min(row[column] + 1);
        }
    }
    row[right.chars().count()]
}

/// Every name that [`crate::Family::published`] knows.
pub(crate) const KNOWN: [&str; 28] = {
    let (mut names, others) = ([""; 28], others());
    let mut place = 0;
    while place < names.len() {
        let first = published::NAMES.len();
        names[place] = if place < first { published::NAMES[place] } else { others[place - first] };
        place += 1;
    }
    names
};

/// The names of [`crate::Family::OTHERS`].
pub(crate) const fn others() -> [&'static str; 19] {
    let mut names = [kalibr::NAME; 19];
    let mut place = 0;
    while place < aruco::NAMES.len() {
        names[place] = aruco::NAMES[place];
        place += 1;
    }
    names
}

/// No published family has this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownFamily {
    /// The name as it was given.
    pub name: String,
    /// The known name that is nearest to it.
    pub nearest: &'static str,
    /// All names that would have been taken.
    pub known: &'static [&'static str],
}

impl UnknownFamily {
    pub(crate) fn new(name: &str, known: &'static [&'static str]) -> UnknownFamily {
        UnknownFamily { name: name.to_owned(), nearest: nearest_family(name, known), known }
    }
}

/// The nearest name, be it that the words before the numbers are missing.
fn nearest_family(name: &str, known: &[&'static str]) -> &'static str {
    let spelled = [name.to_owned(), format!("tag{name}"), format!("DICT_{name}")];
    let nearest = spelled.iter().filter_map(|name| {
        let nearest = nearest_name(name, known)?;
        Some((edit_distance(&name.to_lowercase(), &nearest.to_lowercase()), nearest))
    });
    // The list is not empty, so the fallback is never taken.
    nearest.min_by_key(|(distance, _)| *distance).map_or(published::NAMES[0], |(_, nearest)| nearest)
}

impl fmt::Display for UnknownFamily {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UnknownFamily { name, nearest, known } = self;
        write!(out, "unknown tag family {name:?}, did you mean {nearest}? known are {}", known.join(", "))
    }
}

impl std::error::Error for UnknownFamily {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distance_counts_single_letter_changes() {
        for (left, right, distance) in [
            ("", "", 0),
            ("abc", "", 3),
            ("", "ab", 2),
            ("kitten", "sitting", 3),
            ("flaw", "lawn", 2),
            ("a", "b", 1),
        ] {
            assert_eq!(edit_distance(left, right), distance, "{left} -> {right}");
            assert_eq!(edit_distance(right, left), distance, "{right} -> {left}");
        }
    }

    #[test]
    fn an_unknown_family_names_the_nearest_published_one() {
        let nearest = |name| UnknownFamily::new(name, &KNOWN).nearest;
        assert_eq!(nearest("tag36h12"), "tag36h11");
        assert_eq!(nearest("36h1"), "tag36h11");
        assert_eq!(nearest("TAGSTANDARD41H13"), "tagStandard41h12");
        assert_eq!(nearest("tagCustom48"), "tagCustom48h12");
        assert_eq!(nearest("circle21"), "tagCircle21h7");
        assert_eq!(nearest("DICT_4X4_5"), "DICT_4X4_50");
        assert_eq!(nearest("6x6_259"), "DICT_6X6_250");
        assert_eq!(UnknownFamily::new("DICT_4X4_50", &published::NAMES).known, published::NAMES);
    }

    #[test]
    fn nothing_is_near_when_nothing_is_known() {
        assert_eq!(nearest_name("anything", &[]), None);
    }
}
