//! Threads that help with a frame: started once, asleep between frames.
//!
//! ```text
//! caller    ──┬─ work ──────┬─▶     everybody calls the same closure, which takes parts from one
//! worker 1    ├─ work ────┐ │       queue until none is left; the caller goes on when nobody is
//! worker 2    └ (asleep)  ┴─┘       inside any more, and who wakes too late finds the door closed
//! ```
//!
//! The caller takes parts from the front, workers from the back: so a thread mostly finds near what it made itself in the phase
//! before. Who takes which part is chance all the same, and results must not depend on it: parts write to places of their own, or say
//! which number they have. Nothing is allocated after the start. `docs/decisions/0007-threads.md` says why it is done this way.

#![allow(
    unsafe_code,
    reason = "the conventions name this file: borrowed work is lent to threads that outlive it"
)]

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A caller's work, as long as the door is open.
type Work = &'static (dyn Fn(End) + Sync);
type Panic = Box<dyn Any + Send>;

/// Where a thread takes its parts.
#[derive(Clone, Copy)]
enum End {
    Front,
    Back,
}

/// How often a thread looks for what it waits for before it sleeps: some tens of microseconds, which is what waking costs. The
/// phases of a frame follow each other more quickly.
const LOOKS: usize = 2000;

/// Most threads of a detector.
pub(crate) const MOST: usize = 64;

/// Parts that a thread is dealt if all take the same time.
const PARTS_A_THREAD: usize = 8;

/// Threads that wait for work, and the one that has it.
pub(crate) struct Threads {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

struct Shared {
    door: Mutex<Door>,
    opened: Condvar,
    emptied: Condvar,
    /// `Door::openings` and `Door::inside` for those who look before they sleep.
    openings: AtomicU64,
    inside: AtomicUsize,
}

/// Where workers find work.
#[derive(Default)]
struct Door {
    /// The work while the door is open.
    work: Option<Work>,
    /// How often it was opened.
    openings: u64,
    /// Workers that have gone in and not come out.
    inside: usize,
    /// Workers that must be woken.
    asleep: usize,
    /// What ended a worker's share of the work before its time.
    panic: Option<Panic>,
    is_shut_for_good: bool,
}

impl Threads {
    /// `count` threads in all: the caller's own and as many workers besides. With one, nothing is started.
    pub(crate) fn start(count: usize) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            door: Mutex::default(),
            opened: Condvar::new(),
            emptied: Condvar::new(),
            openings: AtomicU64::new(0),
            inside: AtomicUsize::new(0),
        });
        let mut threads = Self { shared, workers: Vec::new() };
        for _ in 1..count {
            let shared = Arc::clone(&threads.shared);
            // Those that were started before an error end when `threads` is dropped.
            let worker = Builder::new().name("tagbus-detector".to_owned()).spawn(move || shared.attend())?;
            threads.workers.push(worker);
        }
        Ok(threads)
    }

    /// How many threads work, the caller's included.
    pub(crate) fn count(&self) -> usize {
        self.workers.len() + 1
    }

    /// How long parts of so many equal things are best made: several for each thread, since some take longer than others, and
    /// the system may give a thread less time.
    pub(crate) fn part_length(&self, things: usize) -> usize {
        things.div_ceil(PARTS_A_THREAD * self.count()).max(1)
    }

    /// Calls `work` once for each of `parts`, on whatever thread is free; returns when all are done. Each thread has one of
    /// `scratches`, which must be as many as there are threads. A panic of `work` goes on in the caller.
    pub(crate) fn deal<S: Send, P: Send>(
        &mut self,
        scratches: &mut [S],
        parts: impl ExactSizeIterator<Item = P> + DoubleEndedIterator + Send,
        work: impl Fn(&mut S, P) + Sync,
    ) {
        let helpers = parts.len().saturating_sub(1);
        if helpers == 0 || self.workers.is_empty() {
            return parts.for_each(|part| work(&mut scratches[0], part));
        }
        let (scratches, parts) = (Mutex::new(scratches.iter_mut()), Mutex::new(parts));
        self.share(helpers, &|end| {
            let Some(scratch) = next_of(&scratches, end) else { return };
            while let Some(part) = next_of(&parts, end) {
                work(scratch, part);
            }
        });
    }

    /// As [`Self::deal`] for work that needs nothing of its own.
    pub(crate) fn each<P: Send>(
        &mut self,
        parts: impl ExactSizeIterator<Item = P> + DoubleEndedIterator + Send,
        work: impl Fn(P) + Sync,
    ) {
        self.deal(&mut [(); MOST], parts, |(), part| work(part));
    }

    /// Calls `work` here and on those of at most `helpers` woken workers that come before it is done here; returns when
    /// nobody is inside any more.
    fn share(&mut self, helpers: usize, work: &(dyn Fn(End) + Sync)) {
        // SAFETY: only the lifetime is changed. Workers get the reference from the open door alone, under its lock, and
        // are counted as inside until their call has ended, also by a panic. `Closing` removes it from the door under the
        // same lock and then waits until nobody is inside; that happens before this function returns, and when `work`
        // panics here, too. So nobody uses `work` after the borrow has ended.
        let lent = unsafe { std::mem::transmute::<&(dyn Fn(End) + Sync), Work>(work) };
        self.shared.open(lent, helpers);
        let closing = Closing(&self.shared);
        work(End::Front);
        drop(closing);
        let panic = self.shared.door().panic.take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

fn next_of<T>(parts: &Mutex<impl DoubleEndedIterator<Item = T>>, end: End) -> Option<T> {
    // An iterator over parts does not panic; if one did, what it still gives is as good as before.
    let mut parts = parts.lock().unwrap_or_else(PoisonError::into_inner);
    match end {
        End::Front => parts.next(),
        End::Back => parts.next_back(),
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.shared.door().is_shut_for_good = true;
        self.shared.openings.fetch_add(1, Ordering::Relaxed);
        self.shared.opened.notify_all();
        for worker in self.workers.drain(..) {
            // It catches the panics of its work, so it has none of its own to tell of.
            let _ = worker.join();
        }
    }
}

/// Closes the door and waits for those inside, however the caller leaves.
struct Closing<'s>(&'s Shared);

