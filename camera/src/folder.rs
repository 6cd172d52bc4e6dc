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
