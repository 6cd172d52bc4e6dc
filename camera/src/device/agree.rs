//! Format, size and rate: asked of the device, taken as it gives them, and what it changed is reported.

use std::io;
use std::time::Duration;

use tagbus_message::frame::{Fourcc, GREY, MJPG, NV12, NV21, UYVY, YU12, YUYV};

use super::kernel::{DriverFormat, Port};
use super::layout::{Layout, layout};
use super::list::entries;
use crate::config::SourceOptions;
use crate::format::FrameShape;
use crate::unpack::Unpack;

/// A format that devices have, and what becomes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Usable {
    device: Fourcc,
    published: Fourcc,
    content: Content,
}

/// What a device's bytes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Pixels, published as they are.
    Pixels,
    /// Deeper, packed or mosaic values, of which luma of 8 bits is published.
    Packed(Unpack),
    /// JPEG pictures, of which the luma is published.
    Jpeg,
}

const fn pixels(device: &[u8; 4], published: Fourcc) -> Usable {
    Usable { device: Fourcc::new(*device), published, content: Content::Pixels }
}

/// For the table below only, which is made when this is compiled: what it does not know does not compile.
const fn packed(device: &[u8; 4]) -> Usable {
    let device = Fourcc::new(*device);
    let Some(unpack) = Unpack::of(device) else { panic!("the table names a format that nothing unpacks") };
    Usable { device, published: GREY, content: Content::Packed(unpack) }
}

/// The formats that can be used, best first: few bytes with contiguous luma, then luma between chroma, then what has to be
/// unpacked or decoded, and last what is no luma.
const USABLE: [Usable; 19] = [
    pixels(b"GREY", GREY),
    pixels(b"NV12", NV12),
    pixels(b"NV21", NV21),
    pixels(b"YU12", YU12),
    // As these, with planes in memories of their own.
    pixels(b"NM12", NV12),
    pixels(b"NM21", NV21),
    pixels(b"YM12", YU12),
    pixels(b"YUYV", YUYV),
    pixels(b"UYVY", UYVY),
    packed(b"Y10P"),
    packed(b"Y10 "),
    packed(b"Y12 "),
    packed(b"Y16 "),
    Usable { device: MJPG, published: GREY, content: Content::Jpeg },
    Usable { device: Fourcc::new(*b"JPEG"), published: GREY, content: Content::Jpeg },
    packed(b"GRBG"),
    packed(b"GBRG"),
    packed(b"RGGB"),
    packed(b"BA81"),
];

/// What was agreed with a device.
#[derive(Debug, Clone)]
pub(super) struct Agreement {
    pub(super) driver: DriverFormat,
    pub(super) content: Content,
    pub(super) layout: Layout,
    /// Nominal time from frame to frame; zero when the driver does not say.
    pub(super) frame_time: Duration,
    /// What was asked for and is not so.
    pub(super) changed: Vec<String>,
}

