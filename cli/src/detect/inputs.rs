//! Which pictures are meant: those that are named, and those in the folders that are named.

use std::fs;
use std::path::{Path, PathBuf};

/// What names of pictures end with.
const ENDINGS: [&str; 8] = ["jpg", "jpeg", "png", "bmp", "pnm", "pgm", "ppm", "pbm"];

/// All pictures in order, and what is wrong with inputs that have none.
pub(super) fn pictures(inputs: &[PathBuf]) -> (Vec<PathBuf>, Vec<String>) {
    let (mut pictures, mut refused) = (Vec::new(), Vec::new());
    for input in inputs {
        if !input.is_dir() {
            pictures.push(input.clone());
            continue;
        }
        match of_folder(input) {
            Ok(found) if found.is_empty() => {
                refused.push(format!(
                    "{}: no pictures in this folder ({})",
                    input.display(),
                    ENDINGS.join(", ")
                ));
            }
            Ok(found) => pictures.extend(found),
            Err(error) => refused.push(format!("{}: cannot be read: {error}", input.display())),
        }
    }
    (pictures, refused)
}

fn of_folder(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if is_picture(&path) {
            found.push(path);
        }
    }
    found.sort_by_cached_key(|path| natural_key(&path.to_string_lossy()));
    Ok(found)
}

fn is_picture(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) && path.is_file()
}

/// A key by which `frame2` comes before `frame10`: texts and the numbers that follow them, in turn. A number is
/// compared by its length without leading zeros and then by its digits, so that it may have any length.
fn natural_key(name: &str) -> Vec<(String, usize, String)> {
    let mut key = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits_at = rest.find(|letter: char| letter.is_ascii_digit()).unwrap_or(rest.len());
        let (text, from_digits) = rest.split_at(digits_at);
        let digits_end =
            from_digits.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(from_digits.len());
        let (digits, after) = from_digits.split_at(digits_end);
        let number = digits.trim_start_matches('0');
        key.push((text.to_owned(), number.len(), number.to_owned()));
        rest = after;
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_by_their_value() {
        let mut names =
            ["f10.png", "f9.png", "f010b.png", "a20", "a3", "f9a.png", "f99999999999999999999999.png"];
        names.sort_by_cached_key(|name| natural_key(name));
        assert_eq!(
            names,
            ["a3", "a20", "f9.png", "f9a.png", "f10.png", "f010b.png", "f99999999999999999999999.png"]
        );
    }

    #[test]
    fn pictures_are_told_by_the_ends_of_their_names() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(!is_picture(&here.join("Cargo.toml")) && !is_picture(&here.join("src")));
        let (pictures, refused) = pictures(&[here.join("src"), "missing.png".into()]);
        assert_eq!(pictures, [PathBuf::from("missing.png")]);
        assert!(refused[0].contains("no pictures in this folder"), "{refused:?}");
    }
}
