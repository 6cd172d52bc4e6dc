//! Colours, on a terminal only.

use std::io::{self, IsTerminal};

/// Whether what is written is looked at by a person or read by a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reader {
    /// A terminal: colours are welcome.
    Person,
    /// A pipe or a file: plain text.
    Program,
}

impl Reader {
    /// Who reads the standard output.
    pub(crate) fn of_stdout() -> Self {
        // The custom of no-color.org: set to anything, it means no colours.
        let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        if io::stdout().is_terminal() && !refused { Self::Person } else { Self::Program }
    }

    /// `text` in bold for a person.
    pub(crate) fn bold(self, text: &str) -> String {
        self.styled("1", text)
    }

    /// `text` in a faint colour for a person.
    pub(crate) fn faint(self, text: &str) -> String {
        self.styled("2", text)
    }

    /// `text` in bright white on black for a person, whatever the colours of the terminal.
    pub(crate) fn white_on_black(self, text: &str) -> String {
        self.styled("97;40", text)
    }

    fn styled(self, style: &str, text: &str) -> String {
        match self {
            Self::Person => format!("\x1b[{style}m{text}\x1b[0m"),
            Self::Program => text.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_get_plain_text() {
        assert_eq!(Reader::Program.bold("name"), "name");
        assert_eq!(Reader::Person.bold("name"), "\x1b[1mname\x1b[0m");
    }
}
