//! The video devices of this machine, and what is missing when there are none.
//!
//! ```text
//! /dev/videoN                              path        always
//! /sys/class/video4linux/videoN/name       name        always, even without the right to open the device
//! /sys/.../videoN/device/driver            driver      always
//! /dev/v4l/by-id, by-path                  links       names that stay when numbers change; made by udev
//! ioctl                                    formats, controls     with the feature `v4l`
//! ```

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use tagbus_message::frame::Fourcc;

use crate::control::ControlInfo;
use crate::device;
use crate::libcamera;
use crate::order;

/// Drivers whose nodes give the raw data of a camera on the Raspberry Pi's ribbon connector, or belong to its image processor.
const RIBBON_DRIVERS: [&str; 5] = ["unicam", "rp1-cfe", "bcm2835-isp", "bcm2835-codec", "pispbe"];

pub(crate) const BUILD_ADVICE: &str = "this build cannot ask devices for their formats: install libclang \
    (`sudo apt-get install libclang1-14 libclang-common-14-dev`) and build with the feature v4l";

/// A video device.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceInfo {
    /// The node, such as `/dev/video0`.
    pub path: PathBuf,
    /// What the driver calls the device; empty when it says nothing.
    pub name: String,
    /// The kernel driver; empty when it is not known.
    pub driver: String,
    /// Names of the device that stay when its number changes: by id, then by path.
    pub links: Vec<PathBuf>,
    /// The formats that the device captures, or why they are not known.
    pub formats: Result<Vec<FormatInfo>, String>,
    /// What can be set.
    pub controls: Vec<ControlInfo>,
}

/// What a device answers when it is asked.
#[derive(Debug, Default)]
pub(crate) struct Answer {
    pub(crate) formats: Vec<FormatInfo>,
    pub(crate) controls: Vec<ControlInfo>,
}

/// A format that a device captures.
#[derive(Debug, Clone, PartialEq)]
pub struct FormatInfo {
    /// The pixel format.
    pub format: Fourcc,
    /// The driver's words for it.
    pub description: String,
    /// The sizes it comes in; empty when the driver does not say.
    pub sizes: Vec<SizeInfo>,
}

/// One size, or a range of sizes.
#[derive(Debug, Clone, PartialEq)]
pub struct SizeInfo {
    /// Smallest width and height, in pixels.
    pub min: (u32, u32),
    /// Largest width and height; equal to `min` for a single size.
    pub max: (u32, u32),
    /// Steps of width and height between them; 0 for a single size.
    pub step: (u32, u32),
    /// Frames a second at the smallest size; empty when the driver does not say.
    pub rates: Vec<RateInfo>,
}

/// One frame rate, or a range of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateInfo {
    /// Lowest rate, in frames a second.
    pub min: f64,
    /// Highest rate; equal to `min` for a single rate.
    pub max: f64,
}

impl fmt::Display for RateInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // At most two places, and none where they are zeros.
        let number = |rate: f64| (rate * 100.0).round() / 100.0;
        write!(f, "{}", number(self.min))?;
        if self.min == self.max { Ok(()) } else { write!(f, " to {}", number(self.max)) }
    }
}

impl fmt::Display for SizeInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.min.0, self.min.1)?;
        if self.min != self.max {
            write!(f, " to {}x{} in steps of {}x{}", self.max.0, self.max.1, self.step.0, self.step.1)?;
        }
        for (position, rate) in self.rates.iter().enumerate() {
            write!(f, "{}{rate}", if position == 0 { " at " } else { ", " })?;
        }
        if self.rates.is_empty() { Ok(()) } else { f.write_str(" frames/s") }
    }
}

