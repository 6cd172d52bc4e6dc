//! What the frames of a data set have in common, and what changes from frame to frame.

use tagbus_scene::{Background, Tone};

/// A data set. Lengths in the world are those of the paper (III-E): tags are printed 4 cm wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Recipe {
    pub(crate) name: &'static str,
    /// One line for help and pages.
    pub(crate) about: &'static str,
    /// Width and height of a frame in pixels.
    pub(crate) size: [usize; 2],
    pub(crate) focal_px: f64,
    pub(crate) distances_cm: Span,
    /// Angles between the tag's axis and the line of sight.
    pub(crate) tilts_deg: [u32; 2],
    /// Frames of every distance and tilt that make up the full set of one family.
    pub(crate) repetitions: usize,
    pub(crate) ids: Ids,
    pub(crate) card: Card,
    /// Grey levels of black and white.
    pub(crate) ink: [f32; 2],
    /// How far black has spread into white, in cells.
    pub(crate) ink_spread_cells: f64,
    pub(crate) background: Background,
    pub(crate) blur_sigma: f32,
    pub(crate) noise_sigma: f32,
    pub(crate) vignetting: f32,
    pub(crate) motion_px: f64,
    pub(crate) tone: Tone,
    /// A lamp is mirrored somewhere in the tag.
    pub(crate) gloss: Gloss,
    /// Quality at which frames are encoded as JPEG and decoded again.
    pub(crate) jpeg_quality: Option<u8>,
}

/// Distances from the first to the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) step: u32,
}

/// Which tags are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ids {
    /// Ten of the family's, the same at every distance and tilt.
    Ten,
    /// Another one in every frame.
    Any,
    /// No tag at all: whatever is found is wrong.
    None,
}

/// What the tag is printed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Card {
    /// A white card that is this much wider than the print on every side.
    Margin { width_cm: f64 },
    /// White ends this many cells outside of where it is needed: from the border edge of tags that are dark inside
    /// their border, from the print's edge of others.
    Narrow { cells: f64 },
}

/// How paper mirrors lamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Gloss {
    Matt,
    Glossy,
}

/// Frames that are counted together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Bin {
    pub(crate) tilt_deg: u32,
    pub(crate) distance_cm: u32,
}

impl Span {
    pub(crate) fn values(self) -> Vec<u32> {
        (self.first..=self.last).step_by(self.step as usize).collect()
    }
}

impl Recipe {
    /// All bins, in the order of frames.
    pub(crate) fn bins(&self) -> Vec<Bin> {
        let of_tilt = |tilt_deg: u32| {
            self.distances_cm.values().into_iter().map(move |distance_cm| Bin { tilt_deg, distance_cm })
        };
        self.tilts_deg.into_iter().flat_map(of_tilt).collect()
    }

    /// Frames of the full set of one family.
    pub(crate) fn frame_count(&self) -> usize {
        self.bins().len() * self.repetitions
    }
}
