//! Writes the data file of a published family from a table of its codes.

use std::process::ExitCode;
use tagbus_family::Recipe;
use tagbus_family::published;

const USAGE: &str = "\
usage: pack FAMILY TABLE OUTPUT

Packs the codes of a published family, as the crate embeds them.
  FAMILY  the name, such as tag36h11
  TABLE   a text file with one hexadecimal code a line by id; lines that begin with # are skipped
  OUTPUT  the file to write, such as family/data/tag36h11.bin

Only as many codes are packed as the family's recipe says.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [family, table, output] = arguments.as_slice() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    match pack(family, table, output) {
        Ok(summary) => {
            println!("{summary}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("pack: {message}");
            ExitCode::from(2)
        }
    }
}

fn pack(family: &str, table: &str, output: &str) -> Result<String, String> {
    let published = published::named(family).map_err(|error| error.to_string())?;
    let recipe = published.recipe().map_err(|error| error.to_string())?;
    let text = std::fs::read_to_string(table).map_err(|error| format!("cannot read {table}: {error}"))?;
    let codes = read_codes(&text, published.count).map_err(|message| format!("{table}: {message}"))?;
    let packed = published::pack(&candidate_numbers(&recipe, &codes)?);
    std::fs::write(output, &packed).map_err(|error| format!("cannot write {output}: {error}"))?;
    Ok(format!("{}: {} codes in {} bytes", published.name, codes.len(), packed.len()))
}

fn read_codes(text: &str, count: usize) -> Result<Vec<u64>, String> {
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with('#');
    let read = |line| {
        u64::from_str_radix(line, 16).map_err(|error| format!("{line:?} is no hexadecimal code: {error}"))
    };
    let codes: Vec<u64> =
        text.lines().map(str::trim).filter(is_code).take(count).map(read).collect::<Result<_, _>>()?;
    match codes.len() {
        found if found == count => Ok(codes),
        found => Err(format!("{found} codes found, the family has {count}")),
    }
}

/// The places of the codes in the candidate sequence, which must increase: else the table is not in the order of its
/// ids, has its bits in another order, or belongs to another family.
fn candidate_numbers(recipe: &Recipe, codes: &[u64]) -> Result<Vec<u64>, String> {
    let candidates = recipe.candidates();
    let number = |&code: &u64| candidates.number(recipe.to_candidate(code));
    let numbers: Vec<u64> = codes.iter().map(number).collect();
    match numbers.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(id) => {
            let (earlier, later) = (numbers[id], numbers[id + 1]);
            Err(format!(
                "code {} is candidate {later}, not after candidate {earlier} of the code before",
                id + 1
            ))
        }
        None => Ok(numbers),
    }
}
