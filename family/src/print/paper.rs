//! Sizes of paper.

use super::length::{Length, short};
use std::fmt;
use std::str::FromStr;

/// Paper by name, width and height in millimetres.
const NAMED: [(&str, [f64; 2]); 2] = [("A4", [210.0, 297.0]), ("letter", [215.9, 279.4])];

/// A sheet of paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Width and height in millimetres.
    pub size: [f64; 2],
    name: Option<&'static str>,
}

impl FromStr for Paper {
    type Err = PaperError;

    /// `a4`, `letter`, or width and height such as `300mmx400mm`; the unit of the height serves both when only it is
    /// written: `300x400mm`.
    fn from_str(text: &str) -> Result<Paper, PaperError> {
        let refused = || PaperError { text: text.to_owned() };
        let named = NAMED.iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
        if let Some(&(name, size)) = named {
            return Ok(Paper { size, name: Some(name) });
        }
        let (width, height) = text.split_once('x').ok_or_else(refused)?;
        let unit = height.trim_start_matches(|letter: char| !letter.is_ascii_alphabetic());
        let length = |text: &str| match text.parse::<f64>() {
            Ok(_) => format!("{text}{unit}").parse::<Length>(),
            Err(_) => text.parse(),
        };
        let size = [width, height].map(|side| length(side).map_or(0.0, Length::mm));
        if size.contains(&0.0) { Err(refused()) } else { Ok(Paper { size, name: None }) }
    }
}

impl fmt::Display for Paper {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size.map(short);
        match self.name {
            Some(name) => write!(out, "{name} ({width} x {height} mm)"),
            None => write!(out, "paper of {width} x {height} mm"),
        }
    }
}

/// Why a text is no paper.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaperError {
    text: String,
}

impl fmt::Display for PaperError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{:?} is no paper: write a4, letter, or width and height of at most 5 m such as 300x400mm",
            self.text
        )
    }
}

impl std::error::Error for PaperError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_is_known_by_name_and_by_size() {
        for (text, size) in [
            ("a4", [210.0, 297.0]),
            ("Letter", [215.9, 279.4]),
            ("300x400mm", [300.0, 400.0]),
            ("30cmx400mm", [300.0, 400.0]),
            ("8.5x11in", [215.9, 279.4]),
        ] {
            let found = text.parse::<Paper>().unwrap().size;
            assert!(
                found.iter().zip(size).all(|(found, size)| (found - size).abs() < 1e-9),
                "{text}: {found:?}"
            );
        }
        for text in ["a5", "300mm", "300x400", "0x400mm", "300x6m", "-3x4mm", ""] {
            let error = text.parse::<Paper>().unwrap_err().to_string();
            assert!(error.contains(&format!("{text:?}")), "{error}");
        }
    }
}
