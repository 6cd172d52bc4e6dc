//! What the figures were measured on.

use std::io;
use std::process::Command;

use rustix::thread::{CpuSet, sched_setaffinity};

/// Keeps this thread on one core, so that its caches and clock are its own.
pub(crate) fn pin_to(core: usize) -> io::Result<()> {
    let mut set = CpuSet::new();
    set.set(core);
    sched_setaffinity(None, &set).map_err(|error| {
        io::Error::other(format!(
            "core {core} cannot be used ({error}): name one of this machine's cores with --core"
        ))
    })
}

/// One line each: processor, kernel, compiler, load.
pub(crate) fn facts() -> Vec<String> {
    let file = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let processor = file("/proc/cpuinfo");
    let processor = processor.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or("unknown");
    let compiler = Command::new("rustc").arg("--version").output();
    let compiler = compiler.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    vec![
        format!("processor: {}", processor.trim_start_matches([' ', '\t', ':'])),
        format!("kernel: Linux {}", file("/proc/sys/kernel/osrelease").trim()),
        format!("compiler: {}", compiler.unwrap_or_else(|_| "unknown".to_owned())),
        format!("load before: {}", file("/proc/loadavg").trim()),
    ]
}
