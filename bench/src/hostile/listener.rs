//! An honest client within the bench: what it gets while others are attacked.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use tagbus_client::{Client, ConnectOptions, ReceiveError, Stop};

use crate::Failure;
use crate::crowd::Tally;

/// Counts in a thread of its own.
pub(super) struct Listener {
    tally: Arc<Mutex<Tally>>,
    stop: Stop,
    thread: JoinHandle<Result<(), ReceiveError>>,
}

impl Listener {
    pub(super) fn start(options: &ConnectOptions) -> Result<Self, Failure> {
        let stop = Stop::new()?;
        let mut client = Client::connect(&options.clone().stop(stop.clone()))?;
        let tally = Arc::new(Mutex::new(Tally::default()));
        let (own, end) = (Arc::clone(&tally), stop.clone());
        let thread = thread::Builder::new().name("listener".to_owned()).spawn(move || {
            while !end.is_triggered() {
                if let Some(message) = client.receive(Duration::from_secs(1))? {
                    own.lock().unwrap_or_else(PoisonError::into_inner).take(&message);
                }
            }
            Ok(())
        })?;
        Ok(Self { tally, stop, thread })
    }

    /// What it counted so far.
    pub(super) fn tally(&self) -> Tally {
        self.tally.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn end(self) -> Result<Tally, Failure> {
        self.stop.trigger();
        match self.thread.join() {
            Ok(outcome) => outcome?,
            Err(_) => return Err("a client panicked".into()),
        }
        Ok(Arc::into_inner(self.tally)
            .and_then(|tally| tally.into_inner().ok())
            .ok_or("the client still counts")?)
    }
}
