//! What can be chosen: the paper's way of each step, or the way that it replaced.

use std::fmt;

use crate::components::Unions;
use crate::decimate::Filter;
use crate::line::LineError;
use crate::outline::SortKey;
use crate::refine::Refinement;
use crate::sample::Sampling;

/// The steps of the pipeline; the default is what the paper does, without decimation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Pixels of the frame for each pixel of the decimated picture, along each axis; 1 for none.
    pub decimation: usize,
    /// How the decimated picture is made (III-C 1).
    pub filter: Filter,
    /// Which unions the search for components makes (III-C 2, figure 5).
    pub unions: Unions,
    /// What the points of a contour are sorted by (III-C 3, equation 2).
    pub sort_key: SortKey,
    /// How the error of a line is computed (III-C 3).
    pub line_error: LineError,
    /// Whether corners are refined on the frame at full resolution.
    pub refinement: Refinement,
    /// How grey levels are read between pixels (III-D).
    pub sampling: Sampling,
    /// The factor of the Laplacian in equation 5; 0 for no sharpening.
    pub sharpening: f64,
    /// Wrong bits that are corrected, at most what the family bears.
    pub hamming: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            decimation: 1,
            filter: Filter::PointSampling,
            unions: Unions::WithoutRedundant,
            sort_key: SortKey::Slope,
            line_error: LineError::Eigenvalue,
            refinement: Refinement::Gradients,
            sampling: Sampling::Bilinear,
            sharpening: 0.25,
            hamming: 2,
        }
    }
}

impl Options {
    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        if !(1..=64).contains(&self.decimation) {
            return Err(OptionsError::Decimation(self.decimation));
        }
        match (0.0..=10.0).contains(&self.sharpening) {
            true => Ok(()),
            false => Err(OptionsError::Sharpening(self.sharpening)),
        }
    }
}

/// Why a pipeline cannot be made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum OptionsError {
    /// Not from 1 to 64.
    Decimation(usize),
    /// Not from 0 to 10.
    Sharpening(f64),
    /// No family was given.
    NoFamily,
}

impl fmt::Display for OptionsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Decimation(seen) => {
                write!(f, "decimation {seen} is not possible: use a whole number from 1 to 64")
            }
            Self::Sharpening(seen) => {
                write!(f, "sharpening {seen} is not possible: use a number from 0 to 10")
            }
            Self::NoFamily => write!(f, "no tag family was given: name at least one, such as tag36h11"),
        }
    }
}

impl std::error::Error for OptionsError {}