/// Why nothing could be agreed.
#[derive(Debug)]
pub(super) enum NoAgreement {
    /// A call failed.
    Call(&'static str, io::Error),
    /// The device has nothing that fits; the text says what it has.
    Unfit(String),
}

/// Asks for what the options say.
pub(super) fn agree(port: &Port, options: &SourceOptions) -> Result<Agreement, NoAgreement> {
    let offered = entries(|index| port.format_at(index))
        .map_err(|error| NoAgreement::Call("listing its formats", error))?;
    let offered: Vec<Fourcc> = offered.into_iter().map(|(format, _)| format).collect();
    let wanted = choose(options.format, &offered).map_err(NoAgreement::Unfit)?;
    let now = port.format().map_err(|error| NoAgreement::Call("asking for its format", error))?;
    let (width, height) = (options.width.unwrap_or(now.width), options.height.unwrap_or(now.height));
    FrameShape::grey(width, height).map_err(|error| NoAgreement::Unfit(error.to_string()))?;
    let given = port.set_format(wanted.device, width, height);
    let driver = given.map_err(|error| NoAgreement::Call("setting its format", error))?;
    let mut changed = Vec::new();
    note_changes([width, height], wanted.device, &driver, &mut changed);
    let usable = usable(driver.fourcc).ok_or_else(|| {
        NoAgreement::Unfit(format!("it gives {} instead of {}", driver.fourcc, wanted.device))
    })?;
    let layout = match usable.content {
        Content::Pixels => layout(usable.published, &driver).map_err(NoAgreement::Unfit)?,
        Content::Packed(unpack) => unpacked(unpack, &driver).map_err(NoAgreement::Unfit)?,
        Content::Jpeg => decoded(&driver).map_err(NoAgreement::Unfit)?,
    };
    let frame_time = agree_on_rate(port, options, &mut changed)?;
    Ok(Agreement { driver, content: usable.content, layout, frame_time, changed })
}

fn usable(format: Fourcc) -> Option<Usable> {
    USABLE.into_iter().find(|usable| usable.device == format)
}

/// The best of the offered formats, or the one that is asked for; a device may have it with planes apart only.
fn choose(asked: Option<Fourcc>, offered: &[Fourcc]) -> Result<Usable, String> {
    let fits = |usable: &Usable| {
        offered.contains(&usable.device)
            && asked.is_none_or(|asked| {
                usable.device == asked || (usable.published == asked && usable.content == Content::Pixels)
            })
    };
    USABLE.into_iter().find(fits).ok_or_else(|| {
        let list = |formats: &mut dyn Iterator<Item = Fourcc>| {
            formats.map(|format| format.to_string()).collect::<Vec<_>>().join(" ")
        };
        let offers = list(&mut offered.iter().copied());
        match asked {
            Some(asked) => format!("it does not offer {asked}; it offers {offers}"),
            None => format!(
                "none of the formats that it offers can be used ({offers}): one of {} can",
                list(&mut USABLE.iter().map(|usable| usable.device))
            ),
        }
    })
}

fn note_changes(asked: [u32; 2], format: Fourcc, given: &DriverFormat, changed: &mut Vec<String>) {
    if given.fourcc != format {
        changed.push(format!("{} instead of {format}", given.fourcc));
    }
    if [given.width, given.height] != asked {
        let [width, height] = asked;
        changed.push(format!("{}x{} instead of {width}x{height}", given.width, given.height));
    }
    if !given.progressive {
        changed.push("interlaced: rows of two moments in one frame".to_string());
    }
}

/// A frame that is decoded into rows without gaps.
fn decoded(driver: &DriverFormat) -> Result<Layout, String> {
    let shape = FrameShape::grey(driver.width, driver.height).map_err(|error| error.to_string())?;
    Ok(Layout { shape, places: Vec::new(), needed: Default::default() })
}

/// A frame that is unpacked into rows without gaps.
fn unpacked(unpack: Unpack, driver: &DriverFormat) -> Result<Layout, String> {
    let mut layout = decoded(driver)?;
    let stride = (driver.memories[0].stride as usize).max(unpack.row_bytes(driver.width as usize));
    layout.needed[0] = stride * (driver.height as usize - 1) + unpack.row_bytes(driver.width as usize);
    if (driver.memories[0].bytes as usize) < layout.needed[0] {
        let (says, needs) = (driver.memories[0].bytes, layout.needed[0]);
        return Err(format!("the driver states {says} bytes for a frame that takes {needs}"));
    }
    Ok(layout)
}

/// Frame rates are asked for in thousandths: 29.97 is a rate.
fn agree_on_rate(
    port: &Port,
    options: &SourceOptions,
    changed: &mut Vec<String>,
) -> Result<Duration, NoAgreement> {
    let Some(asked) = options.pace.framerate() else {
        let now = port.frame_time().map_err(|error| NoAgreement::Call("asking for its rate", error))?;
        return Ok(now.map_or(Duration::ZERO, duration));
    };
    let fraction = [1000, ((asked * 1000.0).round() as u32).max(1)];
    let given =
        port.set_frame_time(fraction).map_err(|error| NoAgreement::Call("setting its rate", error))?;
    let Some(given) = given else {
        changed.push(format!("the rate of the device's choice instead of {asked} frames/s"));
        return Ok(Duration::ZERO);
    };
    let time = duration(given);
    let rate = if time.is_zero() { 0.0 } else { 1.0 / time.as_secs_f64() };
    if (rate - asked).abs() > asked * 1e-3 {
        changed.push(format!("{rate:.2} frames/s instead of {asked}"));
    }
    Ok(time)
}

/// Zero for a fraction that is none.
fn duration([numerator, denominator]: [u32; 2]) -> Duration {
    if denominator == 0 {
        return Duration::ZERO;
    }
    Duration::from_secs_f64(f64::from(numerator) / f64::from(denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(names: &[&[u8; 4]]) -> Vec<Fourcc> {
        names.iter().map(|name| Fourcc::new(**name)).collect()
    }

    #[test]
    fn the_best_format_on_offer_is_chosen_unless_one_is_asked_for() {
        let webcam = codes(&[b"H264", b"MJPG", b"YUYV"]);
        assert_eq!(choose(None, &webcam).unwrap().device, YUYV);
        assert_eq!(choose(Some(MJPG), &webcam).unwrap().device, MJPG);
        let mono = codes(&[b"YUYV", b"GREY"]);
        assert_eq!(choose(None, &mono).unwrap().device, GREY);
    }

    #[test]
    fn a_format_with_planes_apart_serves_who_asks_for_its_like() {
        let apart = codes(&[b"NM12", b"YM12"]);
        assert_eq!(choose(Some(NV12), &apart).unwrap().device, Fourcc::new(*b"NM12"));
        let both = codes(&[b"NM12", b"NV12"]);
        assert_eq!(choose(Some(NV12), &both).unwrap().device, NV12);
        // Luma decoded or unpacked is not what a device means by GREY.
        assert!(choose(Some(GREY), &codes(&[b"MJPG", b"Y10P"])).is_err());
    }

    #[test]
    fn what_is_not_on_offer_is_refused_with_what_is() {
        let error = choose(Some(GREY), &codes(&[b"YUYV", b"MJPG"])).unwrap_err();
        assert!(error.contains("GREY") && error.contains("it offers YUYV MJPG"), "{error}");
        let error = choose(None, &codes(&[b"H264"])).unwrap_err();
        assert!(error.contains("(H264)") && error.contains("NV12"), "{error}");
    }

    #[test]
    fn a_fraction_that_is_none_is_no_time() {
        assert_eq!(duration([1, 0]), Duration::ZERO);
        assert_eq!(duration([1001, 30_000]).as_micros(), 33_366);
    }
}
