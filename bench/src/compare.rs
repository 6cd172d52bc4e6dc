//! Detectors on the same pictures in the same run, taking turns.

use std::path::{Path, PathBuf};

use tagbus_camera::picture::{Picture, PictureError, load_grey};

use crate::clock::cpu_us;
use crate::peers;

/// A picture and the name that tables call it by.
pub(crate) struct Named {
    name: String,
    picture: Picture,
}

/// One detector on one picture at one decimation.
pub(crate) struct Row {
    pub(crate) picture: String,
    pub(crate) size: [usize; 2],
    pub(crate) factor: f64,
    pub(crate) peer: String,
    pub(crate) found: usize,
    /// CPU time of the quickest and of the middle round, microseconds.
    pub(crate) min_us: f64,
    pub(crate) median_us: f64,
}

/// Loads the pictures, grey.
pub(crate) fn load(paths: &[PathBuf]) -> Result<Vec<Named>, PictureError> {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    paths.iter().map(|path| Ok(Named { name: name(path), picture: load_grey(path)? })).collect()
}

/// Times every detector on every picture. In each round all detectors take one turn on a picture before the next one
/// comes, so that what else the machine does hits all alike; the first round only warms up.
pub(crate) fn run(
    pictures: &[Named],
    family: &str,
    factors: &[f64],
    rounds: usize,
) -> Result<Vec<Row>, Box<dyn std::error::Error>> {
    let mut rows = Vec::new();
    for factor in factors {
        for Named { name, picture } in pictures {
            let mut peers = peers::all(family, *factor)?;
            let mut times = vec![Vec::with_capacity(rounds); peers.len()];
            let mut found = vec![0; peers.len()];
            for round in 0..=rounds {
                for (i, peer) in peers.iter_mut().enumerate() {
                    let mut hits = Vec::new();
                    peer.prepare(picture)?;
                    let (us, ()) = cpu_us(|| peer.detect(picture, &mut hits));
                    found[i] = hits.len();
                    if round > 0 {
                        times[i].push(us);
                    }
                }
            }
            for ((peer, times), found) in peers.iter().zip(&mut times).zip(found) {
                times.sort_by(f64::total_cmp);
                rows.push(Row {
                    picture: name.clone(),
                    size: [picture.width, picture.height],
                    factor: *factor,
                    peer: peer.name(),
                    found,
                    min_us: times.first().copied().unwrap_or(0.0),
                    median_us: times.get(times.len() / 2).copied().unwrap_or(0.0),
                });
            }
        }
    }
    Ok(rows)
}
