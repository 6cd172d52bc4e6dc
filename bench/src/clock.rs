//! CPU time, of this process and of others.

use std::fs;
use std::io;

use rustix::time::{ClockId, clock_gettime};

/// CPU time that `work` takes, in microseconds, and what it returns. The whole process is counted, because some peers
/// hand their work to a thread of their own and wait for it; nothing else runs in a bench meanwhile.
pub(crate) fn cpu_us<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let before = start_us();
    let result = work();
    (now_us() - before, result)
}

/// The time that a measurement begins with: what it takes to ask the clock is taken off.
fn start_us() -> f64 {
    let asking = asking_us();
    now_us() + asking
}

/// What it takes to ask the clock, about a microsecond. The clock is asked before as well, since what the kernel needs to tell the
/// time would else come from memory while something is measured: 2 microseconds where 16 MB of other memory were written since, 10
/// where 64 MB were.
pub(crate) fn asking_us() -> f64 {
    now_us();
    let before = now_us();
    now_us() - before
}

/// CPU time of this process so far, in microseconds.
pub(crate) fn now_us() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e6 + now.tv_nsec as f64 * 1e-3
}

/// CPU time so far of all threads of a process, nanoseconds.
pub(crate) fn process_ns(process: u32) -> io::Result<u64> {
    threads_ns(process, |_| true)
}

/// CPU time so far of the threads of a process that have this name, nanoseconds. Linux keeps 15 bytes of a name.
pub(crate) fn thread_ns(process: u32, name: &str) -> io::Result<u64> {
    threads_ns(process, |other| other == name)
}

fn threads_ns(process: u32, is_counted: impl Fn(&str) -> bool) -> io::Result<u64> {
    let mut sum = 0;
    for thread in fs::read_dir(format!("/proc/{process}/task"))? {
        let folder = thread?.path();
        if !is_counted(fs::read_to_string(folder.join("comm"))?.trim_end()) {
            continue;
        }
        let text = fs::read_to_string(folder.join("schedstat"))?;
        let first = text.split_whitespace().next().and_then(|word| word.parse::<u64>().ok());
        sum += first.ok_or_else(|| io::Error::other(format!("no CPU time in schedstat: '{text}'")))?;
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_thread_has_a_part_of_the_time_of_its_process() {
        let (process, work) = (std::process::id(), || while now_us() < 20_000.0 {});
        let named = std::thread::Builder::new().name("a named thread".to_owned()).spawn(move || {
            work();
            [thread_ns(process, "a named thread").unwrap(), process_ns(process).unwrap()]
        });
        let [thread, all] = named.unwrap().join().unwrap();
        assert!(thread > 0 && thread <= all, "{thread} of {all}");
        assert_eq!(thread_ns(process, "nobody").unwrap(), 0);
    }
}
