//! Which device is meant, also after it was unplugged and has come back under another number.
//!
//! ```text
//! /dev/v4l/by-id/...   the link says which device, at whatever socket: it is followed again
//! /dev/videoN          the device at this socket: looked for by its place in sysfs, since N is given out anew
//! ```

use std::fs;
use std::path::{Path, PathBuf};

/// What a device is known by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Identity {
    asked: PathBuf,
    /// Where it was plugged in when it was first seen; `None` where a link names it, or sysfs says nothing.
    socket: Option<Socket>,
}

/// A device's place in sysfs, and which of its nodes.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Socket {
    place: PathBuf,
    index: String,
}

impl Identity {
    /// The device that `path` names now.
    pub(super) fn of(path: &Path) -> Identity {
        Identity::in_sysfs(path, Path::new("/sys/class/video4linux"))
    }

    fn in_sysfs(path: &Path, sys: &Path) -> Identity {
        let is_link = fs::symlink_metadata(path).is_ok_and(|about| about.is_symlink());
        let socket = if is_link { None } else { socket_of(path, sys) };
        Identity { asked: path.into(), socket }
    }

    /// The node of the device at present: where it was, unless another device is there now or it is found elsewhere.
    pub(super) fn node(&self) -> Option<PathBuf> {
        self.node_in(Path::new("/dev"), Path::new("/sys/class/video4linux"))
    }

    fn node_in(&self, dev: &Path, sys: &Path) -> Option<PathBuf> {
        let Some(socket) = &self.socket else { return self.asked.exists().then(|| self.asked.clone()) };
        let is_it = |node: &PathBuf| node.exists() && socket_of(node, sys).as_ref() == Some(socket);
        if is_it(&self.asked) {
            return Some(self.asked.clone());
        }
        let nodes = fs::read_dir(sys).into_iter().flatten().flatten();
        nodes.map(|node| dev.join(node.file_name())).find(is_it)
    }
}

fn socket_of(node: &Path, sys: &Path) -> Option<Socket> {
    let about = sys.join(node.file_name()?);
    let place = fs::canonicalize(about.join("device")).ok()?;
    let index = fs::read_to_string(about.join("index")).unwrap_or_default();
    Some(Socket { place, index })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;
    use std::os::unix::fs::symlink;

    struct Machine(TestFolder);

    impl Machine {
        fn new() -> Machine {
            let machine = Machine(TestFolder::new("identity"));
            for folder in ["dev", "sys", "usb/1-1", "usb/1-2"] {
                fs::create_dir_all(machine.at(folder)).unwrap();
            }
            machine
        }

        fn at(&self, path: &str) -> PathBuf {
            self.0.path().join(path)
        }

        fn plug(&self, node: &str, socket: &str, index: u32) {
            fs::write(self.at("dev").join(node), "").unwrap();
            let about = self.at("sys").join(node);
            fs::create_dir_all(&about).unwrap();
            symlink(self.at(socket), about.join("device")).unwrap();
            fs::write(about.join("index"), format!("{index}\n")).unwrap();
        }

        fn unplug(&self, node: &str) {
            fs::remove_file(self.at("dev").join(node)).unwrap();
            fs::remove_dir_all(self.at("sys").join(node)).unwrap();
        }

        fn identity(&self, node: &str) -> Identity {
            Identity::in_sysfs(&self.at("dev").join(node), &self.at("sys"))
        }

        fn node(&self, identity: &Identity) -> Option<PathBuf> {
            identity.node_in(&self.at("dev"), &self.at("sys"))
        }
    }

    #[test]
    fn a_device_that_comes_back_under_another_number_is_found_by_its_socket() {
        let machine = Machine::new();
        machine.plug("video0", "usb/1-1", 0);
        machine.plug("video1", "usb/1-1", 1);
        let camera = machine.identity("video0");
        assert_eq!(machine.node(&camera), Some(machine.at("dev/video0")));
        machine.unplug("video0");
        machine.unplug("video1");
        assert_eq!(machine.node(&camera), None);
        // Another camera takes the number, and the first node of ours is the second in the list.
        machine.plug("video0", "usb/1-2", 0);
        machine.plug("video2", "usb/1-1", 1);
        machine.plug("video3", "usb/1-1", 0);
        assert_eq!(machine.node(&camera), Some(machine.at("dev/video3")));
    }

    #[test]
    fn a_link_is_followed_again() {
        let machine = Machine::new();
        machine.plug("video0", "usb/1-1", 0);
        let link = machine.at("dev/by-id");
        symlink(machine.at("dev/video0"), &link).unwrap();
        let camera = Identity::in_sysfs(&link, &machine.at("sys"));
        assert_eq!(machine.node(&camera), Some(link.clone()));
        machine.unplug("video0");
        assert_eq!(machine.node(&camera), None);
        machine.plug("video5", "usb/1-2", 0);
        fs::remove_file(&link).unwrap();
        symlink(machine.at("dev/video5"), &link).unwrap();
        assert_eq!(machine.node(&camera), Some(link));
    }
}
