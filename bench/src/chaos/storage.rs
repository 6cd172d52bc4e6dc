//! What a domain keeps in shared memory and in its root.

use std::fmt;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use tagbus_message::domain::Domain;

const SHARED_MEMORY: &str = "/dev/shm";
/// Bytes of the unit in which Linux counts a file's room.
const BLOCK: u64 = 512;

/// Files and bytes of a domain at one moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Storage {
    /// Files in shared memory.
    pub(super) shared: usize,
    /// Their sizes together: what was reserved.
    pub(super) reserved: u64,
    /// What of that was touched and so takes memory.
    pub(super) touched: u64,
    /// Files, sockets and directories in the root, the root among them.
    pub(super) root: usize,
}

impl Storage {
    pub(super) fn of(domain: &Domain) -> Self {
        let mut sum = Self { root: count(domain.root()), ..Self::default() };
        for name in domain.leftovers().unwrap_or_default() {
            // Who leaves between the list and the look takes his files with him.
            if let Ok(metadata) = fs::metadata(Path::new(SHARED_MEMORY).join(name)) {
                sum.shared += 1;
                sum.reserved += metadata.len();
                sum.touched += metadata.blocks() * BLOCK;
            }
        }
        sum
    }

    /// The same files with the same sizes; how much of them was touched changes with the work.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        (self.shared, self.reserved, self.root) == (other.shared, other.reserved, other.root)
    }
}

impl fmt::Display for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shared, reserved, touched, root } = self;
        write!(
            f,
            "{shared} files of {reserved} bytes ({touched} touched) in shared memory, {root} files in the root"
        )
    }
}

fn count(path: &Path) -> usize {
    let Ok(metadata) = path.symlink_metadata() else { return 0 };
    if !metadata.is_dir() {
        return 1;
    }
    let entries = fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
    1 + entries.map(|entry| count(&entry.path())).sum::<usize>()
}

/// Every file's name and size, for an error message.
pub(super) fn list(domain: &Domain) -> String {
    let mut names = Vec::new();
    for name in domain.leftovers().unwrap_or_default() {
        let bytes = fs::metadata(Path::new(SHARED_MEMORY).join(&name)).map_or(0, |metadata| metadata.len());
        names.push(format!("{bytes:>10} {name}"));
    }
    collect(domain.root(), &mut names);
    names.sort();
    names.join("\n")
}

fn collect(path: &Path, names: &mut Vec<String>) {
    names.push(format!("           {}", path.display()));
    let entries = fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
    entries.for_each(|entry| collect(&entry.path(), names));
}
