//! Why a request had no success.

use std::fmt;
use std::time::Duration;

use tagbus_message::bus::BusError;
use tagbus_message::control::ControlFault;

/// Why a request had no success.
#[derive(Debug)]
#[non_exhaustive]
pub enum ControlError {
    /// The request was understood and is not possible; nothing has changed.
    Refused {
        /// Who was asked, such as "detector main of camera cam0".
        role: String,
        /// Which value is not possible, and what is.
        reason: String,
    },
    /// The request cannot even be written.
    Request(ControlFault),
    /// The answer makes no sense, or is of another version.
    Answer(ControlFault),
    /// No answer came in time. Whether the request was obeyed is not known: ask.
    Silent {
        /// Who was asked.
        role: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// Nobody is there to answer any more.
    Gone {
        /// Who was asked.
        role: String,
    },
    /// Waiting was ended by [`crate::ConnectOptions::stop`].
    Stopped,
    /// The topic was removed by force and cannot be opened again.
    Bus(BusError),
    /// The connection cannot be used; what is wrong with it.
    Broken(String),
}

impl fmt::Display for ControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { role, reason } => write!(f, "{role}: {reason}"),
            Self::Request(fault) => fault.fmt(f),
            Self::Answer(fault) => write!(f, "the answer cannot be read: {fault}"),
            Self::Silent { role, waited } => write!(
                f,
                "{role} did not answer within {:.1} s: does it hang? whether it obeyed is not known",
                waited.as_secs_f64()
            ),
            Self::Gone { role } => write!(f, "{role} does not run any more: start it"),
            Self::Stopped => write!(f, "stopped while waiting for an answer"),
            Self::Bus(error) => error.fmt(f),
            Self::Broken(reason) => write!(f, "the request cannot be sent or answered: {reason}"),
        }
    }
}

impl std::error::Error for ControlError {}
