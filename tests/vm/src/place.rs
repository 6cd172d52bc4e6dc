//! Where in which shared memory an address of a process lies: the same for every process that has mapped it.

use std::fs;

use crate::Failure;

/// A byte of a file that processes have mapped.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    /// Device and number of the file, as `/proc/PID/maps` writes them.
    file: String,
    offset: u64,
}

/// The mappings of a process.
pub(crate) struct Mappings(String);

impl Mappings {
    /// Of a process by its number, or of this one (`self`).
    pub(crate) fn of(process: &str) -> Result<Mappings, Failure> {
        Ok(Mappings(fs::read_to_string(format!("/proc/{process}/maps"))?))
    }

    /// Where an address lies; `None` where no file is mapped there.
    pub(crate) fn place(&self, address: u64) -> Option<Place> {
        self.0.lines().find_map(|line| place_in(line, address))
    }
}

/// A line is `start-end access offset device inode path`.
fn place_in(line: &str, address: u64) -> Option<Place> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let [range, _, offset, device, inode, ..] = fields.as_slice() else { return None };
    let (start, end) = range.split_once('-')?;
    let hex = |text: &str| u64::from_str_radix(text, 16).ok();
    let (start, end, offset) = (hex(start)?, hex(end)?, hex(offset)?);
    let is_file = *inode != "0" && (start..end).contains(&address);
    is_file.then(|| Place { file: format!("{device} {inode}"), offset: offset + (address - start) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_mappings_of_one_file_lead_to_the_same_place() {
        let camera = "7f0000001000-7f0000009000 rw-s 00002000 00:15 77   /dev/shm/x.data";
        let reader = "561000000000-561000009000 r--s 00000000 00:15 77   /dev/shm/x.data";
        let place = place_in(camera, 0x7f00_0000_1140).unwrap();
        assert_eq!(place_in(reader, 0x5610_0000_2140), Some(place));
        assert_eq!(place_in(camera, 0x7f00_0000_9000), None, "the end is outside");
        assert_eq!(place_in("7f0000001000-7f0000009000 rw-p 00000000 00:00 0", 0x7f00_0000_1140), None);
    }
}
