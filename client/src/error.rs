//! What can go wrong for a client.

use std::fmt;
use std::io;
use std::time::Duration;

use tagbus_message::bus::BusError;
use tagbus_message::wait::WaitError;

/// Why a client could not connect.
#[derive(Debug)]
#[non_exhaustive]
pub enum ConnectError {
    /// Nobody published in time.
    Absent {
        /// Who was waited for, such as "detector main of camera cam0".
        publisher: String,
        /// The domain in which it was waited for.
        domain: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// Waiting was ended by [`crate::ConnectOptions::stop`].
    Stopped,
    /// The bus cannot be used; its message says what to do.
    Bus(BusError),
    /// The process has no file descriptor left.
    Wait(WaitError),
    /// The process has no file descriptor left.
    Io(io::Error),
}

impl fmt::Display for ConnectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent { publisher, domain, waited } => write!(
                f,
                "{publisher} did not appear in domain {domain} within {:.1} s: start it, under the same user and with the same --domain",
                waited.as_secs_f64()
            ),
            Self::Stopped => write!(f, "stopped while connecting"),
            Self::Bus(error) => error.fmt(f),
            Self::Wait(error) => error.fmt(f),
            Self::Io(error) => write!(f, "no socket for waking the client: {error}"),
        }
    }
}

impl std::error::Error for ConnectError {}

/// Why a client could not receive.
#[derive(Debug)]
#[non_exhaustive]
pub enum ReceiveError {
    /// The program holds as many messages as it may: drop one.
    Held {
        /// How many may be held at once.
        limit: usize,
    },
    /// The topic was removed by force and cannot be opened again.
    Bus(BusError),
    /// The operating system refuses to wait.
    Wait(WaitError),
    /// The connection to the publisher is broken; iceoryx2's word for it.
    Broken(String),
}

impl fmt::Display for ReceiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Held { limit } => {
                write!(
                    f,
                    "{limit} messages are held already, which is the limit: drop one before receiving the next"
                )
            }
            Self::Bus(error) => error.fmt(f),
            Self::Wait(error) => error.fmt(f),
            Self::Broken(reason) => write!(f, "the connection to the publisher is broken ({reason})"),
        }
    }
}

impl std::error::Error for ReceiveError {}