impl fmt::Display for DeviceInfo {
    /// The device in one line, then a line for each link, format, size and control.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}  {}  (driver {})",
            self.path.display(),
            or_unknown(&self.name),
            or_unknown(&self.driver)
        )?;
        self.links.iter().try_for_each(|link| write!(f, "\n    {}", link.display()))?;
        let formats = match &self.formats {
            Ok(formats) => formats,
            Err(reason) => return write!(f, "\n    formats not known: {reason}"),
        };
        if formats.is_empty() {
            write!(f, "\n    captures nothing (metadata or output node)")?;
        }
        for format in formats {
            write!(f, "\n    {} ({})", format.format, format.description)?;
            for size in &format.sizes {
                write!(f, "\n        {size}")?;
            }
        }
        if !self.controls.is_empty() {
            write!(f, "\n    controls")?;
        }
        self.controls.iter().try_for_each(|control| write!(f, "\n        {control}"))
    }
}

fn or_unknown(text: &str) -> &str {
    if text.is_empty() { "unknown" } else { text }
}

/// Lists the video devices, sorted by number. A device that cannot be asked has its reason in place of formats.
#[must_use]
pub fn list_devices() -> Vec<DeviceInfo> {
    let mut found = list_video_devices();
    found.extend(libcamera::list());
    found
}

fn list_video_devices() -> Vec<DeviceInfo> {
    list_in(Path::new("/dev"), Path::new("/sys/class/video4linux"))
}

fn list_in(dev: &Path, sys: &Path) -> Vec<DeviceInfo> {
    let mut nodes: Vec<PathBuf> = fs::read_dir(dev)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_video_node(path))
        .collect();
    nodes.sort_by(|a, b| order::natural(a.as_os_str().as_encoded_bytes(), b.as_os_str().as_encoded_bytes()));
    nodes.into_iter().map(|path| describe(path, dev, sys)).collect()
}

/// `video` and a number: `video-dec0` and its like are decoders.
fn is_video_node(path: &Path) -> bool {
    let number = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_prefix("video"));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

fn describe(path: PathBuf, dev: &Path, sys: &Path) -> DeviceInfo {
    let about = sys.join(path.file_name().unwrap_or_default());
    let name = fs::read_to_string(about.join("name")).unwrap_or_default().trim().to_string();
    let driver = fs::read_link(about.join("device/driver")).unwrap_or_default();
    let driver = driver.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let links = links_to(&path, &dev.join("v4l"));
    let (formats, controls) = match device::ask(&path) {
        Ok(answer) => (Ok(answer.formats), answer.controls),
        Err(reason) => (Err(reason), Vec::new()),
    };
    DeviceInfo { path, name, driver, links, formats, controls }
}

/// The links in `by-id` and `by-path` that lead to a node, in this order.
fn links_to(node: &Path, folder: &Path) -> Vec<PathBuf> {
    let entries = |kind: &str| fs::read_dir(folder.join(kind)).into_iter().flatten().flatten();
    let links = ["by-id", "by-path"].into_iter().flat_map(entries).map(|entry| entry.path());
    let node = fs::canonicalize(node).ok();
    let mut links: Vec<PathBuf> =
        links.filter(|link| node.is_some() && fs::canonicalize(link).ok() == node).collect();
    links.sort();
    links
}

/// What stands in the way of using these devices, and the commands that help; one text for each finding.
#[must_use]
pub fn advice(devices: &[DeviceInfo]) -> Vec<String> {
    let mut advice = Vec::new();
    if devices.is_empty() {
        advice.push(
            "no /dev/video*: no video device is connected, or its driver is not loaded (`sudo dmesg | grep -i -e uvc -e video`); \
             in a container the device must be passed in (--device /dev/video0)"
                .to_string(),
        );
    }
    if devices
        .iter()
        .any(|device| matches!(&device.formats, Err(reason) if reason.contains("ermission denied")))
    {
        advice.push(
            "permission denied: join the group video (`sudo usermod -aG video $USER`), then log out and in"
                .to_string(),
        );
    }
    if devices.is_empty() || devices.iter().any(is_ribbon_node) {
        advice.push(
            "cameras on the Raspberry Pi's ribbon connector do not work as video devices: use --source rpicam \
             (`rpicam-hello --list-cameras` shows whether the camera is found)"
                .to_string(),
        );
    }
    if !cfg!(feature = "v4l") {
        advice.push(BUILD_ADVICE.to_string());
    }
    advice
}

fn is_ribbon_node(device: &DeviceInfo) -> bool {
    is_ribbon_driver(&device.driver)
}

