//! Controls of an open device: listed, set in the order that makes drivers obey, read back.
//!
//! ```text
//! asked for        set in this order
//! exposure=50      1. switches and menus called auto: their default, then the value asked for, because some devices
//! auto_exposure=1     take a manual value only after auto was on
//! gain=3           2. all others, as they were written
//! ```

use std::io;

use super::kernel::{ControlKind, DriverControl, Port};
use crate::control::{ControlInfo, ControlSetting, ControlSettings, identifier, most_like};
use crate::desk::{Changed, Controls};

/// Longer lists, and longer menus, are a driver's fault.
const MOST_ENTRIES: usize = 1024;

/// A control that was set, and what it has become.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Applied {
    name: String,
    asked: i64,
    /// What the device says it is; `None` for a button.
    is: Option<i64>,
}

impl Applied {
    /// The control with its value, and with what was asked for where it is another.
    pub(super) fn text(&self) -> String {
        let Self { name, asked, is } = self;
        match is {
            None => format!("{name} pressed"),
            Some(is) if is == asked => format!("{name} {is}"),
            Some(is) => format!("{name} {is} instead of {asked}"),
        }
    }
}

/// Every control that can be set, with its value.
pub(super) fn list(port: &Port) -> io::Result<Vec<ControlInfo>> {
    Ok(all(port)?.iter().map(|control| describe(port, control)).collect())
}

fn all(port: &Port) -> io::Result<Vec<DriverControl>> {
    let mut controls = Vec::new();
    let mut last = 0;
    while let Some(control) = port.control_after(last)? {
        last = control.id;
        if control.kind != ControlKind::Other && !control.read_only {
            controls.push(control);
        }
        if controls.len() == MOST_ENTRIES {
            break;
        }
    }
    Ok(controls)
}

fn describe(port: &Port, control: &DriverControl) -> ControlInfo {
    let is_menu = matches!(control.kind, ControlKind::Menu | ControlKind::NumberMenu);
    let entry = |value| Some((value, port.menu_entry(control, value)?));
    let menu = (control.min..=control.max).take(MOST_ENTRIES).filter_map(entry);
    ControlInfo {
        name: identifier(&control.title),
        min: control.min,
        max: control.max,
        step: control.step,
        default: control.default,
        value: if control.kind == ControlKind::Button { None } else { port.control(control.id).ok() },
        menu: if is_menu { menu.collect() } else { Vec::new() },
        inactive: control.inactive,
    }
}

/// What a device's own controls say about its exposure.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Exposure {
    /// Nanoseconds; 0 when the device does not say.
    pub(super) time_ns: u64,
    /// Whether the device chooses it.
    pub(super) is_automatic: bool,
}

/// Exposure time in units of 100 us (V4L2_CID_EXPOSURE_ABSOLUTE).
const EXPOSURE_TIME: u32 = 0x009a_0902;
/// Who chooses it (V4L2_CID_EXPOSURE_AUTO): 0 the device, 1 nobody, 2 by time, 3 by aperture, which leaves the time to the device.
const EXPOSURE_AUTO: u32 = 0x009a_0901;

/// Reads the exposure that is in force.
pub(super) fn exposure(port: &Port) -> Exposure {
    let time = port.control(EXPOSURE_TIME).ok().and_then(|time| u64::try_from(time).ok());
    let is_automatic = matches!(port.control(EXPOSURE_AUTO), Ok(0 | 3));
    Exposure { time_ns: time.unwrap_or(0).saturating_mul(100_000), is_automatic }
}

/// The controls of a device that streams, as others may set them.
pub(super) struct OfDevice<'a> {
    pub(super) port: &'a Port,
    /// What is set again whenever the device is opened.
    pub(super) kept: &'a mut ControlSettings,
}

impl Controls for OfDevice<'_> {
    fn list(&self) -> Vec<ControlInfo> {
        list(self.port).unwrap_or_default()
    }

    fn set(&mut self, settings: &ControlSettings) -> Result<Changed, String> {
        let applied = apply(self.port, settings)?;
        for setting in &settings.0 {
            self.kept.0.retain(|kept| kept.name != setting.name);
            self.kept.0.push(setting.clone());
        }
        let Exposure { time_ns, is_automatic } = exposure(self.port);
        let exposure_ns = if is_automatic { 0 } else { time_ns };
        let text = applied.iter().map(Applied::text).collect::<Vec<_>>().join(", ");
        Ok(Changed { text, exposure_ns, is_automatic })
    }
}

/// A setting that was found to be possible.
#[derive(Debug, PartialEq, Eq)]
struct Step {
    id: u32,
    name: String,
    value: i32,
    /// What is set before, to make the device take the value.
    before: Option<i32>,
    is_button: bool,
}

/// Sets the controls and reads them back.
///
/// An error names the control, what was asked for and what is possible; nothing is set when one of them is not.
pub(super) fn apply(port: &Port, settings: &ControlSettings) -> Result<Vec<Applied>, String> {
    if settings.0.is_empty() {
        return Ok(Vec::new());
    }
    let there = all(port).map_err(|error| format!("its controls cannot be listed: {error}"))?;
    let infos: Vec<ControlInfo> = there.iter().map(|control| describe(port, control)).collect();
    let steps = plan(&settings.0, &there, &infos)?;
    for step in &steps {
        for value in step.before.into_iter().chain([step.value]) {
            let set = port.set_control(step.id, value);
            set.map_err(|error| format!("the control {} does not take {value}: {error}", step.name))?;
        }
    }
    let read = |step: &Step| Applied {
        name: step.name.clone(),
        asked: step.value.into(),
        is: if step.is_button { None } else { port.control(step.id).ok() },
    };
    Ok(steps.iter().map(read).collect())
}

