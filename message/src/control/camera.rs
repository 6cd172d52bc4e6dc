//! What a camera is asked, and what it answers.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

use super::asking::{
    CONTROL_SCHEMA, Outcome, REPLY_TEXT_BYTES, RequestKind, check_count, check_schema, read_text,
};
use super::fault::ControlFault;
use crate::info::CameraState;
use crate::text;

/// Bytes that a control's name, and its value as text, may take.
pub const CONTROL_TEXT_BYTES: usize = 48;
/// Controls that one request can set.
pub const MAX_CONTROLS_SET: usize = 16;
/// Controls that a reply has room for.
pub const MAX_CONTROLS_TOLD: usize = 64;

/// What a camera is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraAsk {
    /// Nothing but the answer.
    Get,
    /// Controls by name and value, where a value is a number or an entry of a menu: all of them, or none.
    Set(Vec<(String, String)>),
    /// Statistics that begin anew.
    ResetStatistics,
}

/// A control and its value as they travel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.ControlSet.v1")]
pub struct ControlSet {
    /// The control's name, see [`crate::text`].
    pub name: [u8; CONTROL_TEXT_BYTES],
    /// A number or an entry of the control's menu, see [`crate::text`].
    pub value: [u8; CONTROL_TEXT_BYTES],
}

impl ControlSet {
    const EMPTY: Self = Self { name: [0; CONTROL_TEXT_BYTES], value: [0; CONTROL_TEXT_BYTES] };
}

/// A request to a camera as it travels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.CameraRequest.v1")]
pub struct CameraRequest {
    /// Always [`CONTROL_SCHEMA`].
    pub schema: u32,
    /// A [`RequestKind`] code.
    pub kind: u32,
    /// Controls in `controls`.
    pub count: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// Controls to be set.
    pub controls: [ControlSet; MAX_CONTROLS_SET],
}

const _: () = {
    assert!(size_of::<ControlSet>() == 96);
    assert!(offset_of!(ControlSet, value) == 48);
    assert!(size_of::<CameraRequest>() == 1552);
    assert!(offset_of!(CameraRequest, schema) == 0);
    assert!(offset_of!(CameraRequest, kind) == 4);
    assert!(offset_of!(CameraRequest, count) == 8);
    assert!(offset_of!(CameraRequest, reserved) == 12);
    assert!(offset_of!(CameraRequest, controls) == 16);
};

impl CameraRequest {
    /// The request as it travels; controls that do not fit are an error.
    pub fn of(ask: &CameraAsk) -> Result<Self, ControlFault> {
        let (kind, settings) = match ask {
            CameraAsk::Get => (RequestKind::Get, &[][..]),
            CameraAsk::Set(settings) => (RequestKind::Set, &settings[..]),
            CameraAsk::ResetStatistics => (RequestKind::ResetStatistics, &[][..]),
        };
        let (seen, room) = (settings.len(), MAX_CONTROLS_SET);
        if seen > room {
            return Err(ControlFault::Count { what: "controls", seen, room });
        }
        let mut controls = [ControlSet::EMPTY; MAX_CONTROLS_SET];
        for (field, (name, value)) in controls.iter_mut().zip(settings) {
            write(&mut field.name, name, "control's name")?;
            write(&mut field.value, value, "control's value")?;
        }
        Ok(Self { schema: CONTROL_SCHEMA, kind: kind.code(), count: seen as u32, reserved: 0, controls })
    }

    /// What is asked. Copy the request out of shared memory first and check the copy.
    pub fn checked(&self) -> Result<CameraAsk, ControlFault> {
        check_schema(self.schema)?;
        match RequestKind::from_code(self.kind)? {
            RequestKind::Get => Ok(CameraAsk::Get),
            RequestKind::ResetStatistics => Ok(CameraAsk::ResetStatistics),
            RequestKind::Set => {
                let count = check_count(self.count, MAX_CONTROLS_SET, "controls")?;
                let read = |control: &ControlSet| {
                    let name = read_text(&control.name, "control's name")?;
                    Ok((name, read_text(&control.value, "control's value")?))
                };
                self.controls[..count].iter().map(read).collect::<Result<_, _>>().map(CameraAsk::Set)
            }
        }
    }
}

