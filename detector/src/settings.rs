//! Everything that can be chosen about detection.

use std::fmt;

use crate::threads;

/// How much smaller the frame is made before quads are looked for. Decoding and refinement always use full resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimation {
    /// One value for `n` by `n` pixels (see [`Sampling`]); 1 means the frame as it is.
    Every(u32),
    /// Three pixels become two (area average): factor 1.5.
    ThreeToTwo,
}

impl Decimation {
    /// The decimation of a factor as users write it: 1.5 or a whole number from 1 to 128.
    pub fn from_factor(factor: f64) -> Result<Self, SettingsError> {
        if factor == 1.5 {
            Ok(Self::ThreeToTwo)
        } else if factor.fract() == 0.0 && (1.0..=128.0).contains(&factor) {
            Ok(Self::Every(factor as u32))
        } else {
            Err(SettingsError::Decimation(factor))
        }
    }

    /// Full-resolution pixels per decimated pixel.
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::Every(n) => f64::from(n),
            Self::ThreeToTwo => 1.5,
        }
    }
}

/// How the corners of a tag are refined on the full-resolution frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// Not at all: corners are those of the quad on the search grid.
    None,
    /// The four sides are moved to where grey values cross half-way between white and black. Follows the edges as they
    /// are seen, also where too much light has made white grow.
    Edges,
    /// After that the whole tag is laid over its pixels, with the growth of white as an unknown: corners where they
    /// are on the print, several times more exact. Costs 0.01 to 0.05 ms a tag, up to 0.15 where white has bloomed.
    Tag,
}

impl Refinement {
    /// All of them, with their names on the command line.
    pub const NAMES: [(Refinement, &'static str); 3] =
        [(Self::None, "none"), (Self::Edges, "edges"), (Self::Tag, "tag")];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Edges => "edges",
            Self::Tag => "tag",
        }
    }
}

/// What a value of the search grid is when a whole number of pixels becomes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// One pixel of them (the paper's way): quickest.
    Point,
    /// Their mean: finds some more small tags, and takes a little longer.
    Mean,
    /// The darkest of them: keeps thin black borders whole. At decimation 2 it finds most of the small tags with a black border
    /// that others lose, but loses those that have neighbours a few pixels away, and tags with a white border.
    Darkest,
}

impl Sampling {
    /// All of them, with their names on the command line.
    pub const NAMES: [(Sampling, &'static str); 3] =
        [(Self::Point, "point"), (Self::Mean, "mean"), (Self::Darkest, "darkest")];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Mean => "mean",
            Self::Darkest => "darkest",
        }
    }
}

/// How hard quads are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Once, with thresholds from windows of 12 pixels, where there is more contrast than the frame's noise explains.
    Quick,
    /// Once more with windows of 6 pixels: finds tags whose white margin is narrow, or darker than what lies beside it. Takes
    /// two to three times as long.
    Fine,
    /// As fine, and however little contrast there is (5 grey levels): finds tags that are hardly more than noise. Takes up to
    /// ten times as long on noisy frames.
    Thorough,
}

impl Search {
    /// All of them, with their names on the command line.
    pub const NAMES: [(Search, &'static str); 3] =
        [(Self::Quick, "quick"), (Self::Fine, "fine"), (Self::Thorough, "thorough")];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Fine => "fine",
            Self::Thorough => "thorough",
        }
    }
}

/// What the detector does; the defaults are what most cameras want.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How much smaller the frame is made for finding quads. Costs recall of small tags, saves most of the time.
    pub decimation: Decimation,
    /// What decimation makes of the pixels that become one. Without effect on decimation 1 and 1.5.
    pub sampling: Sampling,
    /// How hard quads are looked for.
    pub search: Search,
    /// Corrected bits allowed for every family; `None` takes each family's own default. Capped at what the family can bear.
    pub hamming: Option<u32>,
    /// How corners are refined on the full-resolution frame.
    pub refinement: Refinement,
    /// Strength of the sharpening of sampled cells (paper eq. 5), 0 for none.
    pub sharpening: f32,
    /// Detections below this decision margin (grey levels) are dropped.
    pub min_margin: f32,
    /// Only these ids are reported; empty means all.
    pub ids: Vec<u32>,
    /// Threads that work on a frame, the caller's included: 1 to 64. More than one save time on large or busy frames and cost
    /// some of it in all; the result is the same. With 1 none is started.
    pub threads: usize,
}

impl Settings {
    /// Refuses values that are out of range.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        Decimation::from_factor(self.decimation.factor())?;
        if !(0.0..=10.0).contains(&self.sharpening) {
            return Err(SettingsError::Sharpening(self.sharpening));
        }
        if !(1..=threads::MOST).contains(&self.threads) {
            return Err(SettingsError::Threads(self.threads));
        }
        Ok(())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            decimation: Decimation::Every(2),
            sampling: Sampling::Point,
            search: Search::Quick,
            hamming: None,
            refinement: Refinement::Edges,
            sharpening: 1.0,
            min_margin: 0.0,
            ids: Vec::new(),
            threads: 1,
        }
    }
}

/// Why settings were refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// Not 1.5 and not a whole number from 1 to 128.
    Decimation(f64),
    /// Not a finite number from 0 to 10.
    Sharpening(f32),
    /// Not a number from 1 to 128.
    Threads(usize),
    /// No family was given.
    NoFamily,
    /// The system started fewer threads than were asked for.
    NoThread(std::io::ErrorKind),
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Decimation(seen) => {
                write!(f, "decimation {seen} is not possible: use 1.5 or a whole number from 1 to 128")
            }
            Self::Sharpening(seen) => {
                write!(f, "sharpening {seen} is not possible: use a number from 0 to 10")
            }
            Self::Threads(seen) => {
                write!(f, "{seen} threads are not possible: use a number from 1 to {}", threads::MOST)
            }
            Self::NoThread(why) => {
                write!(f, "the system did not start a thread ({why}): use fewer threads")
            }
            Self::NoFamily => write!(f, "no tag family was given: name at least one, such as tag36h11"),
        }
    }
}

impl std::error::Error for SettingsError {}
