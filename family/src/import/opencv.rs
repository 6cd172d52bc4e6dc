//! Dictionaries of OpenCV, as `cv::aruco::Dictionary::writeDictionary` writes them.

use super::error::{ImportError, Problem};
use super::read::{Table, from_rows};
use super::tokens::Listed;
use crate::layout::Layout;

/// More markers than any dictionary has.
const MOST_MARKERS: u64 = 1 << 20;

/// A line `key: value` without quotes and commas.
struct Entry<'a> {
    key: &'a str,
    value: &'a str,
    line: usize,
}

/// Reads YAML or JSON of one entry a line; what is not about markers is skipped.
pub(super) fn read(text: &str) -> Result<Table, ImportError> {
    let entries: Vec<Entry<'_>> = text.lines().zip(1..).filter_map(entry).collect();
    let last_line = text.lines().count().max(1);
    let find = |key| entries.iter().find(|entry| entry.key == key);
    let size = find("markersize").ok_or_else(|| Problem::Missing { what: "markersize" }.at(last_line))?;
    let count = find("nmarkers").ok_or_else(|| Problem::Missing { what: "nmarkers" }.at(last_line))?;
    let width = number(size, 2..=8, "a number of cells from 2 to 8")?;
    let layout = Layout::classic(width + 4).map_err(|error| Problem::Layout(error).at(size.line))?;
    let rows =
        markers(&entries, width * width, number(count, 1..=MOST_MARKERS, "a number of markers")?, last_line)?;
    let stated =
        find("maxCorrectionBits").map(|bits| number(bits, 0..=64, "a number of bits")).transpose()?;
    Ok(Table {
        name: None,
        codes: from_rows(rows, &layout)?,
        layout,
        // The least distance that bears what the dictionary says can be corrected.
        stated_distance: stated.map(|bits| 2 * bits as u32 + 1),
        guessed_cells: 0,
    })
}

fn entry((text, line): (&str, usize)) -> Option<Entry<'_>> {
    let (key, value) = text.split_once(':')?;
    let around = |letter: char| letter.is_whitespace() || "\"',{}".contains(letter);
    Some(Entry { key: key.trim_matches(around), value: value.trim_matches(around), line })
}

fn number(
    entry: &Entry<'_>,
    allowed: std::ops::RangeInclusive<u64>,
    wanted: &'static str,
) -> Result<usize, ImportError> {
    let value = entry.value.parse().ok().filter(|value| allowed.contains(value));
    let refused = || Problem::Number { text: format!("{} {:?}", entry.key, entry.value), wanted };
    value.map(|value: u64| value as usize).ok_or_else(|| refused().at(entry.line))
}

/// The markers by id, which may stand in any order.
fn markers(
    entries: &[Entry<'_>],
    bit_count: usize,
    count: usize,
    last_line: usize,
) -> Result<Vec<Listed>, ImportError> {
    let mut rows: Vec<Option<Listed>> = vec![None; count];
    let mut found = 0;
    for entry in entries {
        let Some(id) = entry.key.strip_prefix("marker_") else { continue };
        let wanted = "the number of a marker below nmarkers";
        let refused = || Problem::Number { text: entry.key.to_owned(), wanted }.at(entry.line);
        let id: usize = id.parse().map_err(|_| refused())?;
        let place = rows.get_mut(id).ok_or_else(refused)?;
        if place.replace(marker(entry, id, bit_count)?).is_some() {
            let wanted = "a marker that was not there before";
            return Err(Problem::Unexpected { found: entry.key.to_owned(), wanted }.at(entry.line));
        }
        found += 1;
    }
    let all: Option<Vec<Listed>> = rows.into_iter().collect();
    all.ok_or_else(|| Problem::CodeCount { stated: count, found }.at(last_line))
}

fn marker(entry: &Entry<'_>, id: usize, bit_count: usize) -> Result<Listed, ImportError> {
    let is_right =
        entry.value.len() == bit_count && entry.value.bytes().all(|bit| matches!(bit, b'0' | b'1'));
    let value = u64::from_str_radix(entry.value, 2).ok().filter(|_| is_right);
    let value = value.ok_or_else(|| Problem::Marker { id, bit_count }.at(entry.line))?;
    Ok(Listed { value, line: entry.line })
}
