//! Parameters that are one of a few, as numbers in messages and as names for people.

use super::fault::ControlFault;

/// A choice with a code and a name each.
macro_rules! choice {
    ($(#[$about:meta])* $name:ident, $what:literal, $($(#[$says:meta])* $variant:ident = $code:literal $text:literal),+) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $name {
            $($(#[$says])* $variant = $code),+
        }

        impl $name {
            /// All of them with their names.
            pub const NAMES: [($name, &'static str); 3] = [$((Self::$variant, $text)),+];

            /// The choice of a code.
            pub fn from_code(code: u32) -> Result<Self, ControlFault> {
                match code {
                    $($code => Ok(Self::$variant),)+
                    seen => Err(ControlFault::Choice { what: $what, seen }),
                }
            }

            /// The choice of a name.
            #[must_use]
            pub fn named(name: &str) -> Option<Self> {
                Self::NAMES.into_iter().find(|(_, known)| *known == name).map(|(choice, _)| choice)
            }

            /// The number in messages.
            #[must_use]
            pub fn code(self) -> u32 {
                self as u32
            }

            /// Its name.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text),+
                }
            }
        }
    };
}

choice! {
    /// What decimation by a whole number makes of the pixels that become one.
    SamplingChoice, "sampling",
    /// One pixel of them.
    Point = 0 "point",
    /// Their mean.
    Mean = 1 "mean",
    /// The darkest of them.
    Darkest = 2 "darkest"
}

choice! {
    /// How hard quads are looked for.
    SearchChoice, "search",
    /// Once.
    Quick = 0 "quick",
    /// Once more with smaller windows.
    Fine = 1 "fine",
    /// As fine, and however little contrast there is.
    Thorough = 2 "thorough"
}

choice! {
    /// How the corners of a tag are refined.
    RefinementChoice, "refinement",
    /// Not at all.
    None = 0 "none",
    /// By the edges as they are seen.
    Edges = 1 "edges",
    /// By the whole tag as it was printed.
    Tag = 2 "tag"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_names_come_back() {
        for (choice, name) in SearchChoice::NAMES {
            assert_eq!(SearchChoice::from_code(choice.code()), Ok(choice));
            assert_eq!((SearchChoice::named(name), choice.name()), (Some(choice), name));
        }
        assert!(RefinementChoice::from_code(3).is_err() && SamplingChoice::from_code(u32::MAX).is_err());
    }
}
