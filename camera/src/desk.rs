//! Requests to the camera: answered between frames, and never so many that frames would notice.

use std::time::Instant;

use tagbus_message::Local;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::control::{
    CameraAnswer, CameraAsk, CameraReply, CameraStatistics, DeviceControl, Outcome,
};
use tagbus_message::control_ports::CameraDesk;
use tagbus_message::info::CameraInfo;
use tagbus_message::qos::MAX_CONTROL_CLIENTS;
use tagbus_message::turns::Turns;

use crate::control::{ControlInfo, ControlSetting, ControlSettings, identifier};
use crate::run::Summary;

/// What can be done about the controls of a source.
pub(crate) trait Controls {
    /// Every control that can be set, with its value.
    fn list(&self) -> Vec<ControlInfo>;
    /// Sets controls and reads them back. An error says why not; nothing was set then, unless it is the driver that refused one:
    /// then those before it stay.
    fn set(&mut self, settings: &ControlSettings) -> Result<Changed, String>;
}

/// What became of controls that were set.
pub(crate) struct Changed {
    /// Each with its value, as the device says it.
    pub(crate) text: String,
    /// Exposure time in force, nanoseconds; 0 when not known.
    pub(crate) exposure_ns: u64,
    /// Whether the device chooses it.
    pub(crate) is_automatic: bool,
}

/// A source that has none, or none at present, and why.
pub(crate) struct NoControls<'a>(pub(crate) &'a str);

impl Controls for NoControls<'_> {
    fn list(&self) -> Vec<ControlInfo> {
        Vec::new()
    }

    fn set(&mut self, _settings: &ControlSettings) -> Result<Changed, String> {
        Err(self.0.to_owned())
    }
}

/// What an answer is made of.
pub(crate) struct Desk {
    server: CameraDesk<Local>,
    turns: Turns,
    started_ns: u64,
    counts: Counts,
    /// Counts at the last reset, and when that was.
    reset: (Counts, u64),
}

/// What statistics are made of.
#[derive(Clone, Copy, Default)]
struct Counts {
    frames: u64,
    damaged: u64,
    no_loan: u64,
    answered: u64,
    refused: u64,
}

impl Desk {
    pub(crate) fn new(server: CameraDesk<Local>) -> Self {
        let started_ns = monotonic_ns();
        let reset = (Counts::default(), started_ns);
        Self { server, turns: Turns::new(), started_ns, counts: Counts::default(), reset }
    }

    /// Answers one request of each client, when it is time to. `announce` is called when controls were changed.
    pub(crate) fn look(
        &mut self,
        summary: &Summary,
        info: &mut CameraInfo,
        controls: &mut dyn Controls,
        announce: &mut dyn FnMut(&mut CameraInfo),
    ) {
        let now = Instant::now();
        if !self.turns.may_answer(now) {
            return;
        }
        let answered_before = self.counts.answered;
        for _ in 0..MAX_CONTROL_CLIENTS {
            let Ok(Some(asked)) = self.server.next() else { break };
            let (counts, before) = (&mut self.counts, summary);
            (counts.frames, counts.damaged, counts.no_loan) = (before.frames, before.damaged, before.no_loan);
            let (outcome, text) = match asked.request().checked() {
                Ok(CameraAsk::Get) => (Outcome::Done, String::new()),
                Ok(CameraAsk::ResetStatistics) => {
                    self.reset = (self.counts, monotonic_ns());
                    (Outcome::Done, String::new())
                }
                Ok(CameraAsk::Set(settings)) => set(&settings, info, controls, announce),
                Err(fault) => (Outcome::Refused, fault.to_string()),
            };
            self.counts.answered += 1;
            self.counts.refused += u64::from(outcome == Outcome::Refused);
            asked.answer(&CameraReply::of(&self.report(outcome, text, info, controls)));
        }
        if self.counts.answered > answered_before {
            self.turns.answered(now, Instant::now());
        }
    }

    fn report(
        &self,
        outcome: Outcome,
        text: String,
        info: &CameraInfo,
        controls: &dyn Controls,
    ) -> CameraAnswer {
        CameraAnswer {
            outcome,
            text,
            info_number: info.number,
            state: info.camera_state(),
            controls: controls.list().into_iter().map(told).collect(),
            statistics: self.statistics(),
        }
    }

    fn statistics(&self) -> CameraStatistics {
        let (now, (then, since_ns)) = (&self.counts, &self.reset);
        CameraStatistics {
            started_ns: self.started_ns,
            since_ns: *since_ns,
            taken_ns: monotonic_ns(),
            frames: now.frames - then.frames,
            damaged: now.damaged - then.damaged,
            no_loan: now.no_loan - then.no_loan,
            requests_answered: now.answered - then.answered,
            requests_refused: now.refused - then.refused,
        }
    }
}

fn told(control: ControlInfo) -> DeviceControl {
    let ControlInfo { name, min, max, default, value, inactive, .. } = control;
    DeviceControl { name, min, max, default, value, inactive }
}

fn set(
    settings: &[(String, String)],
    info: &mut CameraInfo,
    controls: &mut dyn Controls,
    announce: &mut dyn FnMut(&mut CameraInfo),
) -> (Outcome, String) {
    let setting = |(name, value): &(String, String)| ControlSetting {
        name: identifier(name),
        value: value.trim().to_owned(),
    };
    let settings = ControlSettings(settings.iter().map(setting).collect());
    if settings.0.is_empty() {
        return (Outcome::Refused, "nothing to set: name at least one control".to_owned());
    }
    match controls.set(&settings) {
        Ok(Changed { text, exposure_ns, is_automatic }) => {
            (info.exposure_ns, info.auto_exposure) = (exposure_ns, is_automatic.into());
            announce(info);
            (Outcome::Done, text)
        }
        Err(reason) => (Outcome::Refused, reason),
    }
}
