//! The pictures of a folder, in the order of their names.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::config::Repeat;
use crate::format::FrameShape;
use crate::order;
use crate::picture::{self, PictureError, PictureReader};
use crate::source::{Damage, Filled, FrameError, FrameSource, OpenError};

/// The pictures of a folder. JPEG is decoded straight into the frame's place (0 copies), other formats go through a buffer (1 copy).
///
/// Pictures may differ in size: memory is made for the largest, and each frame says its own size.
pub(crate) struct FolderSource {
    folder: PathBuf,
    pictures: Vec<PathBuf>,
    next: usize,
    /// Frames that the present pass over the folder has brought.
    used: usize,
    largest: FrameShape,
    repeat: Repeat,
    reader: PictureReader,
}

impl FolderSource {
    /// Reads the headers of all pictures; files that are no pictures are passed over, damaged ones are noted.
    pub(crate) fn open(
        folder: &Path,
        repeat: Repeat,
        damage: &mut Damage,
    ) -> Result<FolderSource, OpenError> {
        let files = files_in_order(folder).map_err(|error| OpenError::Io { path: folder.into(), error })?;
        let all = files.len();
        let mut shapes = Vec::new();
        let mut pictures = Vec::new();
        for path in files {
            match picture::peek_size(&path) {
                Ok((width, height)) => match FrameShape::grey(width, height) {
                    Ok(shape) => {
                        shapes.push(shape);
                        pictures.push(path);
                    }
                    Err(error) => damage.note(format_args!("{}: {error}", path.display())),
                },
                Err(PictureError::NotAPicture { .. }) => {}
                Err(error) => damage.note(error),
            }
        }
        let Some(largest) = shapes.into_iter().max_by_key(|shape| shape.bytes()) else {
            return Err(OpenError::NoPictures { path: folder.into(), other_files: all });
        };
        let reader = PictureReader::default();
        Ok(FolderSource { folder: folder.into(), pictures, next: 0, used: 0, largest, repeat, reader })
    }

    fn decode(&mut self, index: usize, into: &mut [u8]) -> Result<Filled, PictureError> {
        let path = &self.pictures[index];
        let (width, height) = self.reader.open(path)?;
        let damaged = |reason| PictureError::Damaged { path: path.clone(), reason };
        let shape = FrameShape::grey(width, height).map_err(|error| damaged(error.to_string()))?;
        let place = into.get_mut(..shape.bytes()).ok_or_else(|| damaged(format!("has grown to {shape}")))?;
        let copies = self.reader.decode(place)?;
        Ok(Filled { shape, copies })
    }

    /// Index of the next picture, from the first again after the last if the folder is looped.
    fn advance(&mut self, damage: &Damage) -> Result<Option<usize>, FrameError> {
        if self.next == self.pictures.len() {
            if self.used == 0 {
                let reason = damage.last_reason.clone();
                return Err(FrameError::NothingUsable { path: self.folder.clone(), reason });
            }
            if self.repeat == Repeat::Once {
                return Ok(None);
            }
            (self.next, self.used) = (0, 0);
        }
        self.next += 1;
        Ok(Some(self.next - 1))
    }
}

impl FrameSource for FolderSource {
    fn largest(&self) -> FrameShape {
        self.largest
    }

    fn description(&self) -> &'static str {
        "folder of pictures"
    }

    fn next(&mut self, into: &mut [u8], damage: &mut Damage) -> Result<Option<Filled>, FrameError> {
        while let Some(index) = self.advance(damage)? {
            match self.decode(index, into) {
                Ok(filled) => {
                    self.used += 1;
                    return Ok(Some(filled));
                }
                Err(error) => damage.note(error),
            }
        }
        Ok(None)
    }
}

