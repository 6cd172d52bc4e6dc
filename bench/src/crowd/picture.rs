//! A picture for a camera that plays it again and again.

use std::fs;
use std::io;
use std::path::PathBuf;

use tagbus_camera::picture::Picture;

/// The grey of a picture without anything.
const GREY: u8 = 120;

/// A picture as a PGM file, which is removed when this is dropped.
pub(crate) struct PlayedPicture(PathBuf);

impl PlayedPicture {
    /// Writes it into the temporary directory, under the name of a machine.
    pub(crate) fn write(name: &str, picture: &Picture) -> io::Result<Self> {
        let path = std::env::temp_dir().join(format!("{name}.pgm"));
        let mut file = format!("P5\n{} {}\n255\n", picture.width, picture.height).into_bytes();
        file.extend_from_slice(&picture.luma);
        fs::write(&path, file)?;
        Ok(Self(path))
    }

    /// A picture without anything.
    pub(crate) fn write_empty(name: &str, [width, height]: [usize; 2]) -> io::Result<Self> {
        Self::write(name, &Picture { width, height, luma: vec![GREY; width * height] })
    }

    /// The flag by which a camera plays it.
    pub(crate) fn source(&self) -> String {
        format!("--source=replay:{}", self.0.display())
    }
}

impl Drop for PlayedPicture {
    fn drop(&mut self) {
        // What is not there any more need not be removed.
        let _ = fs::remove_file(&self.0);
    }
}
