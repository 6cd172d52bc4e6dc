//! Searches one picture with one detector so many times, and prints how many tags the last search found.
//!
//! ```text
//! search tagbus|c FAMILY DECIMATION TIMES PICTURE
//! ```
//!
//! What one more search costs is the difference between two runs; reading the picture and making the detector drop out.

use std::error::Error;

use apriltag_sys as c;
use image::GrayImage;
use tagbus_detector::{Decimation, Detector, LumaView, Settings};
use tagbus_family::Family;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [detector, family, factor, times, picture] = arguments.as_slice() else {
        return Err("usage: search tagbus|c FAMILY DECIMATION TIMES PICTURE".into());
    };
    let (factor, times): (f64, usize) = (factor.parse()?, times.parse()?);
    let picture = image::open(picture)?.into_luma8();
    let found = match detector.as_str() {
        "tagbus" => search_with_ours(&picture, family, factor, times)?,
        "c" => search_with_c(&picture, family, factor, times)?,
        other => return Err(format!("there is no detector {other}: use tagbus or c").into()),
    };
    println!("{found}");
    Ok(())
}

fn search_with_ours(
    picture: &GrayImage,
    family: &str,
    factor: f64,
    times: usize,
) -> Result<usize, Box<dyn Error>> {
    let settings = Settings { decimation: Decimation::from_factor(factor)?, ..Settings::default() };
    let mut detector = Detector::new(&[Family::published(family)?], &settings)?;
    let view = LumaView::grey(picture.as_raw(), picture.width() as usize, picture.height() as usize)?;
    Ok((0..times).map(|_| detector.detect(&view).len()).last().unwrap_or(0))
}

/// One thread, two corrected bits (as ours for these families), defaults otherwise.
fn search_with_c(
    picture: &GrayImage,
    family: &str,
    factor: f64,
    times: usize,
) -> Result<usize, Box<dyn Error>> {
    let create = match family {
        "tag36h11" => c::tag36h11_create,
        "tagStandard41h12" => c::tagStandard41h12_create,
        other => return Err(format!("{other} is not compared: use tag36h11 or tagStandard41h12").into()),
    };
    // SAFETY: takes nothing and gives a new object.
    let family = unsafe { create() };
    // SAFETY: takes nothing and gives a new object.
    let detector = unsafe { c::apriltag_detector_create() };
    // SAFETY: both were just made and live until the process ends.
    unsafe { c::apriltag_detector_add_family_bits(detector, family, 2) };
    // SAFETY: the detector was just made and nobody else has it.
    let settings = unsafe { &mut *detector };
    settings.nthreads = 1;
    settings.quad_decimate = factor as f32;
    let mut image = c::image_u8_t {
        width: i32::try_from(picture.width())?,
        height: i32::try_from(picture.height())?,
        stride: i32::try_from(picture.width())?,
        // The library only reads the picture; its type has no const.
        buf: picture.as_raw().as_ptr().cast_mut(),
    };
    let mut found = 0;
    for _ in 0..times {
        // SAFETY: the picture holds height rows of stride bytes and outlives the call.
        let list = unsafe { c::apriltag_detector_detect(detector, &raw mut image) };
        // SAFETY: the list was just given by the library.
        found = unsafe { (*list).size };
        // SAFETY: the list is given back once and not used again.
        unsafe { c::apriltag_detections_destroy(list) };
    }
    Ok(usize::try_from(found)?)
}
