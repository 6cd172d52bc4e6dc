//! A receiver as a process of its own: takes frames until the last, notes when it had each, reads it, tells all at the end.

use std::fs::File;
use std::hint::black_box;
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{CallbackProgression, SignalHandlingMode, WaitSetBuilder};
use tagbus_message::Local;
use tagbus_message::bus::{Bus, Patience};
use tagbus_message::clock::monotonic_ns;
use tagbus_message::domain::Domain;
use tagbus_message::ports::FramesIn;
use tagbus_message::qos;
use tagbus_message::stop::Stop;
use tagbus_message::topics;
use tagbus_message::wait::{WaitSet, Waiter, Wake};

use super::copied::{BYTES, END, Label, WARM_UP};
use super::way::Way;
use super::zeromq;
use crate::Failure;

/// A sender that is silent for so long has died.
const PATIENCE: Duration = Duration::from_secs(30);
/// What a receiver writes when frames may come.
pub(super) const READY: &str = "READY";

/// Where frames come from.
#[derive(clap::Args)]
pub(crate) struct ReceiveOrder {
    #[arg(long)]
    pub(super) way: Way,
    /// Domain and root of the bus, or the address of ZeroMQ's publisher.
    #[arg(long, default_value = "")]
    pub(super) domain: String,
    #[arg(long, default_value = "")]
    pub(super) root: PathBuf,
    #[arg(long, default_value = "")]
    pub(super) address: String,
    /// Bytes of a picture.
    #[arg(long)]
    pub(super) bytes: usize,
}

/// Nanoseconds that one frame took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Taken {
    /// From its sending to its receiver having it.
    pub(super) awake: u64,
    /// The same from the moment at which its sender began to write it.
    pub(super) written: u64,
    /// The same until its receiver has read every byte.
    pub(super) read: u64,
}

/// What a receiver knows at the end.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    pub(super) taken: Vec<Taken>,
    /// CPU time of the process after the warm-up, microseconds.
    pub(super) cpu_us: f64,
}

/// Whether there will be more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outlook {
    More,
    Over,
}

impl Notes {
    fn new() -> Self {
        Self { taken: Vec::with_capacity(1 << 16), cpu_us: 0.0 }
    }

    /// A frame is there: notes when, reads all of it.
    pub(super) fn take(&mut self, label: Label, picture: &[u8]) -> Outlook {
        let awake_ns = monotonic_ns();
        if label.sequence == END {
            self.cpu_us = crate::clock::now_us() - self.cpu_us;
            return Outlook::Over;
        }
        black_box(sum(picture));
        let read_ns = monotonic_ns();
        if label.sequence < WARM_UP {
            self.cpu_us = crate::clock::now_us();
            return Outlook::More;
        }
        let Label { written_ns, sent_ns, .. } = label;
        self.taken.push(Taken {
            awake: awake_ns.saturating_sub(sent_ns),
            written: awake_ns.saturating_sub(written_ns),
            read: read_ns.saturating_sub(written_ns),
        });
        Outlook::More
    }

    fn write(&self, mut out: impl Write) -> io::Result<()> {
        writeln!(out, "{:.3}", self.cpu_us)?;
        self.taken
            .iter()
            .try_for_each(|Taken { awake, written, read }| writeln!(out, "{awake} {written} {read}"))
    }

    /// What another process wrote; `None` when it is none of ours.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let cpu_us = lines.next()?.parse().ok()?;
        let taken: Option<Vec<Taken>> = lines.map(taken).collect();
        Some(Self { taken: taken?, cpu_us })
    }
}

fn taken(line: &str) -> Option<Taken> {
    let numbers: Vec<u64> = line.split(' ').map_while(|word| word.parse().ok()).collect();
    let [awake, written, read] = numbers[..] else { return None };
    Some(Taken { awake, written, read })
}

/// All words of a picture together: as a detector does, this touches every byte.
fn sum(picture: &[u8]) -> u64 {
    let (words, rest) = picture.as_chunks::<8>();
    let rest: u64 = rest.iter().map(|&byte| u64::from(byte)).sum();
    words.iter().fold(rest, |sum, &word| sum.wrapping_add(u64::from_ne_bytes(word)))
}

/// Receives until the last frame, then writes what was noted.
pub(crate) fn receive(order: &ReceiveOrder) -> Result<(), Failure> {
    let mut notes = Notes::new();
    match order.way {
        Way::Bus | Way::WaitSet | Way::Polling => from_bus(order, &mut notes)?,
        Way::Unix | Way::Pipe => from_standard_input(order, &mut notes)?,
        Way::Zeromq => zeromq::receive(&order.address, tell_ready, &mut notes)?,
    }
    let out = io::stdout().lock();
    Ok(notes.write(io::BufWriter::new(out))?)
}

/// Frames may come from now on.
fn tell_ready() -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{READY}")?;
    out.flush()
}

fn from_standard_input(order: &ReceiveOrder, notes: &mut Notes) -> Result<(), Failure> {
    let mut input = File::from(io::stdin().as_fd().try_clone_to_owned()?);
    let mut frame = vec![0; BYTES + order.bytes];
    tell_ready()?;
    loop {
        input.read_exact(&mut frame)?;
        if notes.take(Label::read(&frame), &frame[BYTES..]) == Outlook::Over {
            return Ok(());
        }
    }
}

