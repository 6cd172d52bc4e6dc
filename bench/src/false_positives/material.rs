//! Pictures without tags, by the place that they show.

use std::path::{Path, PathBuf};

use image::GrayImage;
use serde_json::Value;
use tagbus_camera::picture::load_grey;

use crate::sweep::pictures_in;

type Failure = Box<dyn std::error::Error>;

/// Fewer places than this give no interval worth the name.
const LEAST_PLACES: usize = 5;

/// Everything that is looked at.
#[derive(Debug)]
pub(super) struct Material {
    /// Pictures of one place, or of one board, belong together.
    pub(super) places: Vec<Vec<GrayImage>>,
    /// Names of pictures that hold codes.
    pub(super) left_out: Vec<String>,
}

/// All pictures of these folders but those that hold codes of some family: a `manifest.json` beside a folder says so by
/// `families` and `ignore_families`. Pictures whose names begin with the same of the words `same_place` belong together, every
/// other is a place of its own.
///
/// # Errors
/// Folders and pictures that cannot be read, words with which no name begins, too few places.
pub(super) fn load(folders: &[PathBuf], same_place: &[String]) -> Result<Material, Failure> {
    let mut material = Material { places: Vec::new(), left_out: Vec::new() };
    let mut place_of_word = vec![None; same_place.len()];
    for folder in folders {
        let with_codes = files_with_codes(folder)?;
        for path in pictures_in(folder)? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if with_codes.contains(&name) {
                material.left_out.push(name);
                continue;
            }
            let word = same_place.iter().position(|word| name.starts_with(word.as_str()));
            let known = word.and_then(|word| place_of_word[word]);
            let place = known.unwrap_or(material.places.len());
            if place == material.places.len() {
                material.places.push(Vec::new());
            }
            material.places[place].push(picture(&path)?);
            if let Some(word) = word {
                place_of_word[word] = Some(place);
            }
        }
    }
    checked(material, same_place, &place_of_word)
}

fn checked(material: Material, same_place: &[String], used: &[Option<usize>]) -> Result<Material, Failure> {
    if let Some((word, _)) = same_place.iter().zip(used).find(|(_, place)| place.is_none()) {
        return Err(format!(
            "no picture's name begins with \"{word}\": correct --same-place or leave it out"
        )
        .into());
    }
    match material.places.len() {
        LEAST_PLACES.. => Ok(material),
        places => Err(format!(
            "these are pictures of {places} places: intervals come from drawing places anew and need at least {LEAST_PLACES}"
        )
        .into()),
    }
}

fn picture(path: &Path) -> Result<GrayImage, Failure> {
    let picture = load_grey(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let grey = GrayImage::from_raw(picture.width as u32, picture.height as u32, picture.luma);
    Ok(grey.ok_or_else(|| format!("{} is damaged", path.display()))?)
}

/// Names of the files of this folder.
fn files_with_codes(folder: &Path) -> Result<Vec<String>, Failure> {
    let named = |error: &dyn std::error::Error, path: &Path| format!("{}: {error}", path.display());
    let folder = folder.canonicalize().map_err(|error| named(&error, folder))?;
    let (Some(above), Some(name)) = (folder.parent(), folder.file_name()) else { return Ok(Vec::new()) };
    let path = above.join("manifest.json");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).map_err(|error| named(&error, &path))?;
    let manifest: Value = serde_json::from_str(&text).map_err(|error| named(&error, &path))?;
    let files = manifest["files"].as_array().map(Vec::as_slice).unwrap_or_default();
    let file = |file: &Value| file["file"].as_str().map(|file| Path::new(file).to_owned());
    let files = files.iter().filter(|file| has_codes(file)).filter_map(file);
    let here = files.filter(|file| file.parent() == Some(Path::new(name)));
    Ok(here.filter_map(|file| Some(file.file_name()?.to_string_lossy().into_owned())).collect())
}

fn has_codes(file: &Value) -> bool {
    let is_filled = |key: &str| file[key].as_array().is_some_and(|names| !names.is_empty());
    is_filled("families") || is_filled("ignore_families")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two folders of pictures with a manifest beside them.
    struct Data(PathBuf);

    impl Data {
        fn new(name: &str, manifest: &str) -> Data {
            let data = Data(std::env::temp_dir().join(format!("tagbus-{name}-{}", std::process::id())));
            std::fs::create_dir_all(data.0.join("wild")).unwrap();
            std::fs::create_dir_all(data.0.join("boards")).unwrap();
            for file in [
                "wild/a.png",
                "wild/b.png",
                "wild/c.png",
                "wild/hall1.png",
                "boards/hall2.png",
                "boards/grid.png",
            ] {
                GrayImage::from_pixel(8, 6, image::Luma([9])).save(data.0.join(file)).unwrap();
            }
            std::fs::write(data.0.join("manifest.json"), manifest).unwrap();
            data
        }

        fn load(&self, same_place: &[&str]) -> Result<Material, Failure> {
            let words: Vec<String> = same_place.iter().map(|&word| word.to_owned()).collect();
            load(&[self.0.join("wild"), self.0.join("boards")], &words)
        }
    }

    impl Drop for Data {
        fn drop(&mut self) {
            // Left behind in the worst case.
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn pictures_with_codes_are_left_out_and_those_of_one_place_belong_together() {
        let manifest = r#"{"files": [{"file": "boards/grid.png", "ignore_families": ["tag36h11"]},
            {"file": "elsewhere/a.png", "families": ["tag36h11"]}, {"file": "wild/b.png", "families": []}]}"#;
        let data = Data::new("material", manifest);
        let material = data.load(&["hall"]).unwrap_err().to_string();
        assert!(material.contains("pictures of 4 places"), "{material}");
        let material = data.load(&[]).unwrap();
        assert_eq!(material.left_out, ["grid.png"]);
        assert_eq!(material.places.iter().map(Vec::len).collect::<Vec<_>>(), [1; 5]);
        let data = Data::new("material-whole", "{}");
        let material = data.load(&["hall"]).unwrap();
        assert_eq!(material.places.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1, 2, 1]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_by_name() {
        let data = Data::new("material-refused", "{}");
        let message = |result: Result<Material, Failure>| result.unwrap_err().to_string();
        assert!(message(data.load(&["hall", "attic"])).contains("\"attic\""));
        assert!(message(load(&[data.0.join("nowhere")], &[])).contains("nowhere"));
        std::fs::write(data.0.join("manifest.json"), "[").unwrap();
        assert!(message(data.load(&[])).contains("manifest.json"));
    }
}
