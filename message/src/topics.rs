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

/// `tagbus/v1/CAMERA/stats`: what a camera counts about itself.
pub fn camera_stats(camera: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    Ok(format!("tagbus/v1/{camera}/stats"))
}

/// `tagbus/v1/CAMERA/detectors/DETECTOR/stats`: what a detector counts about itself.
pub fn detector_stats(camera: &str, detector: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    check_name(detector)?;
    Ok(format!("tagbus/v1/{camera}/detectors/{detector}/stats"))
}

/// `tagbus/v1/CAMERA/detectors/DETECTOR/clients`: what each of its clients counts about itself.
pub fn client_stats(camera: &str, detector: &str) -> Result<String, DomainError> {
    check_name(camera)?;
    check_name(detector)?;
    Ok(format!("tagbus/v1/{camera}/detectors/{detector}/clients"))
}

/// The cameras and detectors whose statistics are among these topics: `(camera, None)` or `(camera, Some(detector))`.
#[must_use]
pub fn recorded(topic: &str) -> Option<(&str, Option<&str>)> {
    let parts: Vec<&str> = topic.strip_prefix("tagbus/v1/")?.split('/').collect();
    match parts[..] {
        [camera, "stats"] => Some((camera, None)),
        [camera, "detectors", detector, "stats"] => Some((camera, Some(detector))),
        _ => None,
    }
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
        assert_eq!(recorded(&camera_stats("cam0").unwrap()), Some(("cam0", None)));
        assert_eq!(recorded(&detector_stats("cam0", "near").unwrap()), Some(("cam0", Some("near"))));
        assert_eq!(recorded(&client_stats("cam0", "near").unwrap()), None);
        assert!(info("a/b").is_err());
    }
}
