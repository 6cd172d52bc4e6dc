//! Shows that the detector reads what the driver wrote, where the driver wrote it.
//!
//! ```text
//! kernel   a probe lists each address that it pins for the driver to write to    camera's address space
//! /proc    both sides' mappings: address ─▶ file and offset                      the same for both
//! here     a detector that notes from which address it reads each frame          this process's address space
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use tagbus_family::Family;
use tagbus_message::domain::Domain;
use tagbus_message::frame::FrameHeader;
use tagbus_message::stop::Stop;
use tagbus_service::ServiceConfig;

use crate::Failure;
use crate::place::{Mappings, Place};

/// Frames that are looked at.
const FRAMES: usize = 120;

/// Long enough for an emulated processor.
const PATIENCE: Duration = Duration::from_secs(60);

/// Detects in the frames of the camera with this process number, then compares with what the kernel has listed in `trace`.
pub(crate) fn prove(camera: &str, trace: &str) -> Result<(), Failure> {
    let Reading { addresses: read, mappings: ours } = read_frames()?;
    let cameras = Mappings::of(camera)?;
    let pinned = addresses_pinned(&fs::read_to_string(trace)?);
    let places = |mappings: &Mappings, addresses: &[u64]| -> Result<BTreeSet<Place>, Failure> {
        let place =
            |address: &u64| mappings.place(*address).ok_or("an address outside of shared memory".into());
        addresses.iter().map(place).collect()
    };
    let (read_at, pinned_at) = (places(&ours, &read)?, places(&cameras, &pinned)?);
    let elsewhere = read_at.difference(&pinned_at).count();
    println!(
        "proof: {} frames were read at {} places, {elsewhere} of them not where the driver wrote; the kernel pinned memory {} times, {} \
         places",
        read.len(),
        read_at.len(),
        pinned.len(),
        pinned_at.len()
    );
    if elsewhere > 0 || pinned.len() > pinned_at.len() {
        return Err("frames were read elsewhere than they were written, or memory was pinned again".into());
    }
    Ok(())
}

/// Where the detector of this process read.
struct Reading {
    /// The first byte of each frame's luma.
    addresses: Vec<u64>,
    mappings: Mappings,
}

/// Detects in frames and notes where they lie.
fn read_frames() -> Result<Reading, Failure> {
    let (stop, seen) = (Stop::new()?, Arc::new(Mutex::new(Vec::new())));
    let (tell_mappings, mappings) = channel();
    let mut config = ServiceConfig::new(Domain::new("tagbus")?, vec![Family::published("tag36h11")?]);
    config.detector = "proof".to_string();
    // Nobody subscribes: only where frames lie is looked at.
    config.always = true;
    let (end, notes) = (stop.clone(), Arc::clone(&seen));
    config.observer = Some(Box::new(move |frame| {
        let mut notes = notes.lock().unwrap_or_else(PoisonError::into_inner);
        let FrameHeader { data_offset, copies, .. } = *frame.header;
        let picture = frame.payload.start.addr() + data_offset as usize;
        // What the detector reads begins with the picture, and of a frame that was copied nothing is shown.
        let first_luma = frame.view.bytes().as_ptr().addr() + frame.view.geometry().offset;
        if copies == 0 && first_luma == picture {
            notes.push(picture as u64);
        }
        if notes.len() == FRAMES {
            // Now: at its end the service unmaps all of it.
            let _ = tell_mappings.send(Mappings::of("self").map_err(|error| error.to_string()));
            end.trigger();
        }
    }));
    give_up_after(PATIENCE, stop.clone());
    tagbus_service::run(config, stop)?;
    let addresses = seen.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let mappings = mappings.try_recv().map_err(|_| format!("only {} frames came", addresses.len()))??;
    Ok(Reading { addresses, mappings })
}

/// Triggers a stop unless somebody else has done so in time.
fn give_up_after(patience: Duration, stop: Stop) {
    thread::spawn(move || {
        if !stop.wait(patience) {
            stop.trigger();
        }
    });
}

/// The addresses in the lines of the kernel's probe, as `vaddr=0x...`.
fn addresses_pinned(trace: &str) -> Vec<u64> {
    let words = trace.split_ascii_whitespace().filter_map(|word| word.strip_prefix("vaddr=0x"));
    words.filter_map(|number| u64::from_str_radix(number, 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_from_the_probes_lines() {
        let trace = "# tracer: nop\n tagbus-91 [000] ..... 7.1: pinned: (vb2_vmalloc_get_userptr+0x0) vaddr=0x7fff12 size=0x4b000\n";
        assert_eq!(addresses_pinned(trace), [0x7f_ff12]);
    }
}
