//! The file that describes a machine, and whether it was changed.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::time::SystemTime;

use super::part::Part;
use crate::outcome::Failure;

/// Reads the parts of the machine as they are to be now.
type Read<'a> = Box<dyn Fn() -> Result<Vec<Part>, Failure> + 'a>;

/// A file and what is made of it.
pub(super) struct Plan<'a> {
    path: PathBuf,
    read: Read<'a>,
    seen: Option<Stamp>,
}

/// What differs between two versions of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    modified: Option<SystemTime>,
    bytes: u64,
    /// Editors write another file and give it the name.
    inode: u64,
}

impl<'a> Plan<'a> {
    /// A file that was read just now.
    pub(super) fn new(path: PathBuf, read: Read<'a>) -> Self {
        let mut plan = Self { path, read, seen: None };
        plan.seen = plan.stamp();
        plan
    }

    /// The parts as they are to be now.
    pub(super) fn read(&mut self) -> Result<Vec<Part>, Failure> {
        // Before it is read: what is written meanwhile is read once more.
        self.seen = self.stamp();
        (self.read)()
    }

    /// Whether the file is another one than was read last. One that is gone is none yet: it may be on its way.
    pub(super) fn has_changed(&mut self) -> bool {
        let now = self.stamp();
        now.is_some() && now != self.seen
    }

    fn stamp(&self) -> Option<Stamp> {
        let found = fs::metadata(&self.path).ok()?;
        Some(Stamp { modified: found.modified().ok(), bytes: found.len(), inode: found.ino() })
    }
}