/// Whether a driver belongs to the cameras on the Raspberry Pi's ribbon connector.
pub(crate) fn is_ribbon_driver(driver: &str) -> bool {
    RIBBON_DRIVERS.contains(&driver)
}

/// Text for a device that is not there.
#[cfg(feature = "v4l")]
pub(crate) fn why_absent(path: &Path, error: &std::io::Error) -> String {
    let present: Vec<String> =
        list_video_devices().iter().map(|found| found.path.display().to_string()).collect();
    let present = if present.is_empty() { "there are none".to_string() } else { present.join(" ") };
    format!("{}: {error}; video devices: {present} (see `tagbus camera --list`)", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;

    #[test]
    fn nodes_are_listed_by_number_with_name_and_driver_and_others_are_left_out() {
        let folder = TestFolder::new("devices");
        let (dev, sys) = (folder.path().join("dev"), folder.path().join("sys"));
        fs::create_dir_all(&dev).unwrap();
        for node in ["video10", "video2", "video-dec0", "video", "vide0", "null"] {
            fs::write(dev.join(node), "").unwrap();
        }
        fs::create_dir_all(sys.join("video2/device")).unwrap();
        fs::write(sys.join("video2/name"), "Some Camera: HD\n").unwrap();
        std::os::unix::fs::symlink("/sys/bus/usb/drivers/uvcvideo", sys.join("video2/device/driver"))
            .unwrap();
        for kind in ["by-path", "by-id"] {
            fs::create_dir_all(dev.join("v4l").join(kind)).unwrap();
            std::os::unix::fs::symlink("../../video2", dev.join("v4l").join(kind).join("camera")).unwrap();
        }
        let devices = list_in(&dev, &sys);
        assert_eq!(
            devices[0].links,
            ["by-id/camera", "by-path/camera"].map(|link| dev.join("v4l").join(link))
        );
        assert!(devices[1].links.is_empty());
        let paths: Vec<_> = devices.iter().map(|device| device.path.clone()).collect();
        assert_eq!(paths, [dev.join("video2"), dev.join("video10")]);
        assert_eq!((devices[0].name.as_str(), devices[0].driver.as_str()), ("Some Camera: HD", "uvcvideo"));
        // A plain file answers no ioctl: the row says so instead of the list failing.
        assert!(devices.iter().all(|device| device.formats.is_err()));
        assert!(devices[1].to_string().contains("formats not known"), "{}", devices[1]);
    }

    #[test]
    fn what_is_missing_is_said_with_the_command_that_helps() {
        let none = advice(&[]).join("\n");
        assert!(none.contains("no /dev/video*") && none.contains("rpicam"), "{none}");
        let device = |driver: &str, reason: &str| DeviceInfo {
            path: "/dev/video0".into(),
            name: "x".into(),
            driver: driver.into(),
            links: Vec::new(),
            formats: Err(reason.into()),
            controls: Vec::new(),
        };
        let denied = advice(&[device("uvcvideo", "Permission denied (os error 13)")]).join("\n");
        assert!(denied.contains("sudo usermod -aG video $USER") && !denied.contains("rpicam"), "{denied}");
        let ribbon = advice(&[device("rp1-cfe", "?")]).join("\n");
        assert!(ribbon.contains("rpicam-hello"), "{ribbon}");
    }

    #[test]
    fn sizes_are_printed_alone_or_as_a_range_with_their_rates() {
        let rate = |min, max| RateInfo { min, max };
        let rates = vec![rate(30.0, 30.0), rate(1000.0 / 33.0, 1000.0 / 33.0)];
        let one = SizeInfo { min: (640, 480), max: (640, 480), step: (0, 0), rates };
        let range = SizeInfo { min: (16, 16), max: (1920, 1080), step: (2, 4), rates: vec![rate(1.0, 60.0)] };
        assert_eq!(one.to_string(), "640x480 at 30, 30.3 frames/s");
        assert_eq!(range.to_string(), "16x16 to 1920x1080 in steps of 2x4 at 1 to 60 frames/s");
    }
}
