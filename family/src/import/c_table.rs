//! C tables of the AprilTag library.

use super::cells::Places;
use super::error::{ImportError, Problem};
use super::read::{Table, check_widths, from_rows};
use super::tokens::{Kind, Listed, Tokens};
use crate::layout::Layout;
use crate::square::Border;

const CODES: &str = "the list of codes, codedata[] = { ... }";
/// More bits and cells than any table can have, so that numbers can be cut to it.
const MOST: i64 = 1 << 16;

/// Reads a table of the library or of its second version, which has `d` and `black_border` instead of places of bits.
pub(super) fn read(text: &str) -> Result<Table, ImportError> {
    let source = Source { tokens: Tokens::of(text)? };
    let stated_distance = source.optional("h")?.map(|distance| distance.value.clamp(0, MOST) as u32);
    let table = Table { name: source.name(), stated_distance, ..source.places_or_rows()? };
    source.check_count(table.codes.len())?;
    Ok(table)
}

struct Source {
    tokens: Tokens,
}

/// A value that is assigned, with its line.
#[derive(Clone, Copy)]
struct Assigned {
    value: i64,
    line: usize,
}

impl Source {
    fn missing(&self, what: &'static str) -> ImportError {
        Problem::Missing { what }.at(self.tokens.last_line)
    }

    /// The text of `name = strdup("tag36h11")`.
    fn name(&self) -> Option<String> {
        let name = self.tokens.places_of("name").find(|&place| self.tokens.are_signs(place + 1, "="))?;
        let end = (name..self.tokens.all.len()).find(|&place| self.tokens.are_signs(place, ";"))?;
        (name..end).find_map(|place| match self.tokens.kind(place) {
            Some(Kind::Text(text)) => Some(text.clone()),
            _ => None,
        })
    }

    fn places_or_rows(&self) -> Result<Table, ImportError> {
        if self.optional("black_border")?.is_some() { self.rows() } else { self.places() }
    }

    fn places(&self) -> Result<Table, ImportError> {
        let total_width = self.cells("total_width")?;
        let width_at_border = self.cells("width_at_border")?;
        let line = total_width.line;
        let (total_width, width_at_border) = (total_width.value as usize, width_at_border.value as usize);
        if width_at_border >= total_width || (total_width - width_at_border) % 2 == 1 {
            let text = format!("width_at_border {width_at_border} in total_width {total_width}");
            return Err(Problem::Number { text, wanted: "smaller by an even number of cells" }.at(line));
        }
        let border = match self.optional("reversed_border")? {
            Some(Assigned { value: 1, .. }) => Border::Reversed,
            _ => Border::Normal,
        };
        let places = Places { total_width, width_at_border, border, bits: self.bits()?, line };
        let cells = places.cells()?;
        let codes = self.codes()?;
        check_widths(&codes, cells.layout.bit_count())?;
        let codes = reorder(codes, &places.bits, &cells.layout);
        Ok(Table {
            name: None,
            layout: cells.layout,
            codes,
            stated_distance: None,
            guessed_cells: cells.guessed,
        })
    }

    /// AprilTag 2: `d * d` bits row after row inside a black border of one or more cells.
    fn rows(&self) -> Result<Table, ImportError> {
        let (width, border) = (self.cells("d")?, self.cells("black_border")?);
        let layout = square_inside(width.value as usize, border.value as usize);
        let layout = layout.map_err(|error| Problem::Layout(error).at(width.line))?;
        let codes = from_rows(self.codes()?, &layout)?;
        Ok(Table { name: None, layout, codes, stated_distance: None, guessed_cells: 0 })
    }

    /// A number of cells, of which there cannot be many.
    fn cells(&self, name: &'static str) -> Result<Assigned, ImportError> {
        let cells = self.optional(name)?.ok_or_else(|| self.missing(name))?;
        let refused = || Problem::Number {
            text: format!("{name} = {}", cells.value),
            wanted: "a number of cells from 1 to 64",
        };
        if (1..=64).contains(&cells.value) { Ok(cells) } else { Err(refused().at(cells.line)) }
    }

    /// The number that is assigned to a name, if one is: `tf->h = 11;`.
    fn optional(&self, name: &str) -> Result<Option<Assigned>, ImportError> {
        for place in self.tokens.places_of(name).filter(|&place| self.tokens.are_signs(place + 1, "=")) {
            if let Some(value) = self.value(place + 2)? {
                return Ok(Some(value));
            }
        }
        Ok(None)
    }

    /// The number at a place: with a sign, true or false, with a cast before it.
    fn value(&self, mut place: usize) -> Result<Option<Assigned>, ImportError> {
        let tokens = &self.tokens;
        if tokens.are_signs(place, "(") && tokens.are_signs(place + 2, ")") {
            place += 3;
        }
        let line = tokens.line(place);
        for (word, value) in [("true", 1), ("false", 0)] {
            if tokens.is_word(place, word) {
                return Ok(Some(Assigned { value, line }));
            }
        }
        let negative = tokens.are_signs(place, "-");
        let number = tokens.number(place + usize::from(negative))?;
        Ok(number.map(|Listed { value, line }| {
            let value = signed(value);
            Assigned { value: if negative { -value } else { value }, line }
        }))
    }