impl Drop for Closing<'_> {
    fn drop(&mut self) {
        self.0.close();
    }
}

impl Shared {
    fn door(&self) -> MutexGuard<'_, Door> {
        // Nothing panics while it is held.
        self.door.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn open(&self, work: Work, helpers: usize) {
        let mut door = self.door();
        door.work = Some(work);
        door.panic = None;
        door.openings += 1;
        self.openings.store(door.openings, Ordering::Relaxed);
        let asleep = door.asleep;
        drop(door);
        // Telling those who are awake would be a system call for nothing.
        for _ in 0..asleep.min(helpers) {
            self.opened.notify_one();
        }
    }

    fn close(&self) {
        self.door().work = None;
        wait_for(|| self.inside.load(Ordering::Relaxed) == 0);
        let mut door = self.door();
        while door.inside > 0 {
            door = self.emptied.wait(door).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A worker's life.
    fn attend(&self) {
        let mut seen = 0;
        while let Some(work) = self.enter(&mut seen) {
            let panic = catch_unwind(AssertUnwindSafe(|| work(End::Back))).err();
            self.leave(panic);
        }
    }

    /// Waits for a work that was not seen before and goes in. `None` when there will be no more.
    fn enter(&self, seen: &mut u64) -> Option<Work> {
        loop {
            wait_for(|| self.openings.load(Ordering::Relaxed) != *seen);
            let mut door = self.door();
            if door.openings == *seen && !door.is_shut_for_good {
                door.asleep += 1;
                door = self.opened.wait(door).unwrap_or_else(PoisonError::into_inner);
                door.asleep -= 1;
            }
            if door.is_shut_for_good {
                return None;
            }
            let is_new = door.openings != *seen;
            *seen = door.openings;
            if let (true, Some(work)) = (is_new, door.work) {
                door.inside += 1;
                self.inside.store(door.inside, Ordering::Relaxed);
                return Some(work);
            }
        }
    }

    fn leave(&self, panic: Option<Panic>) {
        let mut door = self.door();
        door.inside -= 1;
        self.inside.store(door.inside, Ordering::Relaxed);
        if panic.is_some() {
            door.panic = panic;
        }
        let is_waited_for = door.inside == 0 && door.work.is_none();
        drop(door);
        if is_waited_for {
            self.emptied.notify_one();
        }
    }
}

/// Looks for a while whether it is so; it need not be afterwards.
fn wait_for(is_so: impl Fn() -> bool) {
    for _ in 0..LOOKS {
        if is_so() {
            return;
        }
        std::hint::spin_loop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;
    use std::sync::{Barrier, mpsc};
    use std::time::Duration;

    /// Fails instead of hanging.
    fn within_a_minute(work: impl FnOnce() + Send + 'static) {
        let (done, ended) = mpsc::channel();
        let thread = std::thread::spawn(move || {
            work();
            let _ = done.send(());
        });
        match ended.recv_timeout(Duration::from_mins(1)) {
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("still at work after a minute"),
            _ => thread.join().unwrap(),
        }
    }

    /// Two threads that are both inside when `work` is called by each, with whether it is the caller.
    fn with_both_inside(threads: &mut Threads, work: impl Fn(bool) + Sync) {
        let (both, caller) = (Barrier::new(2), std::thread::current().id());
        threads.deal(&mut [(), ()], 0..2, |(), _| {
            both.wait();
            work(std::thread::current().id() == caller);
        });
    }

    #[test]
    fn every_part_is_worked_on_once_whatever_the_number_of_threads() {
        within_a_minute(|| {
            for count in [1, 2, 3, 5, 8] {
                let mut threads = Threads::start(count).unwrap();
                assert_eq!(threads.count(), count);
                let mut scratches = vec![0; count];
                let mut total = 0;
                for round in 0..2000 {
                    let mut parts = vec![round; round % 37];
                    total += parts.len();
                    threads.deal(&mut scratches, parts.iter_mut(), |done, part| {
                        *done += 1;
                        *part += 1;
                    });
                    assert!(parts.iter().all(|part| *part == round + 1), "{count} threads: {parts:?}");
                }
                assert_eq!(scratches.iter().sum::<usize>(), total, "{count} threads");
            }
        });
    }

    #[test]
    fn workers_that_sleep_are_woken() {
        within_a_minute(|| {
            let mut threads = Threads::start(2).unwrap();
            for _ in 0..20 {
                std::thread::sleep(Duration::from_millis(2));
                with_both_inside(&mut threads, |_| {});
            }
        });
    }

    #[test]
    fn one_thread_starts_no_other() {
        let mut threads = Threads::start(1).unwrap();
        assert!(threads.workers.is_empty());
        let caller = std::thread::current().id();
        threads.deal(&mut [()], 0..9, |(), _| assert_eq!(std::thread::current().id(), caller));
    }

    #[test]
    fn a_panic_of_a_worker_goes_on_in_the_caller_and_the_next_work_is_done() {
        within_a_minute(|| {
            let mut threads = Threads::start(2).unwrap();
            for _ in 0..50 {
                let panic = catch_unwind(AssertUnwindSafe(|| {
                    with_both_inside(&mut threads, |is_caller| assert!(is_caller, "the worker's"));
                }));
                assert_eq!(panic.unwrap_err().downcast_ref::<&str>(), Some(&"the worker's"));
                with_both_inside(&mut threads, |_| {});
            }
        });
    }

    #[test]
    fn a_caller_that_panics_waits_for_those_inside_first() {
        within_a_minute(|| {
            let mut threads = Threads::start(2).unwrap();
            for _ in 0..20 {
                let has_ended = AtomicBool::new(false);
                let panic = catch_unwind(AssertUnwindSafe(|| {
                    with_both_inside(&mut threads, |is_caller| {
                        assert!(!is_caller, "the caller's");
                        std::thread::sleep(Duration::from_millis(2));
                        has_ended.store(true, Ordering::Relaxed);
                    });
                }));
                assert_eq!(panic.unwrap_err().downcast_ref::<&str>(), Some(&"the caller's"));
                assert!(has_ended.load(Ordering::Relaxed), "the worker was still using what it had borrowed");
                with_both_inside(&mut threads, |_| {});
            }
        });
    }

    #[test]
    fn dropping_ends_the_workers() {
        within_a_minute(|| {
            for pause_ms in [0, 2] {
                let mut threads = Threads::start(4).unwrap();
                threads.deal(&mut [(); 4], 0..9, |(), _| {});
                std::thread::sleep(Duration::from_millis(pause_ms));
                let shared = Arc::downgrade(&threads.shared);
                drop(threads);
                assert!(shared.upgrade().is_none(), "a worker still holds its end");
            }
        });
    }
}