/// A control of a camera as it travels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.ControlState.v1")]
pub struct ControlState {
    /// The control's name, see [`crate::text`].
    pub name: [u8; CONTROL_TEXT_BYTES],
    /// Smallest value.
    pub min: i64,
    /// Largest value.
    pub max: i64,
    /// The value that the driver starts with.
    pub default: i64,
    /// The value read back; not known where `has_value` is 0.
    pub value: i64,
    /// 1 where the control has a value that can be read.
    pub has_value: u32,
    /// 1 while another control has its say, so that a value has no effect.
    pub inactive: u32,
}

impl ControlState {
    const EMPTY: Self = Self {
        name: [0; CONTROL_TEXT_BYTES],
        min: 0,
        max: 0,
        default: 0,
        value: 0,
        has_value: 0,
        inactive: 0,
    };
}

/// A control that a camera has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceControl {
    /// The name to set it by.
    pub name: String,
    /// Smallest value.
    pub min: i64,
    /// Largest value.
    pub max: i64,
    /// The value that the driver starts with.
    pub default: i64,
    /// The value in force, read back; `None` for a button, and where the driver does not say.
    pub value: Option<i64>,
    /// Whether another control has its say at present, so that a value has no effect.
    pub inactive: bool,
}

/// What a camera did since its start, or since its statistics were reset.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.CameraStatistics.v1")]
pub struct CameraStatistics {
    /// When the camera started, `CLOCK_MONOTONIC` nanoseconds.
    pub started_ns: u64,
    /// When these counts began, `CLOCK_MONOTONIC` nanoseconds.
    pub since_ns: u64,
    /// When these counts were taken, `CLOCK_MONOTONIC` nanoseconds.
    pub taken_ns: u64,
    /// Frames published.
    pub frames: u64,
    /// Frames passed over because they could not be used.
    pub damaged: u64,
    /// Frames given up because no memory was free.
    pub no_loan: u64,
    /// Requests answered.
    pub requests_answered: u64,
    /// Requests that were not possible.
    pub requests_refused: u64,
}

/// A camera's reply as it travels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("tagbus.CameraReply.v1")]
pub struct CameraReply {
    /// Always [`CONTROL_SCHEMA`].
    pub schema: u32,
    /// An [`Outcome`] code.
    pub outcome: u32,
    /// [`crate::info::CameraInfo::number`] that is in force; frames name it.
    pub info_number: u32,
    /// A [`CameraState`] code.
    pub state: u32,
    /// Controls of the camera; may exceed [`MAX_CONTROLS_TOLD`].
    pub control_count: u32,
    /// Not used: zero.
    pub reserved: u32,
    /// Counts and their times.
    pub statistics: CameraStatistics,
    /// What is wrong with the request, or worth knowing about it; see [`crate::text`].
    pub text: [u8; REPLY_TEXT_BYTES],
    /// The camera's controls with their values.
    pub controls: [ControlState; MAX_CONTROLS_TOLD],
}

const _: () = {
    assert!(size_of::<ControlState>() == 88);
    assert!(offset_of!(ControlState, min) == 48);
    assert!(offset_of!(ControlState, value) == 72);
    assert!(offset_of!(ControlState, has_value) == 80);
    assert!(offset_of!(ControlState, inactive) == 84);
    assert!(size_of::<CameraStatistics>() == 64);
    assert!(size_of::<CameraReply>() == 6232);
    assert!(offset_of!(CameraReply, schema) == 0);
    assert!(offset_of!(CameraReply, outcome) == 4);
    assert!(offset_of!(CameraReply, info_number) == 8);
    assert!(offset_of!(CameraReply, state) == 12);
    assert!(offset_of!(CameraReply, control_count) == 16);
    assert!(offset_of!(CameraReply, reserved) == 20);
    assert!(offset_of!(CameraReply, statistics) == 24);
    assert!(offset_of!(CameraReply, text) == 88);
    assert!(offset_of!(CameraReply, controls) == 600);
};

/// What a camera answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraAnswer {
    /// How the request ended.
    pub outcome: Outcome,
    /// What is wrong with the request, or worth knowing about it; may be empty.
    pub text: String,
    /// [`crate::info::CameraInfo::number`] that is in force; frames name it.
    pub info_number: u32,
    /// What the camera is doing.
    pub state: CameraState,
    /// The camera's controls with their values, the first [`MAX_CONTROLS_TOLD`] of them.
    pub controls: Vec<DeviceControl>,
    /// Counts and their times.
    pub statistics: CameraStatistics,
}

