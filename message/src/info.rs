//! What a camera says about itself: mode, controls in force, calibration and state.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

use crate::text;

/// The layout of [`CameraInfo`] that this code writes and reads.
pub const INFO_SCHEMA: u32 = 1;

/// What a camera is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum CameraState {
    /// Not known: a code of a newer version.
    Unknown = 0,
    /// The device is being opened.
    Starting = 1,
    /// Frames are published.
    Streaming = 2,
    /// The device is there but gives no frames.
    Waiting = 3,
    /// The device has gone; it is looked for.
    Lost = 4,
    /// The source has come to its end.
    Ended = 5,
}

impl CameraState {
    /// The state of a code.
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            1 => Self::Starting,
            2 => Self::Streaming,
            3 => Self::Waiting,
            4 => Self::Lost,
            5 => Self::Ended,
            _ => Self::Unknown,
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Starting => "starting",
            Self::Streaming => "streaming",
            Self::Waiting => "waiting",
            Self::Lost => "lost",
            Self::Ended => "ended",
        }
    }
}

/// The payload of the info topic; a late subscriber gets the last one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("tagbus.CameraInfo.v1")]
pub struct CameraInfo {
    /// Always [`INFO_SCHEMA`].
    pub schema: u32,
    /// Counts up with each change; frames name the number that applies to them.
    pub number: u32,
    /// Epoch of the camera: another number at each start.
    pub epoch: u64,
    /// A [`CameraState`] code.
    pub state: u32,
    /// Pixel format of the source, a [`crate::frame::Fourcc`]; MJPG for compressed sources.
    pub source_fourcc: u32,
    /// Pixel format of the published frames, a [`crate::frame::Fourcc`].
    pub fourcc: u32,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How far the picture must be turned clockwise to stand upright, degrees.
    pub rotation_degrees: u32,
    /// Nominal time from frame to frame, nanoseconds; 0 when as fast as possible or not known.
    pub frame_time_ns: u64,
    /// Exposure time in force, nanoseconds; 0 when not known.
    pub exposure_ns: u64,
    /// Gain in force as a factor; 0 when not known.
    pub gain: f32,
    /// 1 when the device chooses exposure and gain by itself.
    pub auto_exposure: u32,
    /// When this was written, `CLOCK_MONOTONIC` nanoseconds.
    pub updated_ns: u64,
    /// Wall clock minus `CLOCK_MONOTONIC` at that moment, nanoseconds.
    pub wall_offset_ns: i64,
    /// Focal lengths and principal point fx, fy, cx, cy in pixels, (0,0) at the top-left corner of the
    /// top-left pixel; zero when there is no calibration.
    pub intrinsics: [f64; 4],
    /// Distortion coefficients k1, k2, p1, p2, k3, k4, k5, k6 (OpenCV's order).
    pub distortion: [f64; 8],
    /// 0 no calibration, 1 pinhole without distortion, 2 OpenCV's rational model.
    pub calibration_model: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// Where frames come from, as the user wrote it; see [`crate::text`].
    pub source: [u8; 128],
    /// Model of the device, or what the source is; see [`crate::text`].
    pub model: [u8; 64],
}

const _: () = {
    assert!(size_of::<CameraInfo>() == 376);
    assert!(offset_of!(CameraInfo, schema) == 0);
    assert!(offset_of!(CameraInfo, number) == 4);
    assert!(offset_of!(CameraInfo, epoch) == 8);
    assert!(offset_of!(CameraInfo, state) == 16);
    assert!(offset_of!(CameraInfo, source_fourcc) == 20);
    assert!(offset_of!(CameraInfo, fourcc) == 24);
    assert!(offset_of!(CameraInfo, width) == 28);
    assert!(offset_of!(CameraInfo, height) == 32);
    assert!(offset_of!(CameraInfo, rotation_degrees) == 36);
    assert!(offset_of!(CameraInfo, frame_time_ns) == 40);
    assert!(offset_of!(CameraInfo, exposure_ns) == 48);
    assert!(offset_of!(CameraInfo, gain) == 56);
    assert!(offset_of!(CameraInfo, auto_exposure) == 60);
    assert!(offset_of!(CameraInfo, updated_ns) == 64);
    assert!(offset_of!(CameraInfo, wall_offset_ns) == 72);
    assert!(offset_of!(CameraInfo, intrinsics) == 80);
    assert!(offset_of!(CameraInfo, distortion) == 112);
    assert!(offset_of!(CameraInfo, calibration_model) == 176);
    assert!(offset_of!(CameraInfo, reserved) == 180);
    assert!(offset_of!(CameraInfo, source) == 184);
    assert!(offset_of!(CameraInfo, model) == 312);
};

impl Default for CameraInfo {
    fn default() -> Self {
        Self {
            schema: INFO_SCHEMA,
            number: 0,
            epoch: 0,
            state: CameraState::Starting.code(),
            source_fourcc: 0,
            fourcc: 0,
            width: 0,
            height: 0,
            rotation_degrees: 0,
            frame_time_ns: 0,
            exposure_ns: 0,
            gain: 0.0,
            auto_exposure: 0,
            updated_ns: 0,
            wall_offset_ns: 0,
            intrinsics: [0.0; 4],
            distortion: [0.0; 8],
            calibration_model: 0,
            reserved: 0,
            source: [0; 128],
            model: [0; 64],
        }
    }
}

impl CameraInfo {
    /// What the camera is doing.
    #[must_use]
    pub fn camera_state(&self) -> CameraState {
        CameraState::from_code(self.state)
    }

    /// Where frames come from, as the user wrote it.
    #[must_use]
    pub fn source_text(&self) -> &str {
        text::read(&self.source).unwrap_or("?")
    }

    /// Model of the device.
    #[must_use]
    pub fn model_text(&self) -> &str {
        text::read(&self.model).unwrap_or("?")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_states_come_back() {
        for code in 0..6 {
            assert_eq!(CameraState::from_code(code).code(), code);
        }
        assert_eq!(CameraState::from_code(99), CameraState::Unknown);
    }

    #[test]
    fn texts_are_read_back() {
        let mut info = CameraInfo::default();
        text::write_cut(&mut info.source, "replay:/tmp/pictures");
        assert_eq!(info.source_text(), "replay:/tmp/pictures");
    }
}
