//! The video devices of this machine, and what is missing when there are none.
//!
//! ```text
//! /dev/videoN                              path        always
//! /sys/class/video4linux/videoN/name       name        always, even without the right to open the device
//! /sys/.../videoN/device/driver            driver      always
//! ioctl                                    formats     with the feature `v4l`
//! ```

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use tagbus_message::frame::Fourcc;

use crate::order;

/// Drivers whose nodes give the raw data of a camera on the Raspberry Pi's ribbon connector, or belong to its image processor.
const RIBBON_DRIVERS: [&str; 5] = ["unicam", "rp1-cfe", "bcm2835-isp", "bcm2835-codec", "pispbe"];

const BUILD_ADVICE: &str = "this build cannot ask devices for their formats: install libclang \
    (`sudo apt-get install libclang1-14 libclang-common-14-dev`) and build with the feature v4l";

/// A video device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The node, such as `/dev/video0`.
    pub path: PathBuf,
    /// What the driver calls the device; empty when it says nothing.
    pub name: String,
    /// The kernel driver; empty when it is not known.
    pub driver: String,
    /// The formats that the device captures, or why they are not known.
    pub formats: Result<Vec<FormatInfo>, String>,
}

/// A format that a device captures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormatInfo {
    /// The pixel format.
    pub format: Fourcc,
    /// The driver's words for it.
    pub description: String,
    /// The sizes it comes in; empty when the driver does not say.
    pub sizes: Vec<SizeInfo>,
}

/// One size, or a range of sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SizeInfo {
    /// Smallest width and height, in pixels.
    pub min: (u32, u32),
    /// Largest width and height; equal to `min` for a single size.
    pub max: (u32, u32),
    /// Steps of width and height between them; 0 for a single size.
    pub step: (u32, u32),
}

impl fmt::Display for SizeInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.min.0, self.min.1)?;
        if self.min == self.max {
            return Ok(());
        }
        write!(f, " to {}x{} in steps of {}x{}", self.max.0, self.max.1, self.step.0, self.step.1)
    }
}

impl fmt::Display for DeviceInfo {
    /// The device in one line, its formats in one more line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}  {}  (driver {})",
            self.path.display(),
            or_unknown(&self.name),
            or_unknown(&self.driver)
        )?;
        let formats = match &self.formats {
            Ok(formats) => formats,
            Err(reason) => return write!(f, "\n    formats not known: {reason}"),
        };
        if formats.is_empty() {
            write!(f, "\n    captures nothing (metadata or output node)")?;
        }
        for format in formats {
            write!(f, "\n    {} ({}):", format.format, format.description)?;
            for (position, size) in format.sizes.iter().enumerate() {
                write!(f, "{} {size}", if position == 0 { "" } else { "," })?;
            }
        }
        Ok(())
    }
}

fn or_unknown(text: &str) -> &str {
    if text.is_empty() { "unknown" } else { text }
}

/// Lists the video devices, sorted by number. A device that cannot be asked has its reason in place of formats.
#[must_use]
pub fn list_devices() -> Vec<DeviceInfo> {
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
    nodes.into_iter().map(|path| describe(path, sys)).collect()
}

/// `video` and a number: `video-dec0` and its like are decoders.
fn is_video_node(path: &Path) -> bool {
    let number = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_prefix("video"));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

fn describe(path: PathBuf, sys: &Path) -> DeviceInfo {
    let about = sys.join(path.file_name().unwrap_or_default());
    let name = fs::read_to_string(about.join("name")).unwrap_or_default().trim().to_string();
    let driver = fs::read_link(about.join("device/driver")).unwrap_or_default();
    let driver = driver.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let formats = ask::formats(&path);
    DeviceInfo { path, name, driver, formats }
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
            "cameras on the Raspberry Pi's ribbon connector do not work as video devices: they need rpicam \
             (`rpicam-hello --list-cameras`)"
                .to_string(),
        );
    }
    if !cfg!(feature = "v4l") {
        advice.push(BUILD_ADVICE.to_string());
    }
    advice
}

fn is_ribbon_node(device: &DeviceInfo) -> bool {
    RIBBON_DRIVERS.contains(&device.driver.as_str())
}

