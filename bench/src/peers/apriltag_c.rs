//! The AprilTag C library with its defaults, on one thread.

#![allow(unsafe_code, reason = "a C library can only be called so; this feature is for measuring")]

use apriltag_sys as c;
use tagbus_camera::picture::Picture;

use super::Peer;

pub(super) struct AprilTagC {
    detector: *mut c::apriltag_detector_t,
    family: *mut c::apriltag_family_t,
    destroy: Destroy,
}

type Create = unsafe extern "C" fn() -> *mut c::apriltag_family_t;
type Destroy = unsafe extern "C" fn(*mut c::apriltag_family_t);

fn constructors(family: &str) -> Result<(Create, Destroy), String> {
    match family {
        "tag36h11" => Ok((c::tag36h11_create, c::tag36h11_destroy)),
        "tagStandard41h12" => Ok((c::tagStandard41h12_create, c::tagStandard41h12_destroy)),
        other => Err(format!("{other} is not compared with the C library: use tag36h11 or tagStandard41h12")),
    }
}

/// Corrected bits, the same as ours for these families.
const CORRECTED_BITS: i32 = 2;

impl AprilTagC {
    pub(super) fn new(family: &str, factor: f64) -> Result<Self, String> {
        let (create, destroy) = constructors(family)?;
        // SAFETY: takes nothing and gives a new object.
        let family = unsafe { create() };
        // SAFETY: takes nothing and gives a new object.
        let detector = unsafe { c::apriltag_detector_create() };
        // SAFETY: both objects were just made and live until `drop`.
        unsafe { c::apriltag_detector_add_family_bits(detector, family, CORRECTED_BITS) };
        // SAFETY: the detector was just made and nobody else has it.
        let settings = unsafe { &mut *detector };
        settings.nthreads = 1;
        settings.quad_decimate = factor as f32;
        Ok(Self { detector, family, destroy })
    }
}

impl Peer for AprilTagC {
    fn name(&self) -> String {
        "AprilTag C 3.4.5".to_owned()
    }

    fn detect(&mut self, picture: &Picture) -> usize {
        let side = |length: usize| i32::try_from(length).unwrap_or(0);
        let mut image = c::image_u8_t {
            width: side(picture.width),
            height: side(picture.height),
            stride: side(picture.width),
            // The library only reads the picture; its type has no const.
            buf: picture.luma.as_ptr().cast_mut(),
        };
        // SAFETY: the picture holds height rows of stride bytes and outlives the call.
        let found = unsafe { c::apriltag_detector_detect(self.detector, &raw mut image) };
        // SAFETY: the list that was just given is valid.
        let count = unsafe { (*found).size };
        // SAFETY: the list is given back once and not used again.
        unsafe { c::apriltag_detections_destroy(found) };
        usize::try_from(count).unwrap_or(0)
    }
}

impl Drop for AprilTagC {
    fn drop(&mut self) {
        // SAFETY: made in `new`, destroyed once, before the family that it uses.
        unsafe { c::apriltag_detector_destroy(self.detector) };
        // SAFETY: made in `new` by the constructor that belongs to this destructor, destroyed once.
        unsafe { (self.destroy)(self.family) };
    }
}