/// Plain files of a folder (links are followed), sorted by name with numbers by value.
fn files_in_order(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().as_encoded_bytes().to_vec();
    files.sort_by(|a, b| order::natural(&name(a), &name(b)));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;
    use image::{ExtendedColorType, ImageEncoder};

    fn pgm(width: usize, height: usize, value: u8) -> Vec<u8> {
        [format!("P5\n{width} {height}\n255\n").into_bytes(), vec![value; width * height]].concat()
    }

    fn jpeg(width: u32, height: u32, value: u8) -> Vec<u8> {
        let mut file = Vec::new();
        let pixels = vec![value; (width * height) as usize];
        let encoder = image::codecs::jpeg::JpegEncoder::new(&mut file);
        encoder.write_image(&pixels, width, height, ExtendedColorType::L8).unwrap();
        file
    }

    /// Value, width and copies of each frame.
    fn play(source: &mut FolderSource, damage: &mut Damage, limit: usize) -> Vec<(u8, u32, u8)> {
        let mut luma = vec![0; source.largest().bytes()];
        let mut frames = Vec::new();
        while frames.len() < limit {
            let Some(filled) = source.next(&mut luma, damage).unwrap() else { break };
            let used = &luma[..filled.shape.bytes()];
            assert!(used.iter().all(|value| *value == used[0]));
            frames.push((used[0], filled.shape.width(), filled.copies));
        }
        frames
    }

    #[test]
    fn pictures_of_any_size_come_in_the_order_of_their_numbers_and_other_files_are_passed_over() {
        let folder = TestFolder::new("folder");
        folder.file("f10.pgm", pgm(16, 8, 10));
        folder.file("f9.jpg", jpeg(32, 24, 9));
        folder.file("f11.png.pgm", pgm(8, 8, 11));
        folder.file("README.md", "hello");
        std::fs::create_dir(folder.path().join("f12.pgm")).unwrap();
        let mut damage = Damage::default();
        let mut source = FolderSource::open(folder.path(), Repeat::Once, &mut damage).unwrap();
        assert_eq!(source.largest(), FrameShape::grey(32, 24).unwrap());
        assert_eq!(play(&mut source, &mut damage, 9), [(9, 32, 0), (10, 16, 1), (11, 8, 1)]);
        assert_eq!(damage.count, 0);
    }

    #[test]
    fn a_loop_begins_again_and_a_single_pass_ends() {
        let folder = TestFolder::new("folder");
        folder.file("1.pgm", pgm(8, 8, 1));
        folder.file("2.pgm", pgm(8, 8, 2));
        let values = |repeat| {
            let mut damage = Damage::default();
            let mut source = FolderSource::open(folder.path(), repeat, &mut damage).unwrap();
            play(&mut source, &mut damage, 5).iter().map(|frame| frame.0).collect::<Vec<_>>()
        };
        assert_eq!(values(Repeat::Loop), [1, 2, 1, 2, 1]);
        assert_eq!(values(Repeat::Once), [1, 2]);
    }

    #[test]
    fn damaged_pictures_are_counted_when_the_folder_is_opened_or_when_their_turn_comes() {
        let folder = TestFolder::new("folder");
        folder.file("1.pgm", pgm(8, 8, 1));
        folder.file("2.jpg", &jpeg(8, 8, 2)[..10]);
        folder.file("3.pgm", &pgm(8, 8, 3)[..30]);
        folder.file("4.pgm", pgm(2, 2, 4));
        let mut damage = Damage::default();
        let mut source = FolderSource::open(folder.path(), Repeat::Once, &mut damage).unwrap();
        assert_eq!(damage.count, 2, "{}", damage.last_reason);
        assert!(
            damage.last_reason.contains("4.pgm") && damage.last_reason.contains("2x2"),
            "{}",
            damage.last_reason
        );
        assert_eq!(play(&mut source, &mut damage, 9), [(1, 8, 1)]);
        assert_eq!(damage.count, 3);
        assert!(damage.last_reason.contains("3.pgm"), "{}", damage.last_reason);
    }

    #[test]
    fn a_folder_that_loses_its_pictures_ends_with_an_error_instead_of_turning_for_ever() {
        let folder = TestFolder::new("folder");
        let picture = folder.file("1.pgm", pgm(8, 8, 1));
        let mut damage = Damage::default();
        let mut source = FolderSource::open(folder.path(), Repeat::Loop, &mut damage).unwrap();
        std::fs::remove_file(picture).unwrap();
        let error = source.next(&mut [0; 64], &mut damage).unwrap_err();
        assert!(matches!(error, FrameError::NothingUsable { .. }) && damage.count == 1, "{error}");
    }

    #[test]
    fn a_picture_that_has_grown_since_is_counted_and_passed_over() {
        let folder = TestFolder::new("folder");
        folder.file("1.pgm", pgm(8, 8, 1));
        folder.file("2.pgm", pgm(8, 8, 2));
        let mut damage = Damage::default();
        let mut source = FolderSource::open(folder.path(), Repeat::Once, &mut damage).unwrap();
        folder.file("1.pgm", pgm(80, 80, 1));
        assert_eq!(play(&mut source, &mut damage, 9), [(2, 8, 1)]);
        assert!(damage.last_reason.contains("grown to 80x80"), "{}", damage.last_reason);
    }

    #[test]
    fn a_folder_without_pictures_is_refused() {
        let folder = TestFolder::new("folder");
        folder.file("notes.txt", "hello");
        let refused = FolderSource::open(folder.path(), Repeat::Loop, &mut Damage::default());
        assert!(matches!(refused, Err(OpenError::NoPictures { other_files: 1, .. })));
    }
}
