//! The AprilTag C library on one thread, with its defaults but for decimation and the contrast limit.

#![allow(unsafe_code, reason = "a C library can only be called so; this feature is for measuring")]

use apriltag_sys as c;
use tagbus_camera::picture::Picture;

use super::{Hit, Peer};

pub(super) struct AprilTagC {
    detector: *mut c::apriltag_detector_t,
    families: Vec<Owned>,
    factor: f64,
    contrast: i32,
}

type Create = unsafe extern "C" fn() -> *mut c::apriltag_family_t;
type Destroy = unsafe extern "C" fn(*mut c::apriltag_family_t);

/// A family and what gives it back.
struct Owned {
    family: *mut c::apriltag_family_t,
    destroy: Destroy,
}

/// A family's constructor and destructor, and how many bits are corrected: as many as ours.
fn constructors(family: &str) -> Result<(Create, Destroy, i32), String> {
    match family {
        "tag36h11" => Ok((c::tag36h11_create, c::tag36h11_destroy, 2)),
        "tagStandard41h12" => Ok((c::tagStandard41h12_create, c::tagStandard41h12_destroy, 2)),
        "tagCustom48h12" => Ok((c::tagCustom48h12_create, c::tagCustom48h12_destroy, 1)),
        other => Err(format!(
            "{other} is not compared with the C library: use tag36h11, tagStandard41h12 or tagCustom48h12"
        )),
    }
}

/// The library's own limit of contrast within a tile (`qtp.min_white_black_diff`), grey levels.
pub(super) const DEFAULT_CONTRAST: i32 = 5;

impl AprilTagC {
    /// Families are separated by `+`.
    pub(super) fn new(families: &str, factor: f64, contrast: i32) -> Result<Self, String> {
        // SAFETY: takes nothing and gives a new object.
        let detector = unsafe { c::apriltag_detector_create() };
        // From here on `drop` cleans up.
        let mut this = Self { detector, families: Vec::new(), factor, contrast };
        for name in families.split('+') {
            this.add(name)?;
        }
        // SAFETY: the detector was just made and nobody else has it.
        let settings = unsafe { &mut *detector };
        settings.nthreads = 1;
        settings.quad_decimate = factor as f32;
        settings.qtp.min_white_black_diff = contrast;
        Ok(this)
    }

    fn add(&mut self, name: &str) -> Result<(), String> {
        let (create, destroy, corrected_bits) = constructors(name)?;
        // SAFETY: takes nothing and gives a new object.
        let family = unsafe { create() };
        self.families.push(Owned { family, destroy });
        // SAFETY: the detector lives until `drop`, and the family as long.
        unsafe { c::apriltag_detector_add_family_bits(self.detector, family, corrected_bits) };
        Ok(())
    }
}

impl Peer for AprilTagC {
    fn name(&self) -> String {
        "AprilTag C 3.4.5".to_owned()
    }

    fn factor(&self) -> f64 {
        self.factor
    }

    fn variant(&self) -> String {
        format!("contrast {}", self.contrast)
    }

    fn detect(&mut self, picture: &Picture, hits: &mut Vec<Hit>) {
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
        hits.extend(pointers(found).into_iter().map(hit));
        // SAFETY: the list is given back once and not used again.
        unsafe { c::apriltag_detections_destroy(found) };
    }
}

/// The elements of the library's list, which holds pointers to detections.
fn pointers(found: *const c::zarray_t) -> Vec<*const c::apriltag_detection_t> {
    // SAFETY: the list was just given by the library and is not changed meanwhile.
    let list = unsafe { &*found };
    let first = list.data.cast::<*const c::apriltag_detection_t>();
    (0..usize::try_from(list.size).unwrap_or(0))
        // SAFETY: the list holds `size` pointers, one after another.
        .map(|index| unsafe { first.wrapping_add(index).read_unaligned() })
        .collect()
}

fn hit(detection: *const c::apriltag_detection_t) -> Hit {
    // SAFETY: taken from the library's list, which still lives.
    let detection = unsafe { &*detection };
    Hit { id: u32::try_from(detection.id).unwrap_or(u32::MAX), corners: detection.p }
}

impl Drop for AprilTagC {
    fn drop(&mut self) {
        // SAFETY: made in `new`, destroyed once, before the families that it uses.
        unsafe { c::apriltag_detector_destroy(self.detector) };
        for Owned { family, destroy } in &self.families {
            // SAFETY: made in `add` by the constructor that belongs to this destructor, destroyed once.
            unsafe { destroy(*family) };
        }
    }
}
