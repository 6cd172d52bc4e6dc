//! What every process on the bus has in common: signals end it in good order, and so does its parent's end.

use std::io;
use std::thread;

use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use tagbus_message::stop::Stop;

use crate::outcome::Failure;

/// A stop request that SIGINT, SIGTERM and the end of `parent` trigger.
pub(crate) fn stop(parent: Option<i32>) -> Result<Stop, Failure> {
    let stop = Stop::new()?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let of_signals = stop.clone();
    // The thread ends with the process: it holds nothing that has to be given back.
    thread::Builder::new().name("signals".to_owned()).spawn(move || {
        for _ in signals.forever() {
            of_signals.trigger();
        }
    })?;
    if let Some(parent) = parent {
        end_with(parent, &stop)?;
    }
    Ok(stop)
}

/// From now on the kernel sends SIGTERM when the parent dies, even by kill -9.
fn end_with(parent: i32, stop: &Stop) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // It may have died before that was asked for.
    if getppid().map(Pid::as_raw_pid) != Some(parent) {
        stop.trigger();
    }
    Ok(())
}
