//! One file a domain, by whose lock its roles agree about coming and going.
//!
//! The file lies beside the domain's shared memory and holds the path of the domain's root. A role that makes
//! something holds the lock with others; a role that cleans up holds it alone. So whoever is alone knows that nobody
//! is half way through making a node or a topic, and that what looks half made was left by the dead. The kernel gives
//! the lock back when a process dies.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a role waits for the others to leave the gate; they hold it for milliseconds.
const PATIENCE: Duration = Duration::from_secs(5);
const PAUSE: Duration = Duration::from_millis(2);

/// How a role passes the gate.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Company {
    /// With others that do the same.
    Shared,
    /// With nobody else at the gate.
    Alone,
}

/// The lock; given back when dropped.
pub(crate) struct Pass {
    file: File,
    path: PathBuf,
}

/// Takes the lock of the file at `path`, which is made when it is not there.
pub(crate) fn enter(path: &Path, company: Company) -> io::Result<Pass> {
    let started = Instant::now();
    loop {
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).mode(0o600).open(path)?;
        let locked = match company {
            Company::Shared => file.try_lock_shared(),
            Company::Alone => file.try_lock(),
        };
        match locked {
            // Whoever ended the domain in the meantime removed the file: then this lock is of no worth.
            Ok(()) if is_still_at(&file, path)? => return Ok(Pass { file, path: path.to_owned() }),
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => return Err(error),
        }
        if started.elapsed() > PATIENCE {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "another process holds it for too long"));
        }
        std::thread::sleep(PAUSE);
    }
}

fn is_still_at(file: &File, path: &Path) -> io::Result<bool> {
    let here = file.metadata()?;
    match path.symlink_metadata() {
        Ok(there) => Ok(here.ino() == there.ino() && here.dev() == there.dev()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

impl Pass {
    /// The root that the domain's roles agreed on; empty in a new file.
    pub(crate) fn read_root(&mut self) -> io::Result<String> {
        let mut text = String::new();
        self.file.rewind()?;
        self.file.read_to_string(&mut text)?;
        Ok(text)
    }

    /// Writes the root down for the roles that come later.
    pub(crate) fn write_root(&mut self, root: &str) -> io::Result<()> {
        self.file.rewind()?;
        self.file.set_len(0)?;
        self.file.write_all(root.as_bytes())
    }

    /// Removes the file; whoever waits for it makes a new one.
    pub(crate) fn remove(self) -> io::Result<()> {
        std::fs::remove_file(&self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn fresh(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("tagbus-gate-{}-{name}", std::process::id()))
    }

    #[test]
    fn only_one_is_alone_although_the_file_is_removed_again_and_again() {
        let path = fresh("alone");
        let inside = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for round in 0..50 {
                        let pass = enter(&path, Company::Alone).unwrap();
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                        std::thread::yield_now();
                        inside.fetch_sub(1, Ordering::SeqCst);
                        if round % 3 == 0 {
                            pass.remove().unwrap();
                        }
                    }
                });
            }
        });
        let _ = std::fs::remove_file(&path);
    }

    #[test]
    fn the_root_is_remembered() {
        let path = fresh("root");
        enter(&path, Company::Alone).unwrap().write_root("/a/longer/path").unwrap();
        enter(&path, Company::Alone).unwrap().write_root("/short").unwrap();
        let mut pass = enter(&path, Company::Shared).unwrap();
        assert_eq!(pass.read_root().unwrap(), "/short");
        pass.remove().unwrap();
    }
}
