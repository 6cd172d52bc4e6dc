//! The detectors that are compared, ours among them.

#[cfg(feature = "peers")]
mod apriltag_c;
mod ours;

use tagbus_camera::picture::Picture;

/// A detector under test.
pub(crate) trait Peer {
    /// Name and version.
    fn name(&self) -> String;
    /// Searches a picture and says how many tags it found.
    fn detect(&mut self, picture: &Picture) -> usize;
}

/// All detectors that this build has, for one family and decimation factor; ours first.
pub(crate) fn all(family: &str, factor: f64) -> Result<Vec<Box<dyn Peer>>, Box<dyn std::error::Error>> {
    let mut peers: Vec<Box<dyn Peer>> = vec![Box::new(ours::Ours::new(family, factor)?)];
    #[cfg(feature = "peers")]
    peers.push(Box::new(apriltag_c::AprilTagC::new(family, factor)?));
    peers.shrink_to_fit();
    Ok(peers)
}
