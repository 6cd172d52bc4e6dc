//! Java classes of the tag generators.

use super::error::{ImportError, Problem};
use super::read::{Table, check_widths, from_rows};
use super::tokens::{Kind, Listed, Tokens};
use crate::layout::Layout;

const CODES: &str = "the list of codes, new long[] { ... }";

/// Reads a class. Where the codes are split over several lists (Java limits the size of a method), the lists are taken
/// one after the other.
pub(super) fn read(text: &str) -> Result<Table, ImportError> {
    let tokens = Tokens::of(text)?;
    let codes = codes(&tokens)?;
    let call = tokens.places_of("super").find(|&place| tokens.are_signs(place + 1, "("));
    let call = call.ok_or_else(|| {
        Problem::Missing { what: "super(...) with bits or layout, distance and codes" }.at(tokens.last_line)
    })?;
    let arguments = arguments(&tokens, call + 2)?;
    let distance = number_at(&tokens, arguments[1], "the least distance, a number of bits")?;
    let (layout, codes) = match tokens.number(arguments[0])? {
        Some(bit_count) => of_rows(bit_count, codes)?,
        None => of_letters(&tokens, arguments[0]..arguments[1], codes)?,
    };
    let stated_distance = Some(u32::try_from(distance.value).unwrap_or(u32::MAX));
    Ok(Table { name: class_name(&tokens), layout, codes, stated_distance, guessed_cells: 0 })
}

/// `Tag16h5` of `class Tag16h5` with its first letter small, as families are called elsewhere.
fn class_name(tokens: &Tokens) -> Option<String> {
    let family =
        tokens.places_of("TagFamily").find(|&place| place > 2 && tokens.is_word(place - 1, "extends"))?;
    let Some(Kind::Word(name)) = tokens.kind(family - 2) else { return None };
    let (first, rest) = name.split_at_checked(1)?;
    Some(first.to_lowercase() + rest)
}

fn codes(tokens: &Tokens) -> Result<Vec<Listed>, ImportError> {
    let lists = tokens.places_of("long").filter(|&place| tokens.are_signs(place + 1, "[]{"));
    let mut codes = Vec::new();
    for place in lists {
        codes.extend(tokens.list(place + 3, CODES)?);
    }
    check_count(tokens, codes.len())?;
    if codes.is_empty() {
        return Err(Problem::Missing { what: CODES }.at(tokens.last_line));
    }
    Ok(codes)
}

/// `new long[38]`, into which lists are copied, says how many codes there must be.
fn check_count(tokens: &Tokens, found: usize) -> Result<(), ImportError> {
    for place in tokens.places_of("long").filter(|&place| tokens.are_signs(place + 1, "[")) {
        match tokens.number(place + 2)? {
            Some(stated) if stated.value != found as u64 => {
                return Err(Problem::CodeCount { stated: stated.value as usize, found }.at(stated.line));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The places where the first three arguments of a call begin.
fn arguments(tokens: &Tokens, first: usize) -> Result<[usize; 3], ImportError> {
    let (mut depth, mut begins) = (0_usize, vec![first]);
    for place in first..tokens.all.len() {
        match tokens.kind(place) {
            Some(Kind::Sign('(' | '{' | '[')) => depth += 1,
            Some(Kind::Sign(')' | '}' | ']')) if depth == 0 => break,
            Some(Kind::Sign(')' | '}' | ']')) => depth -= 1,
            Some(Kind::Sign(',')) if depth == 0 => begins.push(place + 1),
            _ => {}
        }
    }
    let wanted = "three arguments: bits or layout, distance, codes";
    let found = || format!("super with {} arguments", begins.len());
    begins[..].try_into().map_err(|_| Problem::Unexpected { found: found(), wanted }.at(tokens.line(first)))
}

fn number_at(tokens: &Tokens, place: usize, wanted: &'static str) -> Result<Listed, ImportError> {
    let refused = || Problem::Missing { what: wanted }.at(tokens.line(place));
    tokens.number(place)?.ok_or_else(refused)
}

/// The old generators: a square number of bits, row after row.
fn of_rows(bit_count: Listed, codes: Vec<Listed>) -> Result<(Layout, Vec<Listed>), ImportError> {
    let refused =
        || Problem::Number { text: bit_count.value.to_string(), wanted: "4, 9, 16, 25, 36, 49 or 64 bits" };
    let width = (2..=8).find(|width| (width * width) as u64 == bit_count.value);
    let width = width.ok_or_else(|| refused().at(bit_count.line))?;
    let layout = Layout::classic(width + 4).map_err(|error| Problem::Layout(error).at(bit_count.line))?;
    let codes = from_rows(codes, &layout)?;
    Ok((layout, codes))
}

/// The newer generator: the letters of the layout, and codes in the order of its bits.
fn of_letters(
    tokens: &Tokens,
    mut argument: std::ops::Range<usize>,
    codes: Vec<Listed>,
) -> Result<(Layout, Vec<Listed>), ImportError> {
    let line = tokens.line(argument.start);
    let letters = argument.rfind(|&place| matches!(tokens.kind(place), Some(Kind::Text(_))));
    let Some(Kind::Text(letters)) = letters.and_then(|place| tokens.kind(place)) else {
        return Err(Problem::Missing { what: "the letters of the layout in quotes" }.at(line));
    };
    let layout = Layout::parse(letters).map_err(|error| Problem::Layout(error).at(line))?;
    check_widths(&codes, layout.bit_count())?;
    Ok((layout, codes))
}
