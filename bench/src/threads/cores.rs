//! Which core each thread works on.

use std::io;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Cores that this program may use.
pub(super) struct Cores {
    all: Vec<usize>,
}

impl Cores {
    pub(super) fn of_this_thread() -> io::Result<Self> {
        let set = sched_getaffinity(None)?;
        Ok(Self { all: (0..CpuSet::MAX_CPU).filter(|core| set.is_set(*core)).collect() })
    }

    /// Keeps this thread, and what it starts from now on, on the core of thread `number`; beyond the last core they begin anew.
    pub(super) fn keep_to(&self, number: usize) -> io::Result<()> {
        keep_to(&[self.all[number % self.all.len()]])
    }

    /// As [`Self::keep_to`], on all but the first; where there is only one, on that.
    pub(super) fn keep_off_first(&self) -> io::Result<()> {
        keep_to(if self.all.len() > 1 { &self.all[1..] } else { &self.all })
    }

    /// The kernel may put this thread where it likes.
    pub(super) fn set_free(&self) -> io::Result<()> {
        keep_to(&self.all)
    }
}

fn keep_to(cores: &[usize]) -> io::Result<()> {
    let mut set = CpuSet::new();
    cores.iter().for_each(|core| set.set(*core));
    Ok(sched_setaffinity(None, &set)?)
}
