//! Which pictures are meant: those that are named, and those in the folders that are named.

use std::fs;
use std::path::{Path, PathBuf};

use tagbus_camera::order::natural;

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
    found.sort_by(|a, b| natural(a.as_os_str().as_encoded_bytes(), b.as_os_str().as_encoded_bytes()));
    Ok(found)
}

fn is_picture(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) && path.is_file()
}
