//! Controls of a device.

use std::io;

use v4l::v4l_sys as sys;
use v4l::v4l2::vidioc;

use super::call::{call, listed, menu_number, menu_text, text, zeroed};
use super::facts::{ControlKind, DriverControl};
use super::port::Port;

impl Port {
    /// The control with the next number after `id`.
    pub(crate) fn control_after(&self, id: u32) -> io::Result<Option<DriverControl>> {
        let mut entry = sys::v4l2_query_ext_ctrl { id: id | sys::V4L2_CTRL_FLAG_NEXT_CTRL, ..zeroed() };
        if listed(call(&self.file, vidioc::VIDIOC_QUERY_EXT_CTRL, &mut entry))?.is_none() {
            return Ok(None);
        }
        let is = |flag: u32| entry.flags & flag != 0;
        Ok(Some(DriverControl {
            id: entry.id,
            kind: if is(sys::V4L2_CTRL_FLAG_DISABLED) {
                ControlKind::Other
            } else {
                control_kind(entry.type_)
            },
            title: text(&entry.name.map(|letter| letter as u8)),
            min: entry.minimum,
            max: entry.maximum,
            step: i64::try_from(entry.step).unwrap_or(i64::MAX),
            default: entry.default_value,
            read_only: is(sys::V4L2_CTRL_FLAG_READ_ONLY | sys::V4L2_CTRL_FLAG_GRABBED),
            inactive: is(sys::V4L2_CTRL_FLAG_INACTIVE),
        }))
    }

    /// What a menu's value means; `None` for a value that the menu does not have.
    pub(crate) fn menu_entry(&self, control: &DriverControl, value: i64) -> Option<String> {
        let index = u32::try_from(value).ok()?;
        let mut entry = sys::v4l2_querymenu { id: control.id, index, ..zeroed() };
        call(&self.file, vidioc::VIDIOC_QUERYMENU, &mut entry).ok()?;
        Some(match control.kind {
            ControlKind::NumberMenu => menu_number(entry).to_string(),
            _ => menu_text(entry),
        })
    }

    /// The value of a control.
    pub(crate) fn control(&self, id: u32) -> io::Result<i64> {
        let mut control = sys::v4l2_control { id, ..zeroed() };
        call(&self.file, vidioc::VIDIOC_G_CTRL, &mut control)?;
        Ok(control.value.into())
    }

    /// Gives a control a value; the driver may take another.
    pub(crate) fn set_control(&self, id: u32, value: i32) -> io::Result<()> {
        call(&self.file, vidioc::VIDIOC_S_CTRL, &mut sys::v4l2_control { id, value })
    }
}

fn control_kind(kind: u32) -> ControlKind {
    match kind {
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_INTEGER | sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BITMASK => {
            ControlKind::Number
        }
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BOOLEAN => ControlKind::Switch,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_MENU => ControlKind::Menu,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_INTEGER_MENU => ControlKind::NumberMenu,
        sys::v4l2_ctrl_type_V4L2_CTRL_TYPE_BUTTON => ControlKind::Button,
        _ => ControlKind::Other,
    }
}
