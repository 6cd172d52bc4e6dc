//! How a command ends: the one place that turns errors into text and an exit code.

use std::error::Error;
use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

/// A command that came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Everything was done: exit code 0.
    Done,
    /// Everything was done and nothing was found: exit code 1.
    NothingFound,
    /// Something failed and was reported while the rest went on: exit code 2.
    Failed,
}

/// An error that ends a command with exit code 2.
///
/// It is no [`Error`] itself, so that every error becomes one by `?`.
#[derive(Debug)]
pub(crate) struct Failure(Box<dyn Error + Send + Sync>);

impl Failure {
    /// A failure in our own words.
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self(text.into().into())
    }

    /// Whoever read our output has gone, `head` for instance: a clean end.
    fn is_closed_pipe(&self) -> bool {
        let error = self.0.downcast_ref::<io::Error>();
        error.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(Box::new(error))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Says what went wrong, if anything, and gives the exit code.
pub(crate) fn conclude(result: Result<Outcome, Failure>) -> ExitCode {
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::NothingFound) => ExitCode::from(1),
        Ok(Outcome::Failed) => ExitCode::from(2),
        Err(failure) if failure.is_closed_pipe() => ExitCode::SUCCESS,
        Err(failure) => {
            complain(failure);
            ExitCode::from(2)
        }
    }
}

/// One message on the standard error, whether or not somebody reads it.
pub(crate) fn complain(message: impl fmt::Display) {
    // Where even the standard error is closed nobody is left to tell.
    let _ = writeln!(io::stderr().lock(), "tagbus: {message}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_closed_pipe_is_a_clean_end() {
        assert!(Failure::from(io::Error::from(io::ErrorKind::BrokenPipe)).is_closed_pipe());
        assert!(!Failure::from(io::Error::from(io::ErrorKind::NotFound)).is_closed_pipe());
        assert!(!Failure::new("broken pipe").is_closed_pipe());
    }
}