impl CameraReply {
    /// The answer as it travels. Controls beyond the room are left out.
    #[must_use]
    pub fn of(answer: &CameraAnswer) -> Self {
        let mut reply = Self {
            schema: CONTROL_SCHEMA,
            outcome: answer.outcome.code(),
            info_number: answer.info_number,
            state: answer.state.code(),
            control_count: answer.controls.len() as u32,
            reserved: 0,
            statistics: answer.statistics,
            text: [0; REPLY_TEXT_BYTES],
            controls: [ControlState::EMPTY; MAX_CONTROLS_TOLD],
        };
        text::write_cut(&mut reply.text, &answer.text);
        for (field, control) in reply.controls.iter_mut().zip(&answer.controls) {
            text::write_cut(&mut field.name, &control.name);
            (field.min, field.max, field.default) = (control.min, control.max, control.default);
            (field.value, field.has_value) =
                (control.value.unwrap_or_default(), control.value.is_some().into());
            field.inactive = control.inactive.into();
        }
        reply
    }

    /// What was answered. Copy the reply out of shared memory first and check the copy.
    pub fn checked(&self) -> Result<CameraAnswer, ControlFault> {
        check_schema(self.schema)?;
        let count = (self.control_count as usize).min(MAX_CONTROLS_TOLD);
        let read = |control: &ControlState| {
            Ok(DeviceControl {
                name: read_text(&control.name, "control's name")?,
                min: control.min,
                max: control.max,
                default: control.default,
                value: (control.has_value == 1).then_some(control.value),
                inactive: control.inactive == 1,
            })
        };
        Ok(CameraAnswer {
            outcome: Outcome::from_code(self.outcome),
            text: read_text(&self.text, "text of the reply")?,
            info_number: self.info_number,
            state: CameraState::from_code(self.state),
            controls: self.controls[..count].iter().map(read).collect::<Result<_, _>>()?,
            statistics: self.statistics,
        })
    }
}

fn write(field: &mut [u8], text: &str, what: &'static str) -> Result<(), ControlFault> {
    text::write(field, text).map_err(|long| ControlFault::Long { what, text: long.text, room: long.limit })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_asked_is_what_is_read() {
        let settings = vec![("gain".to_owned(), "50".to_owned()), ("auto_exposure".into(), "manual".into())];
        for ask in [CameraAsk::Get, CameraAsk::Set(settings), CameraAsk::ResetStatistics] {
            assert_eq!(CameraRequest::of(&ask).unwrap().checked().unwrap(), ask);
        }
    }

    #[test]
    fn what_was_answered_is_what_is_read_and_what_does_not_fit_is_left_out() {
        let control = |number: usize| DeviceControl {
            name: format!("control_{number}"),
            min: -5,
            max: 5,
            default: 0,
            value: number.is_multiple_of(2).then_some(3),
            inactive: number.is_multiple_of(3),
        };
        let answer = CameraAnswer {
            outcome: Outcome::Done,
            text: "gain 50".into(),
            info_number: 4,
            state: CameraState::Streaming,
            controls: (0..MAX_CONTROLS_TOLD + 3).map(control).collect(),
            statistics: CameraStatistics { frames: 9, ..CameraStatistics::default() },
        };
        let read = CameraReply::of(&answer).checked().unwrap();
        assert_eq!(read.controls, answer.controls[..MAX_CONTROLS_TOLD]);
        assert_eq!(CameraAnswer { controls: answer.controls.clone(), ..read }, answer);
    }

    #[test]
    fn requests_that_cannot_be_are_refused() {
        let good = CameraRequest::of(&CameraAsk::Set(vec![("gain".into(), "1".into())])).unwrap();
        assert!(CameraRequest { count: 17, ..good }.checked().is_err());
        assert!(CameraRequest { kind: 9, ..good }.checked().is_err());
        assert!(CameraRequest { schema: 0, ..good }.checked().is_err());
        let mut bytes = good;
        bytes.controls[0].name = [0xfe; CONTROL_TEXT_BYTES];
        assert!(bytes.checked().unwrap_err().to_string().contains("UTF-8"));
        let many = vec![("gain".to_owned(), "1".to_owned()); 17];
        assert!(CameraRequest::of(&CameraAsk::Set(many)).unwrap_err().to_string().contains("at most 16"));
        let long = CameraRequest::of(&CameraAsk::Set(vec![("x".repeat(49), String::new())])).unwrap_err();
        assert!(long.to_string().contains("49 bytes but at most 48"), "{long}");
    }
}
