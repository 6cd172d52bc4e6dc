//! What the kernel says about a process.

use std::fs;

/// Whether a process is there, and may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Process {
    /// It is there.
    There,
    /// It is there and does nothing until somebody lets it: by SIGSTOP, or under a debugger.
    Halted,
    /// There is none of this number, or only what its parent has not asked for yet.
    Gone,
}

impl Process {
    /// The process of a number.
    pub(super) fn of(number: u32) -> Self {
        match fs::read_to_string(format!("/proc/{number}/stat")) {
            Ok(stat) => Self::of_stat(&stat),
            Err(_) => Self::Gone,
        }
    }

    /// The letter of the state follows the name, which is in brackets and may have brackets in it.
    fn of_stat(stat: &str) -> Self {
        match stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next()) {
            Some('T' | 't') => Self::Halted,
            Some('Z' | 'X' | 'x') => Self::Gone,
            _ => Self::There,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processes_are_told_apart() {
        assert_eq!(Process::of(std::process::id()), Process::There);
        // Greater than any number of a process can be.
        assert_eq!(Process::of(1 << 30), Process::Gone);
        let letters = ['S', 'T', 'Z'].map(|letter| Process::of_stat(&format!("7 (a) T (b) {letter} 1 2")));
        assert_eq!(letters, [Process::There, Process::Halted, Process::Gone]);
    }
}
