//! What processes and a domain hold at one moment.

use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use tagbus_client::Domain;

/// Bytes of the unit in which Linux counts a file's room.
const BLOCK: u64 = 512;

/// What one process holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Usage {
    /// Memory of its own that no file backs: heap and stacks, KiB (`RssAnon`).
    pub(crate) anonymous_kib: u64,
    /// All pages that it has mapped, KiB (`VmRSS`).
    pub(crate) resident_kib: u64,
    /// The same, each page divided among the processes that map it, KiB.
    pub(crate) proportional_kib: u64,
    /// Open files.
    pub(crate) files: u64,
    pub(crate) threads: u64,
}

impl Usage {
    /// Of a living process.
    pub(crate) fn of(process: u32) -> io::Result<Self> {
        let folder = Path::new("/proc").join(process.to_string());
        let status = fs::read_to_string(folder.join("status"))?;
        let rollup = fs::read_to_string(folder.join("smaps_rollup"))?;
        Ok(Self {
            anonymous_kib: field(&status, "RssAnon:")?,
            resident_kib: field(&status, "VmRSS:")?,
            proportional_kib: field(&rollup, "Pss:")?,
            files: fs::read_dir(folder.join("fd"))?.count() as u64,
            threads: field(&status, "Threads:")?,
        })
    }
}

fn field(text: &str, name: &str) -> io::Result<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    let number = line.and_then(|line| line.split_whitespace().next()).and_then(|word| word.parse().ok());
    number.ok_or_else(|| io::Error::other(format!("no number after {name} in /proc")))
}

/// What a domain holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Stored {
    /// Files in shared memory.
    pub(crate) files: u64,
    /// Their sizes together.
    pub(crate) reserved: u64,
    /// What of that was written and so takes memory.
    pub(crate) touched: u64,
    /// Files, sockets and folders in the domain's root.
    pub(crate) in_root: u64,
}

impl Stored {
    pub(crate) fn of(domain: &Domain) -> io::Result<Self> {
        let mut sum = Self { in_root: count(domain.root()), ..Self::default() };
        for name in domain.leftovers()? {
            let metadata = fs::metadata(Path::new("/dev/shm").join(name))?;
            sum.files += 1;
            sum.reserved += metadata.len();
            sum.touched += metadata.blocks() * BLOCK;
        }
        Ok(sum)
    }
}

fn count(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    entries.map(|entry| 1 + count(&entry.path())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_has_a_thread_three_files_and_some_memory() {
        let usage = Usage::of(std::process::id()).unwrap();
        assert!(usage.threads >= 1 && usage.files >= 3, "{usage:?}");
        assert!((100..10_000_000).contains(&usage.anonymous_kib), "{usage:?}");
        assert!(usage.resident_kib >= usage.anonymous_kib && usage.proportional_kib > 0, "{usage:?}");
        assert!(field("Threads: many", "Threads:").is_err());
    }
}
