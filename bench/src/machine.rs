//! What the figures were measured on.

use std::io;
use std::process::Command;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

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

/// Keeps this thread, and what it starts from now on, off one core; where there is no other it stays.
pub(crate) fn keep_off(core: usize) -> io::Result<()> {
    let mut set = sched_getaffinity(None)?;
    set.unset(core);
    if set.count() == 0 { Ok(()) } else { Ok(sched_setaffinity(None, &set)?) }
}

/// One line each: build, processor, kernel, compiler, load.
pub(crate) fn facts() -> Vec<String> {
    let file = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let processor = file("/proc/cpuinfo");
    let processor = processor.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or("unknown");
    vec![
        format!("build: profile {}", profile()),
        format!("processor: {}", processor.trim_start_matches([' ', '\t', ':'])),
        format!("kernel: Linux {}", file("/proc/sys/kernel/osrelease").trim()),
        format!("compiler: {}", version_of("rustc")),
        format!("C: {}", c_library()),
        format!("load before: {}", file("/proc/loadavg").trim()),
    ]
}

/// The build profile, after which cargo calls the folder of the program.
fn profile() -> String {
    let program = std::env::current_exe().ok();
    let folder = program.as_deref().and_then(|program| program.parent()?.file_name()?.to_str());
    folder.unwrap_or("unknown").to_owned()
}

/// The first line of what a program says about its version.
fn version_of(program: &str) -> String {
    let output = Command::new(program).arg("--version").output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    text.ok().and_then(|text| text.lines().next().map(str::to_owned)).unwrap_or_else(|| "unknown".to_owned())
}

/// How the C library in this build was made.
fn c_library() -> String {
    match cfg!(feature = "peers") {
        true => {
            format!("AprilTag 3.4.5 of the crate apriltag-sys 0.4, -O3, one thread, by {}", version_of("cc"))
        }
        false => "no AprilTag library in this build".to_owned(),
    }
}
