//! What a detector says about one frame.

use std::fmt;
use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

use crate::frame::CaptureKind;
use crate::text;

/// The layout of [`DetectionsHeader`] and [`TagDetection`] that this code writes and reads.
pub const DETECTIONS_SCHEMA: u32 = 1;
/// Bytes that a family's name may take.
pub const FAMILY_NAME_BYTES: usize = 32;
/// Families that a header has room for; a detector with more leaves the others out of its header.
pub const MAX_NAMED_FAMILIES: usize = 16;

/// Bits of [`DetectionsHeader::flags`].
pub mod header_flags {
    /// More tags were found than fit: those with the best margins were kept.
    pub const MORE_FOUND: u32 = 1;
    /// Only a region of the frame was searched: a tag that is missing may lie elsewhere.
    pub const REGION: u32 = 2;
    /// Only some ids are reported: a tag that is missing may have another.
    pub const IDS: u32 = 4;
}

/// Bits of [`TagDetection::flags`]. The first four are those of the detector.
pub mod tag_flags {
    /// A corner lies outside the frame, or of the region that is searched, or within a pixel of its rim.
    pub const TOUCHES_EDGE: u32 = 1;
    /// Fewer than 2 pixels a cell: corners are less certain.
    pub const SMALL: u32 = 2;
    /// Fewer than 20 grey levels between black and white.
    pub const DIM: u32 = 4;
    /// White (or black) is clipped by the sensor.
    pub const SATURATED: u32 = 8;
    /// No pose was computed because the camera's intrinsics are not known: poses and covariance are zero.
    pub const NO_POSE_NO_INTRINSICS: u32 = 1 << 16;
    /// No pose was computed because the tag's size is not known: poses and covariance are zero.
    pub const NO_POSE_NO_SIZE: u32 = 1 << 17;

    /// Each flag and its name in JSON.
    pub const NAMES: [(u32, &str); 6] = [
        (TOUCHES_EDGE, "touches_edge"),
        (SMALL, "small"),
        (DIM, "dim"),
        (SATURATED, "saturated"),
        (NO_POSE_NO_INTRINSICS, "no_pose_no_intrinsics"),
        (NO_POSE_NO_SIZE, "no_pose_no_size"),
    ];

    /// The names of the flags that are set.
    pub fn names(flags: u32) -> impl Iterator<Item = &'static str> {
        NAMES.into_iter().filter(move |(bit, _)| flags & bit != 0).map(|(_, name)| name)
    }
}

/// The user header of the detections topic; the payload is `count` elements of [`TagDetection`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("tagbus.DetectionsHeader.v1")]
pub struct DetectionsHeader {
    /// Always [`DETECTIONS_SCHEMA`].
    pub schema: u32,
    /// See [`header_flags`].
    pub flags: u32,
    /// Epoch of the frame: another number at each start of the camera.
    pub epoch: u64,
    /// Sequence of the frame within its epoch.
    pub sequence: u64,
    /// Another number at each start of the detector.
    pub detector_epoch: u64,
    /// Number of this message since the detector's start, from 0.
    pub message_number: u64,
    /// The frame's capture stamp, nanoseconds; 0 when not known.
    pub capture_ns: u64,
    /// A [`crate::frame::ClockKind`] code: the clock of `capture_ns`.
    pub capture_clock: u32,
    /// A [`CaptureKind`] code: the moment that `capture_ns` marks.
    pub capture_kind: u32,
    /// When the camera process got the frame, `CLOCK_MONOTONIC` nanoseconds as all stamps below.
    pub dequeue_ns: u64,
    /// When the camera process published it.
    pub publish_ns: u64,
    /// When the detector process received it.
    pub receive_ns: u64,
    /// When the search for tags began.
    pub detect_start_ns: u64,
    /// When the search ended.
    pub detect_end_ns: u64,
    /// When this message was sent.
    pub send_ns: u64,
    /// Pixels a row of the frame.
    pub width: u32,
    /// Rows of the frame.
    pub height: u32,
    /// Tags in this message.
    pub count: u32,
    /// Tags found in the frame; more than `count` when not all fit.
    pub found: u32,
    /// Sequence numbers between the frame searched before and this one, within the epoch: frames that the detector
    /// had no time for, and frames that the camera lost.
    pub skipped: u32,
    /// [`crate::info::CameraInfo::number`] that the frame named.
    pub info_number: u32,
    /// Sum of `skipped` since the detector's start.
    pub skipped_total: u64,
    /// Frames whose header did not fit their bytes, since the detector's start.
    pub refused_total: u64,
    /// Number of the last change of parameters, 0 before the first. All parameters of this message are of that change; those
    /// that are not named here are told by the detector when it is asked ([`crate::control`]).
    pub control_number: u64,
    /// Decimation in force: full-resolution pixels per decimated pixel.
    pub decimation: f32,
    /// Corrected bits in force for every family; -1 when each family has its own default.
    pub hamming: i32,
    /// Families searched for; may exceed [`MAX_NAMED_FAMILIES`].
    pub family_count: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// Names of the families, see [`crate::text`].
    pub families: [[u8; FAMILY_NAME_BYTES]; MAX_NAMED_FAMILIES],
}