/// Why no frames come from this device: missing, no video device, or not part of this version.
pub(crate) fn why_not_streaming(path: &Path) -> String {
    let device = path.display();
    if let Err(error) = fs::metadata(path) {
        let present: Vec<String> =
            list_devices().iter().map(|found| found.path.display().to_string()).collect();
        let present = if present.is_empty() { "there are none".to_string() } else { present.join(" ") };
        return format!("{device}: {error}; video devices: {present} (see `tagbus camera --list`)");
    }
    format!(
        "{device} is there, but taking frames from devices is not part of this version; \
         use --source scene or --source replay:PATH"
    )
}

#[cfg(feature = "v4l")]
mod ask {
    //! Asks a device for its formats.

    use std::io;
    use std::panic;
    use std::path::Path;

    use tagbus_message::frame::Fourcc;
    use v4l::framesize::FrameSizeEnum;
    use v4l::video::Capture;

    use super::{FormatInfo, SizeInfo};

    /// The formats of a device, or why it does not tell.
    pub(super) fn formats(path: &Path) -> Result<Vec<FormatInfo>, String> {
        // The crate v4l 0.14 unwraps what drivers say (names that are not UTF-8): one odd device must not end the list.
        match panic::catch_unwind(|| query(path)) {
            Ok(answer) => answer.map_err(|error| error.to_string()),
            Err(_) => Err("the driver's answer could not be understood".to_string()),
        }
    }

    fn query(path: &Path) -> io::Result<Vec<FormatInfo>> {
        let device = v4l::Device::with_path(path)?;
        let abilities = device.query_caps()?.capabilities;
        let mut formats = Vec::new();
        for found in device.enum_formats()? {
            // A driver may know no sizes for a format; that is no reason to leave the format out.
            let sizes = device.enum_framesizes(found.fourcc).unwrap_or_default();
            formats.push(FormatInfo {
                format: Fourcc::new(found.fourcc.repr),
                description: found.description,
                sizes: sizes.into_iter().map(|size| size_info(size.size)).collect(),
            });
        }
        if formats.is_empty() && abilities.contains(v4l::capability::Flags::VIDEO_CAPTURE_MPLANE) {
            return Err(io::Error::other(
                "a device with several planes a frame, whose formats are not listed",
            ));
        }
        Ok(formats)
    }

    fn size_info(size: FrameSizeEnum) -> SizeInfo {
        match size {
            FrameSizeEnum::Discrete(one) => {
                SizeInfo { min: (one.width, one.height), max: (one.width, one.height), step: (0, 0) }
            }
            FrameSizeEnum::Stepwise(range) => SizeInfo {
                min: (range.min_width, range.min_height),
                max: (range.max_width, range.max_height),
                step: (range.step_width, range.step_height),
            },
        }
    }
}

#[cfg(not(feature = "v4l"))]
mod ask {
    //! Stands in where the build has no access to devices.

    use std::path::Path;

    use super::FormatInfo;

    /// Says why formats are not known; a device without rights is named as such here too.
    pub(super) fn formats(path: &Path) -> Result<Vec<FormatInfo>, String> {
        match std::fs::File::open(path) {
            Err(error) => Err(error.to_string()),
            Ok(_) => Err("built without the feature v4l".to_string()),
        }
    }
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
        let devices = list_in(&dev, &sys);
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
            formats: Err(reason.into()),
        };
        let denied = advice(&[device("uvcvideo", "Permission denied (os error 13)")]).join("\n");
        assert!(denied.contains("sudo usermod -aG video $USER") && !denied.contains("rpicam"), "{denied}");
        let ribbon = advice(&[device("rp1-cfe", "?")]).join("\n");
        assert!(ribbon.contains("rpicam-hello"), "{ribbon}");
    }

    #[test]
    fn a_missing_device_is_told_from_one_that_is_there() {
        let missing = why_not_streaming(Path::new("/dev/video-none"));
        assert!(missing.contains("/dev/video-none: No such file"), "{missing}");
        let there = why_not_streaming(Path::new("/dev/null"));
        assert!(there.contains("not part of this version"), "{there}");
    }

    #[test]
    fn sizes_are_printed_alone_or_as_a_range() {
        let one = SizeInfo { min: (640, 480), max: (640, 480), step: (0, 0) };
        let range = SizeInfo { min: (16, 16), max: (1920, 1080), step: (2, 4) };
        assert_eq!(one.to_string(), "640x480");
        assert_eq!(range.to_string(), "16x16 to 1920x1080 in steps of 2x4");
    }
}