    /// `codedata[] = { ... }`, else the first list that is none of places; AprilTag 2 has `codes[0] = ...`.
    fn codes(&self) -> Result<Vec<Listed>, ImportError> {
        let begins = self.lists();
        let named = begins.iter().find(|(name, _)| name == "codedata");
        let other = || begins.iter().find(|(name, _)| name != "bit_x" && name != "bit_y");
        match named.or_else(other) {
            Some(&(_, begin)) => self.tokens.list(begin, CODES),
            None => self.elements("codes", |place| {
                let number = self.tokens.number(place)?;
                number.ok_or_else(|| {
                    Problem::Missing { what: "the value of a code" }.at(self.tokens.line(place))
                })
            }),
        }
        .and_then(|codes| if codes.is_empty() { Err(self.missing(CODES)) } else { Ok(codes) })
    }

    /// The lists `name[..] = { ... }`: name and place of the brace.
    fn lists(&self) -> Vec<(String, usize)> {
        let list = |place: usize| {
            let Some(Kind::Word(name)) = self.tokens.kind(place) else { return None };
            let closed = [2, 3].map(|ahead| place + ahead);
            let close = closed.into_iter().find(|&close| self.tokens.are_signs(close, "]={"))?;
            self.tokens.are_signs(place + 1, "[").then(|| (name.clone(), close + 2))
        };
        (0..self.tokens.all.len()).filter_map(list).collect()
    }

    /// The elements `name[0] = ..; name[1] = ..;`, which must come in their order.
    fn elements<T>(
        &self,
        name: &str,
        read: impl Fn(usize) -> Result<T, ImportError>,
    ) -> Result<Vec<T>, ImportError> {
        let mut elements = Vec::new();
        for place in self.tokens.places_of(name) {
            let Some((index, value)) = self.tokens.element(place)? else { continue };
            if index != elements.len() as u64 {
                let (found, wanted) = (format!("{name}[{index}]"), "the element after the one before");
                return Err(Problem::Unexpected { found, wanted }.at(self.tokens.line(place)));
            }
            elements.push(read(value)?);
        }
        Ok(elements)
    }

    /// The places of the bits.
    fn bits(&self) -> Result<Vec<[i64; 2]>, ImportError> {
        let (x, y) = (self.coordinates("bit_x")?, self.coordinates("bit_y")?);
        let stated = self.optional("nbits")?;
        let stated = stated.unwrap_or(Assigned { value: x.len() as i64, line: self.tokens.last_line });
        if [x.len(), y.len()].iter().any(|&count| count as i64 != stated.value) {
            let found = format!("bit_x of {} bits and bit_y of {}", x.len(), y.len());
            return Err(Problem::Unexpected { found, wanted: "both as many as nbits" }.at(stated.line));
        }
        if x.is_empty() {
            return Err(self.missing("bit_x and bit_y"));
        }
        Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
    }

    fn coordinates(&self, name: &'static str) -> Result<Vec<i64>, ImportError> {
        match self.lists().into_iter().find(|(list, _)| list == name) {
            Some((_, begin)) => {
                let list = self.tokens.list(begin, "the places of the bits")?;
                Ok(list.into_iter().map(|listed| signed(listed.value)).collect())
            }
            None => self.elements(name, |place| {
                let value = self.value(place)?.map(|assigned| assigned.value);
                value.ok_or_else(|| {
                    Problem::Missing { what: "the place of a bit" }.at(self.tokens.line(place))
                })
            }),
        }
    }

    /// `codedata[587]` and `ncodes = 587` both say how many codes there must be: C fills up with zeros.
    fn check_count(&self, found: usize) -> Result<(), ImportError> {
        let mut stated: Vec<Assigned> = self.optional("ncodes")?.into_iter().collect();
        for (_, begin) in self.lists().iter().filter(|(name, _)| name == "codedata") {
            stated.extend(self.value(begin - 3)?);
        }
        match stated.iter().find(|stated| stated.value != found as i64) {
            Some(&Assigned { value, line }) => {
                Err(Problem::CodeCount { stated: usize::try_from(value).unwrap_or(0), found }.at(line))
            }
            None => Ok(()),
        }
    }
}

/// Places before the border are negative, and some tables write them as unsigned numbers of 32 or 64 bits.
fn signed(value: u64) -> i64 {
    u32::try_from(value).map_or(value as i64, |value| i64::from(value as i32)).clamp(-MOST, MOST)
}

/// White ring, black rings, and a square of bits.
fn square_inside(width: usize, black_border: usize) -> Result<Layout, crate::LayoutError> {
    let total = width + 2 * black_border + 2;
    let letter = |place: usize| {
        let [x, y] = [place % total, place / total];
        match x.min(y).min(total - 1 - x).min(total - 1 - y) {
            0 => 'w',
            ring if ring <= black_border => 'b',
            _ => 'd',
        }
    };
    crate::square::check_width(total)?;
    Layout::parse(&(0..total * total).map(letter).collect::<String>())
}

/// The codes with their bits in the order of [`Layout::bits`]; `bits` are the same places in another.
fn reorder(codes: Vec<Listed>, bits: &[[i64; 2]], layout: &Layout) -> Vec<Listed> {
    let place = |at: &[i32; 2]| bits.iter().rev().position(|bit| *bit == at.map(i64::from));
    // All are found: the layout was made of them.
    let places: Vec<usize> = layout.bits().iter().filter_map(place).collect();
    let ours = |code: u64| places.iter().fold(0, |ours, place| ours << 1 | code >> place & 1);
    codes.into_iter().map(|code| Listed { value: ours(code.value), ..code }).collect()
}