/// One of the two poses that explain what a flat square looks like.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("tagbus.TagPose.v1")]
pub struct TagPose {
    /// The tag's middle in the camera frame, metres (x right, y down, z forward).
    pub translation_m: [f64; 3],
    /// Tag frame to camera frame as a unit quaternion w, x, y, z.
    pub rotation_wxyz: [f64; 4],
    /// Root mean square distance of the four projected corners from the seen ones, pixels.
    pub error_px: f64,
}

/// One tag found in one frame. Axes and corner order: `docs/coordinates.md`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("tagbus.TagDetection.v1")]
pub struct TagDetection {
    /// Name of the family, see [`TagDetection::family`].
    pub family_name: [u8; FAMILY_NAME_BYTES],
    /// The tag's id: its place in the family's code table.
    pub id: u32,
    /// Bits that were corrected.
    pub hamming: u32,
    /// Decision margin in 8-bit grey levels: mean distance of the bits from their threshold.
    pub margin: f32,
    /// The margin divided by half the tag's contrast: about 1 for a clean tag.
    pub relative_margin: f32,
    /// Where the tag's middle is seen: x, y in pixels of the full-resolution frame.
    pub center: [f64; 2],
    /// Bottom-left, bottom-right, top-right, top-left of the upright tag's border edge: x, y in pixels.
    pub corners: [[f64; 2]; 4],
    /// Row-major: tag square [-1,1]^2 to full-resolution pixels, last element 1.
    pub homography: [f64; 9],
    /// The better pose, then the other one; zero when a `NO_POSE` flag is set.
    pub poses: [TagPose; 2],
    /// Error of the better pose divided by that of the other: near 1 means that they cannot be told apart; 0 without poses.
    pub ambiguity: f64,
    /// Covariance of the better pose: upper triangle, row after row, of the 6x6 matrix over x, y, z in metres
    /// and the rotation vector in radians, both in the camera frame. Zero when `covariance_model` is 0.
    pub covariance: [f64; 21],
    /// How the covariance was computed: 0 not at all.
    pub covariance_model: u32,
    /// See [`tag_flags`].
    pub flags: u32,
}

const _: () = {
    assert!(size_of::<DetectionsHeader>() == 680);
    assert!(offset_of!(DetectionsHeader, schema) == 0);
    assert!(offset_of!(DetectionsHeader, flags) == 4);
    assert!(offset_of!(DetectionsHeader, epoch) == 8);
    assert!(offset_of!(DetectionsHeader, sequence) == 16);
    assert!(offset_of!(DetectionsHeader, detector_epoch) == 24);
    assert!(offset_of!(DetectionsHeader, message_number) == 32);
    assert!(offset_of!(DetectionsHeader, capture_ns) == 40);
    assert!(offset_of!(DetectionsHeader, capture_clock) == 48);
    assert!(offset_of!(DetectionsHeader, capture_kind) == 52);
    assert!(offset_of!(DetectionsHeader, dequeue_ns) == 56);
    assert!(offset_of!(DetectionsHeader, publish_ns) == 64);
    assert!(offset_of!(DetectionsHeader, receive_ns) == 72);
    assert!(offset_of!(DetectionsHeader, detect_start_ns) == 80);
    assert!(offset_of!(DetectionsHeader, detect_end_ns) == 88);
    assert!(offset_of!(DetectionsHeader, send_ns) == 96);
    assert!(offset_of!(DetectionsHeader, width) == 104);
    assert!(offset_of!(DetectionsHeader, height) == 108);
    assert!(offset_of!(DetectionsHeader, count) == 112);
    assert!(offset_of!(DetectionsHeader, found) == 116);
    assert!(offset_of!(DetectionsHeader, skipped) == 120);
    assert!(offset_of!(DetectionsHeader, info_number) == 124);
    assert!(offset_of!(DetectionsHeader, skipped_total) == 128);
    assert!(offset_of!(DetectionsHeader, refused_total) == 136);
    assert!(offset_of!(DetectionsHeader, control_number) == 144);
    assert!(offset_of!(DetectionsHeader, decimation) == 152);
    assert!(offset_of!(DetectionsHeader, hamming) == 156);
    assert!(offset_of!(DetectionsHeader, family_count) == 160);
    assert!(offset_of!(DetectionsHeader, reserved) == 164);
    assert!(offset_of!(DetectionsHeader, families) == 168);
};

