//! `tagbus family explain`: one tag, cell by cell and bit by bit.

use std::io::{self, Write};

use serde::Serialize;
use tagbus_family::{Family, Grid, Paint};

use super::draw;
use crate::outcome::{Failure, Outcome};
use crate::output::Reader;

#[derive(Serialize)]
struct Explained<'a> {
    family: &'a str,
    id: u32,
    bits: u32,
    code: String,
    /// The code as it is read when the tag is turned counter-clockwise by 90, 180 and 270 degrees.
    rotations: [String; 3],
    /// Rows of the print: w white, b black, x not painted.
    cells: Vec<String>,
    /// Column and row of each bit in the print, most significant bit first.
    places: Vec<[i32; 2]>,
}

/// Writes the tag, or a line of JSON.
pub(super) fn execute(family: &Family, id: u32, json: bool) -> Result<Outcome, Failure> {
    let count = family.codes().len();
    let missing = || {
        Failure::new(format!("{} has no id {id}: it has {count} tags, ids 0 to {}", family.name(), count - 1))
    };
    let grid = family.grid(id).ok_or_else(missing)?;
    let codes = turned_codes(family, id);
    let mut out = io::stdout().lock();
    if json {
        writeln!(out, "{}", serde_json::to_string(&explained(family, id, &grid, codes))?)?;
    } else {
        out.write_all(page(family, id, &grid, &codes, Reader::of_stdout()).as_bytes())?;
    }
    Ok(Outcome::Done)
}

/// The code and its three rotations in hexadecimal, as many digits as the bits take.
fn turned_codes(family: &Family, id: u32) -> [String; 4] {
    let digits = family.layout().bit_count().div_ceil(4) as usize;
    let mut code = family.codes()[id as usize];
    std::array::from_fn(|turn| {
        if turn > 0 {
            code = family.layout().rotate90(code);
        }
        format!("0x{code:0digits$x}")
    })
}

fn explained<'a>(family: &'a Family, id: u32, grid: &Grid, codes: [String; 4]) -> Explained<'a> {
    let layout = family.layout();
    let margin = layout.margin() as i32;
    let [code, rotations @ ..] = codes;
    Explained {
        family: family.name(),
        id,
        bits: layout.bit_count(),
        code,
        rotations,
        cells: grid.rows().map(|row| row.iter().map(|paint| letter(*paint)).collect()).collect(),
        places: layout.bits().iter().map(|[x, y]| [x + margin, y + margin]).collect(),
    }
}

fn letter(paint: Paint) -> char {
    match paint {
        Paint::White => 'w',
        Paint::Black => 'b',
        Paint::Clear => 'x',
    }
}

fn page(family: &Family, id: u32, grid: &Grid, codes: &[String; 4], reader: Reader) -> String {
    let name = reader.bold(&format!("{} {id}", family.name()));
    let mut lines = vec![name, String::new()];
    lines.extend(draw::tag(grid).iter().map(|line| format!("  {}", reader.white_on_black(line))));
    lines.extend([String::new(), "bits, 0 being the most significant (1 is white):".to_owned()]);
    lines.extend(draw::numbered(family.layout()).into_iter().map(|row| format!(" {row}")));
    lines.push(reader.faint("  ## black   .. white   blank: not part of the tag"));
    lines.extend([String::new(), format!("code {} ({} bits)", codes[0], family.layout().bit_count())]);
    lines.push(format!("turned counter-clockwise by 90, 180, 270 degrees: {}", codes[1..].join(", ")));
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_quarter_turns_lead_back_to_the_code() {
        let family = Family::published("tag36h11").unwrap();
        let codes = turned_codes(&family, 7);
        let last = u64::from_str_radix(&codes[3][2..], 16).unwrap();
        assert_eq!(family.layout().rotate90(last), family.codes()[7]);
        assert!(codes.iter().all(|code| code.len() == 2 + 9), "{codes:?}");
    }

    #[test]
    fn white_cells_are_the_ones_of_the_code() {
        let family = Family::published("tagStandard41h12").unwrap();
        let grid = family.grid(9).unwrap();
        let explained = explained(&family, 9, &grid, turned_codes(&family, 9));
        let read = explained.places.iter().fold(0, |code, [x, y]| {
            let letter = explained.cells[*y as usize].as_bytes()[*x as usize];
            code << 1 | u64::from(letter == b'w')
        });
        assert_eq!(read, family.codes()[9]);
    }
}
