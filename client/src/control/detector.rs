//! A detector's parameters, state and statistics.

use std::time::Duration;

use tagbus_message::bus::Bus;
use tagbus_message::control::{
    DetectorAnswer, DetectorAsk, DetectorChange, DetectorReply, DetectorRequest, Outcome,
};

use super::error::ControlError;
use super::exchange::Exchange;
use crate::error::ConnectError;
use crate::options::ConnectOptions;

/// A connection to a running detector by which it is asked and told.
///
/// Eight programs can be connected to one detector; connect, ask and drop when more may want to.
pub struct DetectorControl {
    exchange: Exchange<DetectorRequest, DetectorReply>,
}

impl DetectorControl {
    /// Connects to a detector; waits for it where it does not run yet.
    pub fn connect(options: &ConnectOptions) -> Result<Self, ConnectError> {
        let (camera, detector) = (options.camera.clone(), options.detector.clone());
        let role = format!("detector {detector} of camera {camera}");
        let open =
            move |bus: &Bus<_>, patience| Bus::open_detector_control(bus, &camera, &detector, patience);
        Ok(Self { exchange: Exchange::connect(options, &role, Box::new(open))? })
    }

    /// Another limit to waiting for an answer than [`super::DEFAULT_TIMEOUT`].
    #[must_use]
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.exchange.timeout = timeout;
        self
    }

    /// All parameters in force, state and statistics.
    pub fn get(&mut self) -> Result<DetectorAnswer, ControlError> {
        self.ask(&DetectorAsk::Get)
    }

    /// Other parameters from the next frame on: all of the change, or none of it.
    ///
    /// The answer's number is [`crate::DetectionsHeader::control_number`] of every message from then on, until the next
    /// change by anybody.
    pub fn set(&mut self, change: &DetectorChange) -> Result<DetectorAnswer, ControlError> {
        self.ask(&DetectorAsk::Set(change.clone()))
    }

    /// Statistics that begin anew. Counters in headers of messages go on.
    pub fn reset_statistics(&mut self) -> Result<DetectorAnswer, ControlError> {
        self.ask(&DetectorAsk::ResetStatistics)
    }

    fn ask(&mut self, ask: &DetectorAsk) -> Result<DetectorAnswer, ControlError> {
        let request = DetectorRequest::of(ask).map_err(ControlError::Request)?;
        let answer = self.exchange.ask(&request)?.checked().map_err(ControlError::Answer)?;
        match answer.outcome {
            Outcome::Done => Ok(answer),
            Outcome::Refused | Outcome::Unknown => {
                Err(ControlError::Refused { role: self.exchange.role().to_owned(), reason: answer.text })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_connection_may_move_to_another_thread() {
        fn moves<T: Send>() {}
        moves::<DetectorControl>();
        moves::<super::super::CameraControl>();
    }
}
