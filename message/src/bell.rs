//! Waking everybody who waits for a topic, by one call of the system however many they are.
//!
//! ```text
//!              a FIFO beside the topic's memory, of which only the owner's programs know
//! producer ──▶ takes the last byte out, writes one ──▶ the kernel wakes each epoll that has it (edge-triggered)
//! receivers    never read: what woke them is that a byte came, and whoever is busy is told by his next wait
//! ```
//!
//! iceoryx2's event is a datagram for each listener, one call of the system after the other, and while they are sent those
//! who are awake already take the processor away ([measured](../../docs/decisions/0016-one-bell-for-all.md)).

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::prelude::{FileDescriptor, FileDescriptorBased};
use rustix::fs::{CWD, FileType, Mode, OFlags, mknodat};

use crate::domain::{Domain, SHARED_MEMORY};

/// Bytes that are taken out at once; one is there, unless somebody else wrote.
const AT_ONCE: usize = 64;
/// So often at most: that empties a full FIFO, and who goes on writing meanwhile keeps nobody.
const MOST_READS: usize = 65_536 / AT_ONCE;
/// Somebody may remove the FIFO between its making and its opening, but not again and again.
const ATTEMPTS: usize = 10;

/// What a topic's producer rings and its receivers wait for. It is made by whoever comes first, and removed with the domain.
#[derive(Debug)]
pub struct Bell {
    /// Names the descriptor of `fifo`, which lives as long as this.
    descriptor: FileDescriptor,
    fifo: File,
    path: PathBuf,
    /// Device and number of the file.
    mark: (u64, u64),
}

/// What is done with a bell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    Ring,
    Hear,
}

impl Bell {
    /// The bell of the topic of this hash.
    pub(crate) fn of_topic(domain: &Domain, hash: &str, purpose: Use) -> io::Result<Self> {
        let path = Path::new(SHARED_MEMORY).join(format!("{}{hash}.bell", domain.prefix()));
        Self::open(path, domain.uid(), purpose)
    }

    fn open(path: PathBuf, uid: u32, purpose: Use) -> io::Result<Self> {
        for _ in 0..ATTEMPTS {
            match mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).map_err(io::Error::from) {
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
                _ => {}
            }
            // Who rings has both ends, so that a byte can be written when nobody listens and stays when nobody reads.
            let mut options = OpenOptions::new();
            options.read(true).write(purpose == Use::Ring);
            options.custom_flags((OFlags::NONBLOCK | OFlags::NOFOLLOW).bits().cast_signed());
            match options.open(&path) {
                Ok(fifo) => return Self::of_file(fifo, path, uid),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("it is removed again and again"))
    }

    fn of_file(fifo: File, path: PathBuf, uid: u32) -> io::Result<Self> {
        let metadata = fifo.metadata()?;
        if !metadata.file_type().is_fifo() || metadata.uid() != uid {
            return Err(io::Error::other(format!("it is no FIFO of user {uid}; remove it")));
        }
        let descriptor = FileDescriptor::non_owning_new(fifo.as_raw_fd())
            .ok_or_else(|| io::Error::other("a new file has no valid file descriptor"))?;
        Ok(Self { descriptor, fifo, path, mark: mark(&metadata) })
    }

    /// Wakes whoever waits, and whoever will wait next and was busy now.
    pub(crate) fn ring(&self) -> io::Result<()> {
        let mut bytes = [0; AT_ONCE];
        // Only what comes into an empty FIFO wakes on every kernel. It is emptied by who rings: a receiver that read would take the byte from
        // those who did not yet look.
        let mut read = || (&self.fifo).read(&mut bytes);
        let _ = (0..MOST_READS).take_while(|_| matches!(read(), Ok(AT_ONCE))).count();
        (&self.fifo).write_all(&[1])
    }

    /// Whether those who come find this bell; costs one system call. What cannot be seen now counts as there.
    pub(crate) fn is_in_place(&self) -> bool {
        match fs::symlink_metadata(&self.path) {
            Ok(metadata) => mark(&metadata) == self.mark,
            Err(error) => error.kind() != io::ErrorKind::NotFound,
        }
    }
}

/// As long as it is open a file's number is not given again.
fn mark(metadata: &Metadata) -> (u64, u64) {
    (metadata.dev(), metadata.ino())
}

impl FileDescriptorBased for Bell {
    fn file_descriptor(&self) -> &FileDescriptor {
        &self.descriptor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wait::WaitSet;
    use std::os::unix::fs::symlink;
    use std::time::Duration;

    /// A file of the test's own, and the user's number.
    fn fresh(name: &str) -> (PathBuf, u32) {
        let path = std::env::temp_dir().join(format!("tagbus-bell-{}-{name}", std::process::id()));
        let _ = fs::remove_file(&path);
        (path, Domain::new("bell").unwrap().uid())
    }

    fn open(path: &Path, uid: u32, purpose: Use) -> io::Result<Bell> {
        Bell::open(path.to_owned(), uid, purpose)
    }

    #[test]
    fn every_ring_wakes_all_whether_they_wait_or_wait_later() {
        let (path, uid) = fresh("all");
        let early = open(&path, uid, Use::Hear).unwrap();
        let bell = open(&path, uid, Use::Ring).unwrap();
        let late = open(&path, uid, Use::Hear).unwrap();
        fs::remove_file(&path).unwrap();
        let sets = [WaitSet::new().unwrap(), WaitSet::new().unwrap()];
        sets[0].hear(&early).unwrap();
        sets[1].hear(&late).unwrap();
        let woken = || sets.each_ref().map(|set| set.is_woken(Duration::ZERO).unwrap());
        assert_eq!(woken(), [false; 2]);
        for _ in 0..3 {
            bell.ring().unwrap();
            assert_eq!((woken(), woken()), ([true; 2], [false; 2]));
        }
        (0..100_000).for_each(|_| bell.ring().unwrap());
        assert_eq!((woken(), woken()), ([true; 2], [false; 2]));
    }

    #[test]
    fn a_full_fifo_does_not_keep_it_from_ringing() {
        let (path, uid) = fresh("full");
        let bell = open(&path, uid, Use::Ring).unwrap();
        let ears = open(&path, uid, Use::Hear).unwrap();
        let set = WaitSet::new().unwrap();
        set.hear(&ears).unwrap();
        while (&bell.fifo).write(&[7; 1000]).is_ok() {}
        assert!(set.is_woken(Duration::ZERO).unwrap());
        bell.ring().unwrap();
        assert!(set.is_woken(Duration::ZERO).unwrap());
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn what_lies_in_its_place_is_refused_and_a_removal_is_noticed() {
        let (path, uid) = fresh("place");
        let bell = open(&path, uid, Use::Ring).unwrap();
        assert!(bell.is_in_place());
        assert!(open(&path, uid + 1, Use::Hear).unwrap_err().to_string().contains("no FIFO of user"));
        fs::remove_file(&path).unwrap();
        assert!(!bell.is_in_place());
        let other = open(&path, uid, Use::Hear).unwrap();
        assert!(!bell.is_in_place() && other.is_in_place());
        fs::remove_file(&path).unwrap();
        fs::write(&path, "text").unwrap();
        assert!(open(&path, uid, Use::Hear).unwrap_err().to_string().contains("no FIFO"));
        fs::remove_file(&path).unwrap();
        symlink("/dev/null", &path).unwrap();
        assert!(open(&path, uid, Use::Ring).is_err());
        fs::remove_file(&path).unwrap();
    }
}
