//! The CPU time of this process.

use rustix::time::{ClockId, clock_gettime};

/// CPU time that `work` takes, in microseconds, and what it returns. The whole process is counted, because some peers
/// hand their work to a thread of their own and wait for it; nothing else runs in a bench meanwhile.
pub(crate) fn cpu_us<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let before = now_us();
    let result = work();
    (now_us() - before, result)
}

/// CPU time of this process so far, in microseconds.
pub(crate) fn now_us() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e6 + now.tv_nsec as f64 * 1e-3
}
