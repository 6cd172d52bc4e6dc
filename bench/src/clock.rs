//! The CPU time of the calling thread.

use rustix::time::{ClockId, clock_gettime};

/// CPU time that `work` takes on this thread, in microseconds, and what it returns.
pub(crate) fn cpu_us<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let before = now_us();
    let result = work();
    (now_us() - before, result)
}

fn now_us() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e6 + now.tv_nsec as f64 * 1e-3
}
