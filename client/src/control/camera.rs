//! A camera's controls, state and statistics.

use std::time::Duration;

use tagbus_message::bus::Bus;
use tagbus_message::control::{CameraAnswer, CameraAsk, CameraReply, CameraRequest, Outcome};

use super::error::ControlError;
use super::exchange::Exchange;
use crate::error::ConnectError;
use crate::options::ConnectOptions;

/// A connection to a running camera by which it is asked and told.
///
/// Eight programs can be connected to one camera; connect, ask and drop when more may want to.
pub struct CameraControl {
    exchange: Exchange<CameraRequest, CameraReply>,
}

impl CameraControl {
    /// Connects to a camera; waits for it where it does not run yet. Only [`ConnectOptions::camera`] counts, not its
    /// detector.
    pub fn connect(options: &ConnectOptions) -> Result<Self, ConnectError> {
        let camera = options.camera.clone();
        let role = format!("camera {camera}");
        let open = move |bus: &Bus<_>, patience| Bus::open_camera_control(bus, &camera, patience);
        Ok(Self { exchange: Exchange::connect(options, &role, Box::new(open))? })
    }

    /// Another limit to waiting for an answer than [`super::DEFAULT_TIMEOUT`].
    #[must_use]
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.exchange.timeout = timeout;
        self
    }

    /// All controls with their values, state and statistics.
    pub fn get(&mut self) -> Result<CameraAnswer, ControlError> {
        self.ask(&CameraAsk::Get)
    }

    /// Sets controls by name and value (a number, or an entry of a menu) between two frames: none of them when one is out of
    /// its range or not known. Where the driver itself refuses one, those before it stay. The answer tells what the device made of it, and the number of the camera's information that frames name
    /// from then on.
    pub fn set(&mut self, controls: &[(&str, &str)]) -> Result<CameraAnswer, ControlError> {
        let own = |&(name, value): &(&str, &str)| (name.to_owned(), value.to_owned());
        self.ask(&CameraAsk::Set(controls.iter().map(own).collect()))
    }

    /// Statistics that begin anew.
    pub fn reset_statistics(&mut self) -> Result<CameraAnswer, ControlError> {
        self.ask(&CameraAsk::ResetStatistics)
    }

    fn ask(&mut self, ask: &CameraAsk) -> Result<CameraAnswer, ControlError> {
        let request = CameraRequest::of(ask).map_err(ControlError::Request)?;
        let answer = self.exchange.ask(&request)?.checked().map_err(ControlError::Answer)?;
        match answer.outcome {
            Outcome::Done => Ok(answer),
            Outcome::Refused | Outcome::Unknown => {
                Err(ControlError::Refused { role: self.exchange.role().to_owned(), reason: answer.text })
            }
        }
    }
}
