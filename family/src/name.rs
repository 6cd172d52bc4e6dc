//! Names: finding the one that a mistyped name was meant to be.

use crate::published;
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

/// No published family has this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownFamily {
    /// The name as it was given.
    pub name: String,
    /// The published name that is nearest to it.
    pub nearest: &'static str,
}

impl UnknownFamily {
    pub(crate) fn new(name: &str) -> UnknownFamily {
        let with_prefix = format!("tag{name}");
        let full_name = if name.to_lowercase().starts_with("tag") { name } else { &with_prefix };
        // The list is not empty, so the fallback is never taken.
        let nearest = nearest_name(full_name, &published::NAMES).unwrap_or(published::NAMES[0]);
        UnknownFamily { name: name.to_owned(), nearest }
    }
}

impl fmt::Display for UnknownFamily {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UnknownFamily { name, nearest } = self;
        write!(
            out,
            "unknown tag family {name:?}, did you mean {nearest}? known are {}",
            published::NAMES.join(", ")
        )
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
        let nearest = |name| UnknownFamily::new(name).nearest;
        assert_eq!(nearest("tag36h12"), "tag36h11");
        assert_eq!(nearest("36h1"), "tag36h11");
        assert_eq!(nearest("TAGSTANDARD41H13"), "tagStandard41h12");
        assert_eq!(nearest("tagCustom48"), "tagCustom48h12");
        assert_eq!(nearest("circle21"), "tagCircle21h7");
    }

    #[test]
    fn nothing_is_near_when_nothing_is_known() {
        assert_eq!(nearest_name("anything", &[]), None);
    }
}
