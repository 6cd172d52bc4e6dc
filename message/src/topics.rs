//! Names of topics. The version is in the name: another layout is another topic.

use crate::domain::{DomainError, check_name};

/// `tagbus/v1/CAMERA/frames`: pictures as captured, and the event that one was sent.
pub fn frames(camera: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    Ok(format!("tagbus/v1/{camera}/frames"))
}

/// `tagbus/v1/CAMERA/info`: mode, controls in force, calibration and state of a camera.
pub fn info(camera: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    Ok(format!("tagbus/v1/{camera}/info"))
}

/// `tagbus/v1/CAMERA/detectors/DETECTOR/detections`: tags found, and the event that a message was sent.
pub fn detections(camera: &str, detector: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    check_name(detector)?;
    Ok(format!("tagbus/v1/{camera}/detectors/{detector}/detections"))
}

/// `tagbus/v1/CAMERA/control`: requests to a camera.
pub fn camera_control(camera: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    Ok(format!("tagbus/v1/{camera}/control"))
}

/// `tagbus/v1/CAMERA/detectors/DETECTOR/control`: requests to a detector.
pub fn detector_control(camera: &str, detector: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    check_name(detector)?;
    Ok(format!("tagbus/v1/{camera}/detectors/{detector}/control"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_contract() {
        assert_eq!(frames("cam0").unwrap(), "tagbus/v1/cam0/frames");
        assert_eq!(detections("cam0", "main").unwrap(), "tagbus/v1/cam0/detectors/main/detections");
        assert_eq!(camera_control("cam0").unwrap(), "tagbus/v1/cam0/control");
        assert_eq!(detector_control("cam0", "main").unwrap(), "tagbus/v1/cam0/detectors/main/control");
        assert!(info("a/b").is_err());
    }
}
