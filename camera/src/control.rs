//! Controls of a device, such as exposure and gain: what is asked for, what there is.

use std::fmt;
use std::str::FromStr;

/// A control and the value it is to have, as the user wrote them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ControlSetting {
    /// The control's name, for instance `exposure_time_absolute`.
    pub name: String,
    /// A number, or an entry of the control's menu.
    pub value: String,
}

impl fmt::Display for ControlSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.value)
    }
}

/// Settings of several controls, written as `gain=50,auto_exposure=manual_mode`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ControlSettings(pub Vec<ControlSetting>);

impl FromStr for ControlSettings {
    type Err = ControlTextError;

    fn from_str(text: &str) -> Result<Self, ControlTextError> {
        let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
        let setting = |part: &str| match part.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
                Ok(ControlSetting { name: identifier(name), value: value.trim().to_string() })
            }
            _ => Err(ControlTextError(part.to_string())),
        };
        parts.map(setting).collect::<Result<_, _>>().map(Self)
    }
}

impl fmt::Display for ControlSettings {
    /// The text from which the settings are read back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, setting) in self.0.iter().enumerate() {
            write!(f, "{}{setting}", if place == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

/// A text that sets no control.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ControlTextError(pub String);

impl fmt::Display for ControlTextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "'{}' sets no control: NAME=VALUE, separated by commas (`tagbus camera --list` names them)",
            self.0
        )
    }
}

impl std::error::Error for ControlTextError {}

/// A control that a device has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ControlInfo {
    /// The name to set it by.
    pub name: String,
    /// Smallest value.
    pub min: i64,
    /// Largest value.
    pub max: i64,
    /// Step between values.
    pub step: i64,
    /// The value that the driver starts with.
    pub default: i64,
    /// The value at present; `None` for a button, and where the driver does not say.
    pub value: Option<i64>,
    /// The values of a menu with what they mean; empty for all others.
    pub menu: Vec<(i64, String)>,
    /// Whether another control has its say at present, so that a value has no effect.
    pub inactive: bool,
}

impl fmt::Display for ControlInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, min, max, step, default, value, menu, inactive } = self;
        write!(f, "{name}")?;
        if let Some(value) = value {
            write!(f, " = {value}")?;
        }
        write!(f, "  ({min} to {max}")?;
        if *step > 1 {
            write!(f, " in steps of {step}")?;
        }
        write!(f, ", starts with {default}{})", if *inactive { ", inactive" } else { "" })?;
        menu.iter().try_for_each(|(value, text)| write!(f, " {value}:{}", identifier(text)))
    }
}

/// A name or an entry of a menu as it is written on the command line: `Exposure Time, Absolute` is `exposure_time_absolute`.
pub(crate) fn identifier(title: &str) -> String {
    let words = title.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("_")
}

/// The name that is most like `asked`: the fewest letters have to be added, dropped or replaced.
#[cfg(any(feature = "v4l", feature = "libcamera"))]
pub(crate) fn most_like<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // A part of a name is how people remember it: gain for analogue_gain.
    let far = |name: &str| if name.contains(asked) { 0 } else { distance(asked, name) };
    names.min_by_key(|name| far(name))
}

/// Levenshtein's distance.
#[cfg(any(feature = "v4l", feature = "libcamera"))]
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(any(feature = "v4l", feature = "libcamera"))]
    #[test]
    fn the_nearest_name_is_one_that_holds_the_word_or_the_one_with_the_fewest_differences() {
        let names = ["brightness", "analogue_gain", "exposure_time_absolute"];
        let like = |asked| most_like(asked, names.into_iter()).unwrap();
        assert_eq!((like("gain"), like("brihgtness"), like("exposure")), (names[1], names[0], names[2]));
        assert_eq!((distance("kitten", "sitting"), distance("", "abc"), distance("abc", "")), (3, 3, 3));
    }

    #[test]
    fn settings_are_read_back_from_what_they_print_and_names_may_be_the_drivers_words() {
        let settings: ControlSettings = "gain=50, Exposure Time, Absolute=3".parse().unwrap_or_default();
        assert_eq!(settings, ControlSettings::default(), "a comma separates settings");
        let settings: ControlSettings = "gain=50, Auto Exposure=manual_mode".parse().unwrap();
        assert_eq!(settings.to_string(), "gain=50,auto_exposure=manual_mode");
        assert_eq!(settings.to_string().parse(), Ok(settings));
        assert_eq!("".parse(), Ok(ControlSettings::default()));
        for wrong in ["gain", "=5", "gain="] {
            let error = wrong.parse::<ControlSettings>().unwrap_err().to_string();
            assert!(error.contains(wrong) && error.contains("NAME=VALUE"), "{error}");
        }
    }

    #[test]
    fn names_are_the_words_of_the_driver_in_small_letters() {
        assert_eq!(identifier("Exposure Time, Absolute"), "exposure_time_absolute");
        assert_eq!(identifier("White Balance Temperature, Auto "), "white_balance_temperature_auto");
    }

    #[test]
    fn a_control_is_listed_with_its_range_and_what_its_values_mean() {
        let mut control = ControlInfo {
            name: "auto_exposure".into(),
            min: 0,
            max: 3,
            step: 1,
            default: 3,
            value: Some(1),
            menu: vec![(1, "Manual Mode".into())],
            inactive: false,
        };
        assert_eq!(control.to_string(), "auto_exposure = 1  (0 to 3, starts with 3) 1:manual_mode");
        control = ControlInfo { step: 5, value: None, menu: Vec::new(), inactive: true, ..control };
        assert_eq!(control.to_string(), "auto_exposure  (0 to 3 in steps of 5, starts with 3, inactive)");
    }
}