const _: () = {
    assert!(size_of::<TagPose>() == 64);
    assert!(offset_of!(TagPose, translation_m) == 0);
    assert!(offset_of!(TagPose, rotation_wxyz) == 24);
    assert!(offset_of!(TagPose, error_px) == 56);
    assert!(size_of::<TagDetection>() == 512);
    assert!(offset_of!(TagDetection, family_name) == 0);
    assert!(offset_of!(TagDetection, id) == 32);
    assert!(offset_of!(TagDetection, hamming) == 36);
    assert!(offset_of!(TagDetection, margin) == 40);
    assert!(offset_of!(TagDetection, relative_margin) == 44);
    assert!(offset_of!(TagDetection, center) == 48);
    assert!(offset_of!(TagDetection, corners) == 64);
    assert!(offset_of!(TagDetection, homography) == 128);
    assert!(offset_of!(TagDetection, poses) == 200);
    assert!(offset_of!(TagDetection, ambiguity) == 328);
    assert!(offset_of!(TagDetection, covariance) == 336);
    assert!(offset_of!(TagDetection, covariance_model) == 504);
    assert!(offset_of!(TagDetection, flags) == 508);
};

impl TagDetection {
    /// The family's name; "?" when the field holds no text, which only a broken publisher writes.
    #[must_use]
    pub fn family(&self) -> &str {
        text::read(&self.family_name).unwrap_or("?")
    }

    /// The names of the flags that are set.
    pub fn flag_names(&self) -> impl Iterator<Item = &'static str> {
        tag_flags::names(self.flags)
    }
}

impl DetectionsHeader {
    /// Checks the header against a payload of `len` elements and gives the number of tags to read.
    ///
    /// The smaller of `count` and `len` is taken: some bindings report a slice's length in bytes.
    /// Copy the header out of shared memory first and check the copy.
    pub fn checked(&self, len: usize) -> Result<usize, DetectionsError> {
        if self.schema != DETECTIONS_SCHEMA {
            return Err(DetectionsError::Schema { seen: self.schema, known: DETECTIONS_SCHEMA });
        }
        if self.found < self.count {
            return Err(DetectionsError::Count { count: self.count, found: self.found });
        }
        Ok(len.min(self.count as usize))
    }

    /// The moment that the frame's capture stamp marks.
    #[must_use]
    pub fn capture_moment(&self) -> CaptureKind {
        CaptureKind::from_code(self.capture_kind)
    }

    /// The names of the families that were searched for, as far as they fit.
    pub fn family_names(&self) -> impl Iterator<Item = &str> {
        let count = (self.family_count as usize).min(MAX_NAMED_FAMILIES);
        self.families[..count].iter().filter_map(|name| text::read(name))
    }
}

/// What a detections header says that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DetectionsError {
    /// The header is of another version.
    Schema {
        /// The version that the header names.
        seen: u32,
        /// The version that this code reads.
        known: u32,
    },
    /// More tags in the message than were found.
    Count {
        /// Tags in the message.
        count: u32,
        /// Tags found.
        found: u32,
    },
}

impl fmt::Display for DetectionsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Schema { seen, known } => {
                write!(f, "detections header of version {seen}, but this program reads version {known}")
            }
            Self::Count { count, found } => {
                write!(f, "detections header with {count} tags of which only {found} were found")
            }
        }
    }
}

impl std::error::Error for DetectionsError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(count: u32) -> DetectionsHeader {
        DetectionsHeader { schema: DETECTIONS_SCHEMA, count, found: count, ..DetectionsHeader::default() }
    }

    #[test]
    fn never_more_tags_are_read_than_are_there() {
        for (count, len) in [(0, 0), (3, 3), (3, 1536), (7, 2), (u32::MAX, 5), (0, 9)] {
            let readable = header(count).checked(len).unwrap();
            assert!(readable <= len && readable <= count as usize);
        }
    }

    #[test]
    fn a_header_that_contradicts_itself_is_refused() {
        let lying = DetectionsHeader { found: 1, ..header(2) };
        assert_eq!(lying.checked(2), Err(DetectionsError::Count { count: 2, found: 1 }));
        let foreign = DetectionsHeader { schema: 2, ..header(0) };
        assert!(foreign.checked(0).unwrap_err().to_string().contains("version 2"));
    }

    #[test]
    fn a_family_count_beyond_the_room_reads_only_what_is_there() {
        let mut many = header(0);
        many.family_count = 1000;
        assert_eq!(many.family_names().count(), MAX_NAMED_FAMILIES);
    }

    #[test]
    fn a_custom_family_keeps_its_name() {
        let mut tag = TagDetection::default();
        text::write(&mut tag.family_name, "my-own-family").unwrap();
        assert_eq!(tag.family(), "my-own-family");
    }

    #[test]
    fn flags_are_named() {
        let names: Vec<_> = tag_flags::names(tag_flags::DIM | tag_flags::NO_POSE_NO_INTRINSICS).collect();
        assert_eq!(names, ["dim", "no_pose_no_intrinsics"]);
    }
}