/// What is to be set, in the order that makes drivers obey.
fn plan(
    settings: &[ControlSetting],
    there: &[DriverControl],
    infos: &[ControlInfo],
) -> Result<Vec<Step>, String> {
    let mut steps = Vec::new();
    for setting in settings {
        let place = infos.iter().position(|info| info.name == setting.name);
        let place = place.ok_or_else(|| unknown(&setting.name, infos))?;
        let (control, info) = (&there[place], &infos[place]);
        let value = value_of(setting, control, info)?;
        let chooses = matches!(control.kind, ControlKind::Switch | ControlKind::Menu);
        let is_auto = chooses && info.name.split('_').any(|word| word.starts_with("auto"));
        let default = i32::try_from(control.default).unwrap_or(value);
        let before = (is_auto && default != value).then_some(default);
        let is_button = control.kind == ControlKind::Button;
        steps.push((!is_auto, Step { id: control.id, name: info.name.clone(), value, before, is_button }));
    }
    // Stable: within both groups the order of the user.
    steps.sort_by_key(|(is_late, _)| *is_late);
    Ok(steps.into_iter().map(|(_, step)| step).collect())
}

fn unknown(name: &str, infos: &[ControlInfo]) -> String {
    match most_like(name, infos.iter().map(|info| info.name.as_str())) {
        Some(like) => format!(
            "it has no control {name}; the nearest is {like} (`tagbus camera --list` shows all {})",
            infos.len()
        ),
        None => format!("it has no control {name}, and no other"),
    }
}

/// A number in the control's range, or the number of a menu's entry.
fn value_of(setting: &ControlSetting, control: &DriverControl, info: &ControlInfo) -> Result<i32, String> {
    let ControlSetting { name, value } = setting;
    let entry = info.menu.iter().find(|(_, text)| identifier(text) == identifier(value));
    let number = match (value.parse(), entry) {
        (Ok(number), _) => number,
        (Err(_), Some((number, _))) => *number,
        (Err(_), None) if control.kind == ControlKind::Switch && value == "true" => 1,
        (Err(_), None) if control.kind == ControlKind::Switch && value == "false" => 0,
        (Err(_), None) => return Err(format!("'{value}' is no value of the control {info}")),
    };
    if control.kind != ControlKind::Button && !(info.min..=info.max).contains(&number) {
        return Err(format!("{number} is out of the range of the control {info}"));
    }
    if !info.menu.is_empty() && info.menu.iter().all(|(value, _)| *value != number) {
        return Err(format!("{number} is not in the menu of the control {info}"));
    }
    i32::try_from(number).map_err(|_| format!("{name}: {number} takes more than 32 bits"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control(id: u32, kind: ControlKind, title: &str, [min, max, default]: [i64; 3]) -> DriverControl {
        let title = title.to_string();
        DriverControl { id, kind, title, min, max, step: 1, default, read_only: false, inactive: false }
    }

    fn webcam() -> (Vec<DriverControl>, Vec<ControlInfo>) {
        let there = vec![
            control(1, ControlKind::Number, "Brightness", [-64, 64, 0]),
            control(2, ControlKind::Menu, "Auto Exposure", [0, 3, 3]),
            control(3, ControlKind::Number, "Exposure Time, Absolute", [1, 5000, 157]),
            control(4, ControlKind::Switch, "White Balance, Automatic", [0, 1, 1]),
        ];
        let menu = vec![(1, "Manual Mode".to_string()), (3, "Aperture Priority Mode".to_string())];
        let info = |control: &DriverControl| ControlInfo {
            name: identifier(&control.title),
            min: control.min,
            max: control.max,
            step: 1,
            default: control.default,
            value: None,
            menu: if control.kind == ControlKind::Menu { menu.clone() } else { Vec::new() },
            inactive: false,
        };
        let infos = there.iter().map(info).collect();
        (there, infos)
    }

    fn planned(settings: &str) -> Result<Vec<(u32, Option<i32>, i32)>, String> {
        let (there, infos) = webcam();
        let settings: ControlSettings = settings.parse().unwrap();
        let steps = plan(&settings.0, &there, &infos)?;
        Ok(steps.iter().map(|step| (step.id, step.before, step.value)).collect())
    }

    #[test]
    fn manual_comes_after_auto_and_before_the_value() {
        let steps = planned("exposure_time_absolute=50,brightness=-3,auto_exposure=manual_mode").unwrap();
        assert_eq!(steps, [(2, Some(3), 1), (3, None, 50), (1, None, -3)]);
        assert_eq!(planned("auto_exposure=3").unwrap(), [(2, None, 3)]);
        assert_eq!(planned("white_balance_automatic=false").unwrap(), [(4, Some(1), 0)]);
    }

    #[test]
    fn what_a_control_cannot_be_is_refused_with_what_it_can() {
        let says = |settings: &str| planned(settings).unwrap_err();
        let name = says("brighness=1");
        assert!(name.contains("no control brighness; the nearest is brightness"), "{name}");
        let range = says("exposure_time_absolute=9999");
        assert!(range.contains("9999") && range.contains("1 to 5000"), "{range}");
        let menu = says("auto_exposure=2");
        assert!(menu.contains("2 is not in the menu") && menu.contains("1:manual_mode"), "{menu}");
        let word = says("auto_exposure=mnual");
        assert!(word.contains("'mnual' is no value") && word.contains("3:aperture_priority_mode"), "{word}");
    }

    #[test]
    fn what_a_device_made_of_a_value_is_said() {
        let applied = |is| Applied { name: "gain".into(), asked: 53, is }.text();
        assert_eq!(
            [applied(Some(53)), applied(Some(50)), applied(None)],
            ["gain 53", "gain 50 instead of 53", "gain pressed"]
        );
    }
}
