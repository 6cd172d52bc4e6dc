//! Whether a topic is still the one that was opened, by one look at the file that describes it.

use std::fs::Metadata;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The file that describes a topic to all who come, as it was when the topic was opened.
#[derive(Debug)]
pub(crate) struct Description {
    path: PathBuf,
    /// `None` when it was another topic's already.
    seen: Option<Mark>,
}

/// What tells a file from one that takes its place. Numbers of files are given again soon, but not with the same time of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    device: u64,
    number: u64,
    written: (i64, i64),
}

impl Mark {
    fn of(metadata: &Metadata) -> Self {
        let written = (metadata.mtime(), metadata.mtime_nsec());
        Self { device: metadata.dev(), number: metadata.ino(), written }
    }
}

impl Description {
    /// Remembers the file at `path`. `is_ours` reads it and says whether it describes the topic that was opened: between opening and
    /// this another may have taken its place.
    pub(crate) fn remember(path: PathBuf, is_ours: impl FnOnce() -> bool) -> Self {
        let seen = path.symlink_metadata().ok().map(|metadata| Mark::of(&metadata));
        Self { path, seen: seen.filter(|_| is_ours()) }
    }

    /// Whether it is still there. What cannot be seen now counts as unchanged: who asks again will be told.
    pub(crate) fn is_unchanged(&self) -> bool {
        match self.path.symlink_metadata() {
            Ok(metadata) => self.seen == Some(Mark::of(&metadata)),
            Err(error) => !matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory),
        }
    }

    /// Where it lies.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::time::{Duration, SystemTime};

    #[test]
    fn a_file_that_was_removed_or_took_the_place_of_another_is_noticed() {
        let folder = std::env::temp_dir().join(format!("tagbus-description-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.service");
        fs::write(&path, "one").unwrap();
        let ours = Description::remember(path.clone(), || true);
        let other = Description::remember(path.clone(), || false);
        assert!(ours.is_unchanged() && !other.is_unchanged());
        fs::remove_file(&path).unwrap();
        assert!(!ours.is_unchanged());
        fs::write(&path, "one").unwrap();
        let later = SystemTime::now() + Duration::from_secs(1);
        fs::File::options().write(true).open(&path).unwrap().set_modified(later).unwrap();
        assert!(!ours.is_unchanged());
        fs::remove_dir_all(&folder).unwrap();
        assert!(!ours.is_unchanged());
    }
}
