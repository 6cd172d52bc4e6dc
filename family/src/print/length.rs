//! Lengths as people write them: `160mm`, `16cm`, `0.16m`, `6.3in`.

use std::fmt;
use std::str::FromStr;

/// The longest length: PDF knows no larger page than 14,400 points, 5.08 m.
const LONGEST_MM: f64 = 5000.0;

/// Units and their millimetres. `mm` comes before `m`, which it ends in.
const UNITS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("m", 1000.0)];

/// A length from 0 to 5 m.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Length {
    mm: f64,
}

impl Length {
    /// No length.
    pub const ZERO: Length = Length { mm: 0.0 };

    /// In millimetres.
    pub fn mm(self) -> f64 {
        self.mm
    }
}

impl FromStr for Length {
    type Err = LengthError;

    fn from_str(text: &str) -> Result<Length, LengthError> {
        let refused = || LengthError { text: text.to_owned() };
        let split = |(unit, mm): (&str, f64)| text.strip_suffix(unit).map(|number| (number.trim(), mm));
        let (number, unit_mm) = UNITS.into_iter().find_map(split).ok_or_else(refused)?;
        let mm = number.parse::<f64>().map_err(|_| refused())? * unit_mm;
        // Written so that what is no number fails, too; -0 is 0.
        if (0.0..=LONGEST_MM).contains(&mm) { Ok(Length { mm: mm.abs() }) } else { Err(refused()) }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} mm", short(self.mm))
    }
}

/// Millimetres with two digits at most behind the point, as captions and messages show them.
pub(super) fn short(mm: f64) -> f64 {
    (mm * 100.0).round() / 100.0
}

/// Why a text is no length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LengthError {
    text: String,
}

impl fmt::Display for LengthError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{:?} is no length: write a number from 0 to 5 m with its unit, mm, cm, m or in, such as 160mm",
            self.text
        )
    }
}

impl std::error::Error for LengthError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_units_mean_the_same_length() {
        for text in ["160mm", "16cm", "0.16m", "160 mm", "6.299212598425197in"] {
            let mm = text.parse::<Length>().unwrap().mm();
            assert!((mm - 160.0).abs() < 1e-9, "{text} is {mm} mm");
        }
    }

    #[test]
    fn what_is_no_length_is_refused_and_quoted() {
        for text in ["160", "mm", "", "-1mm", "nanmm", "infm", "6m", "1e9mm", "1,5mm", "12px"] {
            let error = text.parse::<Length>().unwrap_err().to_string();
            assert!(error.contains(&format!("{text:?}")), "{error}");
        }
    }
}
