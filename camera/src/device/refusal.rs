//! Why a device cannot be used, in words that help.

use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::io::Errno;

use super::kernel::About;
use crate::devices;

/// Text for a call that failed while `doing` something with the device at `path`.
pub(super) fn call(path: &Path, doing: &str, error: &io::Error) -> String {
    let device = path.display();
    let errno = error.raw_os_error().map(Errno::from_raw_os_error);
    match errno {
        Some(Errno::NOENT) => devices::why_absent(path, error),
        Some(Errno::ACCESS | Errno::PERM) => {
            let group = group_of(path);
            format!(
                "{device}: permission denied: the device belongs to the group {group}; join it \
                 (`sudo usermod -aG {group} $USER`), then log out and in"
            )
        }
        Some(Errno::BUSY) => format!(
            "{device}: busy while {doing}: another program streams from it; end it (`fuser -v {device}` names it) or use another device"
        ),
        Some(Errno::PIPE | Errno::NOLINK) => format!(
            "{device}: {doing} failed: its parts are not linked, or their formats do not fit each other: set them to one size and format \
             (`media-ctl -p` shows them, `media-ctl -V` sets them)"
        ),
        Some(Errno::NOTTY | Errno::INVAL) if doing == ASKING => {
            format!("{device}: not a video device; `tagbus camera --list` shows those there are")
        }
        _ => format!("{device}: {doing} failed: {error}"),
    }
}

/// The first thing that is done with a device; whoever refuses it is no video device.
pub(super) const ASKING: &str = "asking what it is";

/// Text for a device that no pictures can be taken from; `None` for all others.
pub(super) fn unsuitable(path: &Path, about: &About) -> Option<String> {
    let device = path.display();
    let About { driver, card, captures, streams } = about;
    if devices::is_ribbon_driver(driver) {
        return Some(format!(
            "{device}: {card} (driver {driver}) belongs to a camera on the Raspberry Pi's ribbon connector, whose pictures have to be \
             made by libcamera: use --source rpicam (`rpicam-hello --list-cameras` shows whether the camera is found)"
        ));
    }
    if captures.is_none() {
        return Some(format!(
            "{device}: {card} (driver {driver}) does not capture pictures (an output, a codec, or metadata of a camera); \
             `tagbus camera --list` shows what others do"
        ));
    }
    if !streams {
        return Some(format!(
            "{device}: {card} (driver {driver}) only hands out bytes to read, and no buffers"
        ));
    }
    None
}

/// The name of the group that may use a device, `video` where it cannot be found out.
fn group_of(path: &Path) -> String {
    let name = || {
        let id = fs::metadata(path).ok()?.gid().to_string();
        group_in(&fs::read_to_string("/etc/group").ok()?, &id)
    };
    name().unwrap_or_else(|| "video".to_string())
}

/// The name of the group with this number in a file like `/etc/group`.
fn group_in(groups: &str, id: &str) -> Option<String> {
    let mut fields = groups.lines().map(|line| line.split(':').collect::<Vec<_>>());
    fields.find(|fields| fields.get(2) == Some(&id)).map(|fields| fields[0].to_string())
}

#[cfg(test)]
mod tests {
    use super::super::kernel::Planes;
    use super::*;

    fn said(errno: Errno, doing: &str) -> String {
        call(Path::new("/dev/null"), doing, &io::Error::from(errno))
    }

    #[test]
    fn each_refusal_of_the_system_says_what_to_do() {
        let denied = said(Errno::ACCESS, "opening it");
        assert!(
            denied.contains("/dev/null: permission denied") && denied.contains("usermod -aG"),
            "{denied}"
        );
        let busy = said(Errno::BUSY, "setting its format");
        assert!(busy.contains("busy") && busy.contains("fuser -v /dev/null"), "{busy}");
        assert!(said(Errno::NOTTY, ASKING).contains("not a video device"));
        assert!(said(Errno::NOENT, "opening it").contains("tagbus camera --list"));
        let parts = said(Errno::PIPE, "starting it");
        assert!(parts.contains("do not fit each other") && parts.contains("media-ctl -V"), "{parts}");
        let other = said(Errno::IO, "starting it");
        assert!(other.contains("starting it failed: Input/output error"), "{other}");
    }

    #[test]
    fn the_group_to_join_is_found_by_its_number() {
        let groups = "root:x:0:\nvideo:x:44:\nplugdev:x:46:pi\nbroken\n";
        assert_eq!(group_in(groups, "46").as_deref(), Some("plugdev"));
        assert_eq!(group_in(groups, "45"), None);
    }

    #[test]
    fn nodes_that_give_no_pictures_are_refused_with_the_way_out() {
        let about = |driver: &str, captures, streams| About {
            driver: driver.into(),
            card: "card".into(),
            captures,
            streams,
        };
        let text = |about| unsuitable(Path::new("/dev/video7"), &about).unwrap_or_default();
        let ribbon = text(about("rp1-cfe", Some(Planes::Single), true));
        assert!(ribbon.contains("--source rpicam") && ribbon.contains("rp1-cfe"), "{ribbon}");
        assert!(text(about("vivid", None, true)).contains("does not capture pictures"));
        assert!(text(about("old", Some(Planes::Single), false)).contains("no buffers"));
        assert_eq!(text(about("uvcvideo", Some(Planes::Single), true)), "");
    }
}