fn from_bus(order: &ReceiveOrder, notes: &mut Notes) -> Result<(), Failure> {
    let domain = Domain::with_root(&order.domain, &order.root)?;
    let stop = Stop::new()?;
    let bus = Bus::<Local>::start(&domain, "receiver", &stop)?;
    let frames = bus.open_frames(CAMERA, qos::DETECTOR_FRAME_BUFFER, Patience::AtMost(PATIENCE))?;
    match order.way {
        Way::Bus => awake_by_event(&frames, &stop, notes),
        Way::WaitSet => awake_by_wait_set(&bus, &frames, notes),
        _ => polling(&frames, notes),
    }
}

/// Name of the camera that a sender is.
pub(super) const CAMERA: &str = "cam0";

/// Takes the newest frame, if there is one; says how it stands then.
fn take_newest(frames: &FramesIn<Local>, notes: &mut Notes) -> Result<Option<Outlook>, Failure> {
    let frame = frames.newest().map_err(|error| format!("a frame could not be received ({error:?})"))?;
    let Some(frame) = frame else { return Ok(None) };
    // Copied out once and checked by every reader of frames; here the picture is read as it lies.
    let header = *frame.user_header();
    let label =
        Label { sequence: header.sequence, written_ns: header.dequeue_ns, sent_ns: header.publish_ns };
    Ok(Some(notes.take(label, frame.payload())))
}

fn awake_by_event(frames: &FramesIn<Local>, stop: &Stop, notes: &mut Notes) -> Result<(), Failure> {
    let set = WaitSet::new()?;
    let waiter = Waiter::<Local>::new(&set, stop, Some(frames.bell()))?;
    tell_ready()?;
    loop {
        match take_newest(frames, notes)? {
            Some(Outlook::Over) => return Ok(()),
            Some(Outlook::More) | None => {}
        }
        if waiter.wait(PATIENCE)? == Wake::TimedOut {
            return Err("no frame came".into());
        }
    }
}

/// As every role waited once, and as a program does that knows iceoryx2 and not tagbus: an event, its own wait set, and the event taken from
/// its socket before the frame is.
fn awake_by_wait_set(bus: &Bus<Local>, frames: &FramesIn<Local>, notes: &mut Notes) -> Result<(), Failure> {
    let trouble = |error: &dyn std::fmt::Debug| format!("the wait set fails ({error:?})");
    let name = topics::frames(CAMERA)?.as_str().try_into().map_err(|error| trouble(&error))?;
    let events = bus.node().service_builder(&name).event().open().map_err(|error| trouble(&error))?;
    let listener = events.listener_builder().create().map_err(|error| trouble(&error))?;
    let set = WaitSetBuilder::new().signal_handling_mode(SignalHandlingMode::Disabled);
    let set = set.create::<Local>().map_err(|error| trouble(&error))?;
    let guard = set.attach_notification(&listener).map_err(|error| trouble(&error))?;
    tell_ready()?;
    loop {
        let mut is_event = false;
        let wait = set.wait_and_process_once_with_timeout(
            |id| {
                is_event |= id.has_event_from(&guard);
                CallbackProgression::Continue
            },
            PATIENCE,
        );
        wait.map_err(|error| trouble(&error))?;
        if !is_event {
            return Err("no frame came".into());
        }
        listener.try_wait(|_| ()).map_err(|error| trouble(&error))?;
        if take_newest(frames, notes)? == Some(Outlook::Over) {
            return Ok(());
        }
    }
}

fn polling(frames: &FramesIn<Local>, notes: &mut Notes) -> Result<(), Failure> {
    tell_ready()?;
    let mut last = Instant::now();
    loop {
        match take_newest(frames, notes)? {
            Some(Outlook::Over) => return Ok(()),
            Some(Outlook::More) => last = Instant::now(),
            None if last.elapsed() > PATIENCE => return Err("no frame came".into()),
            None => std::thread::yield_now(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_receiver_writes_is_read_back_and_the_warm_up_is_left_out() {
        let mut notes = Notes::new();
        for sequence in [0, WARM_UP - 1, WARM_UP, WARM_UP + 1] {
            let sent_ns = monotonic_ns();
            let label = Label { sequence, written_ns: sent_ns - 1000, sent_ns };
            assert_eq!(notes.take(label, &[1; 100]), Outlook::More);
        }
        let end = Label { sequence: END, written_ns: 0, sent_ns: 0 };
        assert_eq!(notes.take(end, &[]), Outlook::Over);
        assert_eq!(notes.taken.len(), 2);
        assert!(notes.taken.iter().all(|taken| taken.written == taken.awake + 1000));
        assert!(notes.taken.iter().all(|taken| taken.read >= taken.written));
        let mut text = Vec::new();
        notes.write(&mut text).unwrap();
        let again = Notes::parse(std::str::from_utf8(&text).unwrap()).unwrap();
        assert_eq!(again.taken, notes.taken);
        assert!((again.cpu_us - notes.cpu_us).abs() < 0.001);
        assert!(Notes::parse("1.0\n1 2").is_none() && Notes::parse("").is_none());
    }

    #[test]
    fn every_byte_counts() {
        let mut picture = vec![3; 1003];
        let before = sum(&picture);
        for place in [0, 500, 999, 1002] {
            picture[place] += 1;
            assert_ne!(sum(&picture), before);
            picture[place] -= 1;
        }
    }
}
