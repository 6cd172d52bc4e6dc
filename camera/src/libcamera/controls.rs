//! Controls by the library's names: `AnalogueGain` is `analogue_gain`.

use std::fmt::Display;
use std::str::FromStr;

use ::libcamera::control::{ControlInfo as LibraryControl, ControlInfoMap};
use ::libcamera::control_value::ControlValue;
use ::libcamera::controls::ControlId;

use crate::control::{ControlInfo, ControlSetting, most_like};

/// A control that is to be set.
#[derive(Clone)]
pub(super) struct Chosen {
    pub(super) id: u32,
    pub(super) value: ControlValue,
    pub(super) text: String,
}

/// Every control that is one number or a switch.
pub(super) fn list(map: &ControlInfoMap) -> Vec<ControlInfo> {
    map.into_iter().filter_map(|(id, control)| describe(&name(id)?, control)).collect()
}

fn describe(name: &str, control: &LibraryControl) -> Option<ControlInfo> {
    let (min, max) = (number(&control.min())?, number(&control.max())?);
    Some(ControlInfo {
        name: name.to_owned(),
        min: min.floor() as i64,
        max: max.ceil() as i64,
        step: 1,
        default: number(&control.def()).unwrap_or(min) as i64,
        value: None,
        menu: Vec::new(),
        inactive: false,
    })
}

/// Checks settings against what the camera has; an error names what there is.
pub(super) fn choose(map: &ControlInfoMap, settings: &[ControlSetting]) -> Result<Vec<Chosen>, String> {
    settings.iter().map(|setting| choose_one(map, setting)).collect()
}

fn choose_one(map: &ControlInfoMap, setting: &ControlSetting) -> Result<Chosen, String> {
    let named = |(id, control)| Some((name(id)?, id, control));
    let there: Vec<(String, u32, &LibraryControl)> = map.into_iter().filter_map(named).collect();
    let Some((_, id, control)) = there.iter().find(|(name, ..)| *name == setting.name) else {
        let nearest = most_like(&setting.name, there.iter().map(|(name, ..)| name.as_str()));
        let nearest = nearest.map_or_else(String::new, |name| format!("; the nearest is {name}"));
        return Err(format!("there is no control {}{nearest}", setting.name));
    };
    let value = read(&control.min(), setting)?;
    if let (Some(value), Some(min), Some(max)) =
        (number(&value), number(&control.min()), number(&control.max()))
        && min < max
        && !(min..=max).contains(&value)
    {
        return Err(format!("{value} is out of the range of the control {}: {min} to {max}", setting.name));
    }
    Ok(Chosen { id: *id, value, text: format!("{} {}", setting.name, setting.value) })
}

/// A value of the kind of another one.
fn read(like: &ControlValue, setting: &ControlSetting) -> Result<ControlValue, String> {
    fn parsed<T: FromStr>(setting: &ControlSetting) -> Result<T, String>
    where
        T::Err: Display,
    {
        setting.value.parse().map_err(|error| {
            format!("'{}' is no value of the control {}: {error}", setting.value, setting.name)
        })
    }
    Ok(match like {
        ControlValue::Bool(_) => match setting.value.as_str() {
            "0" | "false" => false.into(),
            "1" | "true" => true.into(),
            other => {
                return Err(format!("'{other}' is no value of the control {}: true or false", setting.name));
            }
        },
        ControlValue::Byte(_) => parsed::<u8>(setting)?.into(),
        ControlValue::Int32(_) => parsed::<i32>(setting)?.into(),
        ControlValue::Int64(_) => parsed::<i64>(setting)?.into(),
        ControlValue::Float(_) => parsed::<f32>(setting)?.into(),
        _ => return Err(format!("the control {} is no single number", setting.name)),
    })
}

/// A single number or switch.
fn number(value: &ControlValue) -> Option<f64> {
    match value {
        ControlValue::Bool(values) => values.first().map(|&value| f64::from(u8::from(value))),
        ControlValue::Byte(values) => values.first().map(|&value| value.into()),
        ControlValue::Int32(values) => values.first().map(|&value| value.into()),
        ControlValue::Int64(values) => values.first().map(|&value| value as f64),
        ControlValue::Float(values) => values.first().map(|&value| value.into()),
        _ => None,
    }
}

fn name(id: u32) -> Option<String> {
    ControlId::try_from(id).ok().map(|id| small_letters(&id.name()))
}

/// `AeEnable` is `ae_enable`.
fn small_letters(name: &str) -> String {
    let mut small = String::with_capacity(name.len() + 4);
    for letter in name.chars() {
        if letter.is_uppercase() && !small.is_empty() {
            small.push('_');
        }
        small.extend(letter.to_lowercase());
    }
    small
}
