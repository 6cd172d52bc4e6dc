//! The way to end a role: a flag that wakes whoever waits.

use std::io::{self, Write};
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::prelude::{FileDescriptor, FileDescriptorBased};

/// A stop request shared by everybody who holds a clone. Once triggered it stays so.
///
/// Its file descriptor becomes readable then and is never drained, so that every wait set it is attached to wakes.
#[derive(Clone, Debug)]
pub struct Stop {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    triggered: AtomicBool,
    /// Is held while `triggered` changes, so that nobody falls asleep just then.
    change: Mutex<()>,
    changed: Condvar,
    writer: UnixStream,
    /// Names the descriptor of `_reader`, which lives as long as this.
    descriptor: FileDescriptor,
    _reader: UnixStream,
}

impl Stop {
    /// A request that nobody has made yet. Fails when the process has no file descriptor left.
    pub fn new() -> io::Result<Self> {
        let (reader, writer) = UnixStream::pair()?;
        let descriptor = FileDescriptor::non_owning_new(reader.as_raw_fd())
            .ok_or_else(|| io::Error::other("a new socket has no valid file descriptor"))?;
        let shared = Shared {
            triggered: AtomicBool::new(false),
            change: Mutex::new(()),
            changed: Condvar::new(),
            writer,
            descriptor,
            _reader: reader,
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Asks everybody to stop. May be called from any thread and more than once.
    pub fn trigger(&self) {
        let _alone = self.shared.change.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.shared.triggered.swap(true, Ordering::AcqRel) {
            self.shared.changed.notify_all();
            // One byte always fits an empty socket, and the reader lives as long as the writer.
            let _ = (&self.shared.writer).write_all(&[1]);
        }
    }

    /// Whether somebody asked to stop.
    #[must_use]
    pub fn is_triggered(&self) -> bool {
        self.shared.triggered.load(Ordering::Acquire)
    }

    /// Sleeps until the request is made or the time is over; says whether it was made.
    #[must_use]
    pub fn wait(&self, timeout: Duration) -> bool {
        let alone = self.shared.change.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.shared.changed.wait_timeout_while(alone, timeout, |()| !self.is_triggered());
        drop(waited.unwrap_or_else(PoisonError::into_inner));
        self.is_triggered()
    }
}

impl FileDescriptorBased for Stop {
    fn file_descriptor(&self) -> &FileDescriptor {
        &self.shared.descriptor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_stops_before_it_is_asked() {
        let stop = Stop::new().unwrap();
        assert!(!stop.is_triggered());
        assert!(!stop.wait(Duration::from_millis(1)));
    }

    #[test]
    fn a_clone_in_another_thread_is_woken() {
        let stop = Stop::new().unwrap();
        let other = stop.clone();
        let sleeper = std::thread::spawn(move || other.wait(Duration::from_secs(60)));
        stop.trigger();
        stop.trigger();
        assert!(sleeper.join().unwrap());
        assert!(stop.wait(Duration::ZERO) && stop.is_triggered());
    }
}
