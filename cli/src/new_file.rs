//! Files that a command makes: nothing that was there is overwritten without being asked, nothing is left half written.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What happens to a file that is there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    /// It stays, and the new one is refused.
    Keep,
    /// The new one takes its place.
    Replace,
}

/// Refuses a file that is there already and is to stay: asked before long work.
pub(crate) fn check(path: &Path, existing: Existing) -> Result<(), NewFileError> {
    match existing {
        Existing::Keep if path.symlink_metadata().is_ok() => Err(NewFileError::Exists(path.to_owned())),
        _ => Ok(()),
    }
}

/// Writes a whole file or none.
pub(crate) fn write(path: &Path, content: &[u8], existing: Existing) -> Result<(), NewFileError> {
    let failed = |error: io::Error| match error.kind() {
        io::ErrorKind::AlreadyExists if existing == Existing::Keep => NewFileError::Exists(path.to_owned()),
        _ => NewFileError::Write { path: path.to_owned(), error },
    };
    match existing {
        Existing::Keep => write_new(path, content).map_err(failed),
        Existing::Replace => replace(path, content).map_err(failed),
    }
}

fn write_new(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    // A file that was begun here is ours to take away.
    file.write_all(content).inspect_err(|_| drop(fs::remove_file(path)))
}

/// The old file stays until the new one is whole and on the disk: else the name could get there before the content.
fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::IsADirectory)?.to_string_lossy();
    // Always the same, so that one left behind by a process that was killed does not stay.
    let next = path.with_file_name(format!(".{name}.next"));
    let written =
        File::create(&next).and_then(|mut file| file.write_all(content).and_then(|()| file.sync_all()));
    written.and_then(|()| fs::rename(&next, path)).inspect_err(|_| drop(fs::remove_file(&next)))
}

/// Why a file was not written.
#[derive(Debug)]
pub(crate) enum NewFileError {
    /// It is there already.
    Exists(PathBuf),
    /// The system refuses.
    Write { path: PathBuf, error: io::Error },
}

impl fmt::Display for NewFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exists(path) => write!(
                f,
                "{} exists and is left as it is: name another --output, or say --force to replace it",
                path.display()
            ),
            Self::Write { path, error } => write!(f, "cannot write {}: {error}", path.display()),
        }
    }
}

impl std::error::Error for NewFileError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_stays_until_it_is_to_be_replaced() {
        let folder = std::env::temp_dir().join(format!("tagbus-new-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("family.toml");
        write(&path, b"first", Existing::Keep).unwrap();
        assert!(matches!(write(&path, b"second", Existing::Keep), Err(NewFileError::Exists(_))));
        assert!(check(&path, Existing::Keep).is_err() && check(&path, Existing::Replace).is_ok());
        assert_eq!(fs::read(&path).unwrap(), b"first");
        write(&path, b"second", Existing::Replace).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        let missing = folder.join("nowhere").join("family.toml");
        assert!(matches!(write(&missing, b"", Existing::Replace), Err(NewFileError::Write { .. })));
        assert!(matches!(write(&folder, b"", Existing::Replace), Err(NewFileError::Write { .. })));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "something was left");
        fs::remove_dir_all(&folder).unwrap();
    }
}
