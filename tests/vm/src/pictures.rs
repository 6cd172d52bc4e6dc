//! The pictures that are played, and what is to be found in each.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use tagbus_scene::{Scene, SceneConfig, number};

use crate::Failure;

/// Pictures of a size; played again and again.
pub(crate) const COUNT: usize = 16;

/// Frames of the scene between two pictures, so that tags move.
const STRIDE: u64 = 11;

/// Tags whose cells are smaller than this are allowed to be missed, in pixels.
const SURE_CELL_PX: f64 = 3.0;

/// A tag that is in a picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Known {
    pub(crate) id: u32,
    pub(crate) corners: [[f64; 2]; 4],
    /// Whether it has to be found.
    pub(crate) sure: bool,
}

/// Pictures of one size with their truth.
pub(crate) struct Pictures {
    pub(crate) width: usize,
    pub(crate) height: usize,
    luma: Vec<u8>,
    truth: Vec<Vec<Known>>,
}

/// Reads `640x480`.
pub(crate) fn sides(size: &str) -> Result<(usize, usize), Failure> {
    let (width, height) = size.split_once('x').ok_or("a size looks like 640x480")?;
    Ok((width.parse()?, height.parse()?))
}

fn file(folder: &str, size: &str, kind: &str) -> PathBuf {
    Path::new(folder).join(format!("{size}.{kind}"))
}

/// Writes the pictures of a size and their truth into `folder`.
pub(crate) fn paint(size: &str, folder: &str) -> Result<(), Failure> {
    let (width, height) = sides(size)?;
    let families = vec!["tag36h11".to_string(); 5];
    let scene = Scene::new(SceneConfig { width, height, families, ..SceneConfig::default() })?;
    let (mut luma, mut truth) = (vec![0; COUNT * width * height], String::new());
    for (picture, luma) in luma.chunks_exact_mut(width * height).enumerate() {
        scene.render(picture as u64 * STRIDE, luma);
        number::write(luma, width, picture as u8);
        for tag in scene.truth(picture as u64 * STRIDE) {
            let hidden = tag
                .corners
                .iter()
                .any(|&[x, y]| x < number::AREA.0 as f64 + 8.0 && y < number::AREA.1 as f64 + 8.0);
            let sure = tag.visible && !hidden && tag.cell_px >= SURE_CELL_PX;
            write!(truth, "{picture} {} {}", tag.id, u8::from(sure))?;
            tag.corners.iter().flatten().try_for_each(|value| write!(truth, " {value:.4}"))?;
            truth.push('\n');
        }
    }
    fs::create_dir_all(folder)?;
    fs::write(file(folder, size, "grey"), luma)?;
    fs::write(file(folder, size, "truth"), truth)?;
    Ok(())
}

impl Pictures {
    /// Reads what [`paint`] wrote.
    pub(crate) fn read(size: &str, folder: &str) -> Result<Pictures, Failure> {
        let (width, height) = sides(size)?;
        let luma = fs::read(file(folder, size, "grey"))?;
        let mut truth = vec![Vec::new(); COUNT];
        for line in fs::read_to_string(file(folder, size, "truth"))?.lines() {
            let (picture, known) = parse(line).ok_or_else(|| format!("no truth: {line}"))?;
            truth.get_mut(picture).ok_or("a picture too many")?.push(known);
        }
        Ok(Pictures { width, height, luma, truth })
    }

    /// The luma of a picture, row after row.
    pub(crate) fn luma(&self, picture: usize) -> &[u8] {
        let bytes = self.width * self.height;
        &self.luma[picture * bytes..][..bytes]
    }

    /// What is to be found in a picture.
    pub(crate) fn truth(&self, picture: usize) -> &[Known] {
        &self.truth[picture]
    }
}

fn parse(line: &str) -> Option<(usize, Known)> {
    let numbers: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
    let [picture, id, sure, rest @ ..] = numbers.as_slice() else { return None };
    let values: [f64; 8] = rest.try_into().ok()?;
    let corners = [0, 2, 4, 6].map(|at| [values[at], values[at + 1]]);
    Some((*picture as usize, Known { id: *id as u32, corners, sure: *sure == 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_and_truth_come_back_and_most_tags_are_sure() {
        let folder = std::env::temp_dir().join(format!("tagbus-vm-{}", std::process::id()));
        let folder = folder.to_str().unwrap();
        paint("320x240", folder).unwrap();
        let pictures = Pictures::read("320x240", folder).unwrap();
        fs::remove_dir_all(folder).unwrap();
        for picture in 0..COUNT {
            let luma = pictures.luma(picture);
            assert_eq!(number::read(|x, y| luma[y * 320 + x]), Some(picture as u8));
        }
        let all: Vec<_> = (0..COUNT).flat_map(|picture| pictures.truth(picture)).collect();
        let sure = all.iter().filter(|known| known.sure).count();
        assert!(sure * 3 > all.len(), "{sure} of {} are sure", all.len());
    }
}
