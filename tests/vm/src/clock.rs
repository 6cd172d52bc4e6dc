//! How old a frame is at a client, by the number that it shows and not by any stamp.
//!
//! ```text
//!  number written into the frame ─▶ player ─▶ output node ─▶ capture node: stamp ─▶ dequeue ─▶ sending ─▶ client
//!  (steps of CLOCK_MONOTONIC)        └──────── nobody else knows how long ─────┘
//! ```

use std::collections::HashMap;
use std::io::{self, Write};
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, DetectionsHeader, FrameClient, Stop};
use tagbus_message::clock::monotonic_ns;
use tagbus_scene::number;

use crate::Failure;
use crate::pictures::{COUNT, Pictures};

/// A new number each so many nanoseconds: no multiple of a frame's time.
const STEP_NS: u64 = 7_000_000;
/// Numbers that a byte holds; what is older is taken for younger.
const NUMBERS: u64 = 256;
/// Messages of which the number has to be known.
const MESSAGES: usize = 40;
/// Long enough for an emulated processor.
const PATIENCE: Duration = Duration::from_secs(45);

/// Writes frames with the number of the moment until nobody reads them.
pub(crate) fn tell(size: &str, folder: &str) -> Result<(), Failure> {
    let pictures = Pictures::read(size, folder)?;
    let mut out = io::stdout().lock();
    for picture in (0..COUNT).cycle() {
        let mut luma = pictures.luma(picture).to_vec();
        number::write(&mut luma, pictures.width, (monotonic_ns() / STEP_NS % NUMBERS) as u8);
        match out.write_all(&luma) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => break,
            written => written?,
        }
    }
    Ok(())
}

/// Listens to frames and detections, and says how late stamps and client are after the number was written.
pub(crate) fn read() -> Result<(), Failure> {
    let stop = Stop::new()?;
    let options = ConnectOptions::new("tagbus")?.deadline(PATIENCE);
    let (mut frames, mut client) =
        (FrameClient::connect(&options.clone().stop(stop.clone()))?, Client::connect(&options)?);
    // Messages are stamped as soon as they come, while frames are looked at beside.
    let (numbers, messages) = thread::scope(|scope| {
        let looking = scope.spawn(move || numbers_of(&mut frames).map_err(|error| error.to_string()));
        let messages = messages_of(&mut client);
        stop.trigger();
        let numbers = looking.join().map_err(|_| "looking at frames panicked")??;
        Ok::<_, Failure>((numbers, messages?))
    })?;
    let ages: Vec<[i64; 4]> = messages
        .iter()
        .filter_map(|(header, client_ns)| {
            let number = numbers.get(&(header.epoch, header.sequence))?;
            Some(ages(u64::from(*number), header, *client_ns))
        })
        .collect();
    report(&ages)
}

fn numbers_of(frames: &mut FrameClient) -> Result<HashMap<(u64, u64), u8>, Failure> {
    let mut numbers = HashMap::new();
    while let Some(frame) = frames.receive(PATIENCE)? {
        let (header, layout, bytes) = (frame.header(), frame.layout(), frame.bytes());
        let at = |x: usize, y: usize| bytes[layout.offset + y * layout.row_stride + x * layout.pixel_step];
        if let Some(number) = number::read(at) {
            numbers.insert((header.epoch, header.sequence), number);
        }
    }
    Ok(numbers)
}

fn messages_of(client: &mut Client) -> Result<Vec<(DetectionsHeader, u64)>, Failure> {
    let (begun, mut messages) = (Instant::now(), Vec::new());
    // Before the loop is closed the driver shows a picture of its own; some frames are not looked at in time.
    while messages.len() < 3 * MESSAGES && begun.elapsed() < PATIENCE {
        if let Some(message) = client.receive(Duration::from_millis(200))? {
            messages.push((*message.header(), message.client_ns()));
        }
    }
    Ok(messages)
}

/// From the earliest moment at which the number can have been written to stamp, dequeue, sending and client, nanoseconds; the number was
/// written up to a step later.
fn ages(number: u64, header: &DetectionsHeader, client_ns: u64) -> [i64; 4] {
    let now = client_ns / STEP_NS;
    let written_ns = (now - (now + NUMBERS - number) % NUMBERS) * STEP_NS;
    [header.capture_ns, header.dequeue_ns, header.publish_ns, client_ns]
        .map(|stamp_ns| stamp_ns as i64 - written_ns as i64)
}

fn report(ages: &[[i64; 4]]) -> Result<(), Failure> {
    let shown = |hop: usize| {
        let mut values: Vec<i64> = ages.iter().map(|ages| ages[hop] - STEP_NS as i64 / 2).collect();
        values.sort_unstable();
        let at = |place: usize| values.get(place).map_or(0.0, |&age| age as f64 / 1e6);
        format!("{:.1} ms ({:.1} to {:.1})", at(values.len() / 2), at(0), at(values.len().saturating_sub(1)))
    };
    println!(
        "clock: {} messages, from their number to the stamp {}, dequeue {}, sending {}, client {}; +- {} ms each",
        ages.len(),
        shown(0),
        shown(1),
        shown(2),
        shown(3),
        STEP_NS / 2_000_000
    );
    if ages.len() < MESSAGES {
        return Err(
            format!("the number of only {} frames was read, of {MESSAGES} at least", ages.len()).into()
        );
    }
    match ages.iter().flatten().min() {
        Some(age) if *age < 0 => Err("a stamp is older than what its frame shows".into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_age_is_known_to_a_step_however_late_a_frame_comes() {
        for written_ns in [2_000_000_000_u64, 2_000_000_001, 9_999_999_999] {
            for late_ns in [0, 1, 33_000_000, 1_000_000_000] {
                let client_ns = written_ns + late_ns;
                let header = DetectionsHeader { capture_ns: client_ns - late_ns / 2, ..Default::default() };
                let [stamp, .., client] = ages(written_ns / STEP_NS % NUMBERS, &header, client_ns);
                assert!((late_ns..late_ns + STEP_NS).contains(&(client as u64)), "{client}");
                assert_eq!(client - stamp, (late_ns / 2) as i64);
            }
        }
    }

    #[test]
    fn a_stamp_before_the_number_and_too_few_messages_are_errors() {
        assert!(report(&[[0; 4]; MESSAGES]).is_ok());
        assert!(report(&[[0; 4]; MESSAGES - 1]).is_err());
        assert!(report(&[[-1, 0, 0, 0]; MESSAGES]).is_err());
    }
}
