//! The detectors that are compared, ours among them.

#[cfg(feature = "peers")]
mod apriltag_c;
#[cfg(feature = "peers")]
mod kornia;
#[cfg(feature = "peers")]
mod locus;
mod nothing;
mod ours;
mod paper;
mod python;

use std::path::PathBuf;

use tagbus_camera::picture::Picture;
use tagbus_detector::{Decimation, Refinement, Sampling, Search, Settings};

pub(crate) use paper::{Paper, Work};

type Failure = Box<dyn std::error::Error>;

/// A tag that a detector says is there. Where its corners start and which way round they go is the detector's affair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) id: u32,
    pub(crate) corners: [[f64; 2]; 4],
}

/// A detector under test.
pub(crate) trait Peer {
    /// Name and version.
    fn name(&self) -> String;
    /// Its decimation factor.
    fn factor(&self) -> f64;
    /// Its other settings in a few words; empty for its defaults.
    fn variant(&self) -> String;
    /// Gets ready for a picture, outside of what is timed: those that want pictures in memory of their own copy it.
    fn prepare(&mut self, _picture: &Picture) -> Result<(), Failure> {
        Ok(())
    }
    /// Searches the picture that was prepared and adds what it found.
    fn detect(&mut self, picture: &Picture, hits: &mut Vec<Hit>);
    /// CPU time of the last search in microseconds, of detectors that count it themselves because they run in another
    /// process.
    fn own_cpu_us(&self) -> Option<f64> {
        None
    }
}

/// None at all: what it costs to be measured.
pub(crate) fn none() -> Box<dyn Peer> {
    Box::new(nothing::Nothing)
}

/// Our detector with its defaults but for decimation.
pub(crate) fn ours(families: &str, factor: f64) -> Result<Box<dyn Peer>, Failure> {
    let decimation = Decimation::from_factor(factor)?;
    Ok(Box::new(ours::Ours::new(families, Settings { decimation, ..Settings::default() })?))
}

/// All detectors that this build has at one decimation factor, with their defaults otherwise; ours first. Several
/// families are separated by `+`.
pub(crate) fn all(family: &str, factor: f64) -> Result<Vec<Box<dyn Peer>>, Failure> {
    let mut peers: Vec<Box<dyn Peer>> = vec![ours(family, factor)?];
    #[cfg(feature = "peers")]
    peers.push(Box::new(apriltag_c::AprilTagC::new(family, factor, apriltag_c::DEFAULT_CONTRAST)?));
    peers.shrink_to_fit();
    Ok(peers)
}

/// Decimation factors, up to those at which next to nothing is found any more.
const FACTORS: [f64; 13] = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 16.0, 24.0];

/// Which detectors a sweep compares.
pub(crate) struct Choice {
    /// Those whose name, decimation and variant, with blanks between them, hold this text.
    pub(crate) only: String,
    /// A Python interpreter that has further detectors.
    pub(crate) python: Option<PathBuf>,
}

/// Every configuration that a sweep compares, ours first.
pub(crate) fn sweep(family: &str, choice: &Choice) -> Result<Vec<Box<dyn Peer>>, Failure> {
    let mut peers: Vec<Box<dyn Peer>> = Vec::new();
    for settings in our_settings()? {
        peers.push(Box::new(ours::Ours::new(family, settings)?));
    }
    #[cfg(feature = "peers")]
    add_others(family, &mut peers)?;
    let only = &choice.only;
    peers.retain(|peer| format!("{} {} {}", peer.name(), peer.factor(), peer.variant()).contains(only));
    if let Some(python) = &choice.python {
        // Not chosen from: its first configuration brings the pictures for all of them.
        peers.extend(python::all(python, family)?.into_iter().map(|peer| Box::new(peer) as Box<dyn Peer>));
    }
    match peers.is_empty() {
        true => Err(format!("no detector's name, decimation and settings hold \"{only}\"").into()),
        false => Ok(peers),
    }
}

/// Further ones of ours: up to where nothing is found, and between those at which little is.
const OUR_FACTORS: [f64; 12] = [9.0, 11.0, 13.0, 14.0, 18.0, 20.0, 28.0, 32.0, 48.0, 64.0, 96.0, 128.0];

/// What of ours is compared. The first of each decimation is what others are held against: with all that there is to
/// refinement.
fn our_settings() -> Result<Vec<Settings>, Failure> {
    let mut factors = [&FACTORS[..], &OUR_FACTORS[..]].concat();
    factors.sort_by(f64::total_cmp);
    let mut all = Vec::new();
    for factor in factors {
        let decimation = Decimation::from_factor(factor)?;
        let tag = Settings { decimation, refinement: Refinement::Tag, ..Settings::default() };
        all.push(tag.clone());
        let less = [Refinement::Edges, Refinement::None];
        all.extend(less.map(|refinement| Settings { refinement, ..tag.clone() }));
        if factor <= 3.0 {
            let searches = [Search::Fine, Search::Thorough];
            all.extend(searches.map(|search| Settings { search, ..tag.clone() }));
        }
        if (2.0..=4.0).contains(&factor) {
            let samplings = [Sampling::Mean, Sampling::Darkest];
            all.extend(samplings.map(|sampling| Settings { sampling, ..tag.clone() }));
        }
    }
    Ok(all)
}

/// Peers that do not know the family are left out.
#[cfg(feature = "peers")]
fn add_others(family: &str, peers: &mut Vec<Box<dyn Peer>>) -> Result<(), Failure> {
    for factor in FACTORS {
        // A tuned contrast limit is the cheapest way to make the C library fast on quiet pictures.
        let tuned: &[i32] = if factor == 1.0 || factor == 2.0 { &[10, 20, 40] } else { &[] };
        for contrast in std::iter::once(&apriltag_c::DEFAULT_CONTRAST).chain(tuned) {
            peers.push(Box::new(apriltag_c::AprilTagC::new(family, factor, *contrast)?));
        }
    }
    for factor in [1, 2, 3, 4, 6, 8, 12] {
        peers.extend(kornia::Kornia::new(family, factor).map(|peer| Box::new(peer) as Box<dyn Peer>));
    }
    for profile in locus::PROFILES {
        for factor in [1, 2, 3, 4] {
            peers.extend(
                locus::Locus::new(family, profile, factor).map(|peer| Box::new(peer) as Box<dyn Peer>),
            );
        }
    }
    Ok(())
}
