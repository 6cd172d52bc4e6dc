//! The number in the corner of each frame, and the detections of the same frame.

use std::collections::HashMap;
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, DetectionsHeader, Frame, FrameClient, Stop};
use tagbus_scene::number;

use super::pattern::Pattern;
use super::watch::Seen;
use crate::Failure;

/// A frame, by its camera's epoch and its sequence.
type Key = (u64, u64);

/// Listens to a camera and its detector for so long. Frames are looked at beside the messages, which are stamped as soon as they come.
pub(super) fn watch(
    options: &ConnectOptions,
    pattern: &Pattern,
    duration: Duration,
) -> Result<Seen, Failure> {
    let stop = Stop::new()?;
    let mut client = Client::connect(options)?;
    let mut frames = FrameClient::connect(&options.clone().stop(stop.clone()))?;
    let (numbers, messages) = thread::scope(|scope| {
        let looking = scope.spawn(move || read_numbers(&mut frames).map_err(|error| error.to_string()));
        let messages = collect(&mut client, duration);
        stop.trigger();
        let numbers = looking.join().map_err(|_| "looking at frames panicked")??;
        Ok::<_, Failure>((numbers, messages?))
    })?;
    let mut seen = Seen::default();
    for (header, client_ns) in &messages {
        let number = numbers.get(&(header.epoch, header.sequence));
        seen.take_shown(number.copied().map(u32::from), pattern, header, *client_ns);
    }
    if seen.is_empty() {
        return Err(format!(
            "none of {} frames shows a number: it belongs into the top left corner, {} x {} pixels",
            messages.len(),
            number::AREA.0,
            number::AREA.1
        )
        .into());
    }
    Ok(seen)
}

fn collect(client: &mut Client, duration: Duration) -> Result<Vec<(DetectionsHeader, u64)>, Failure> {
    let (begun, mut messages) = (Instant::now(), Vec::new());
    while begun.elapsed() < duration {
        if let Some(message) = client.receive(Duration::from_millis(200))? {
            messages.push((*message.header(), message.client_ns()));
        }
    }
    Ok(messages)
}

fn read_numbers(frames: &mut FrameClient) -> Result<HashMap<Key, u8>, Failure> {
    let mut numbers = HashMap::new();
    while let Some(frame) = frames.receive(Duration::from_secs(10))? {
        let header = frame.header();
        if let Some(number) = number_of(&frame) {
            numbers.insert((header.epoch, header.sequence), number);
        }
    }
    Ok(numbers)
}

/// `None` of frames without one.
fn number_of(frame: &Frame) -> Option<u8> {
    let (layout, bytes) = (frame.layout(), frame.bytes());
    if layout.width < number::AREA.0 || layout.height < number::AREA.1 {
        return None;
    }
    number::read(|x, y| bytes[layout.offset + y * layout.row_stride + x * layout.pixel_step])
}
