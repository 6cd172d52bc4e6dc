//! Holds frames and detections against what was played.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use tagbus_client::{Client, ConnectOptions, Detections, Frame, FrameClient};
use tagbus_message::detection::TagDetection;
use tagbus_message::frame::CaptureKind;
use tagbus_scene::number;

use crate::Failure;
use crate::pictures::{COUNT, Known, Pictures};

/// Corners may lie this far from the truth, in pixels: what blur and noise of the scene do to a tag of three pixels a cell.
const CORNER_TOLERANCE_PX: f64 = 0.5;

/// What is expected.
#[derive(Debug)]
struct Expected {
    copies: u32,
    /// Pixels of a frame that have to be those of its picture, in hundredths.
    same: usize,
    /// The moment that stamps mark, or `any`.
    kind: String,
    /// The bus on which it is looked for.
    domain: String,
    frames: u32,
    seconds: u64,
}

/// What was seen.
#[derive(Debug, Default)]
struct Seen {
    /// The picture of each frame, by epoch and sequence.
    pictures: HashMap<(u64, u64), usize>,
    /// Frames whose detections were held against the truth.
    judged: u32,
    tags: u32,
    worst_px: f64,
    lost_in_driver: u64,
    /// From the driver's stamp to the camera's sending, and from the dequeue to there.
    waits_us: Vec<u64>,
    passes_us: Vec<u64>,
    formats: Vec<String>,
}

/// Receives frames and detections until enough of both were right; the first wrong one is an error.
pub(crate) fn judge(size: &str, folder: &str, options: &[&str]) -> Result<(), Failure> {
    let expected = expected(options)?;
    let pictures = Pictures::read(size, folder)?;
    let deadline = Instant::now() + Duration::from_secs(expected.seconds);
    let connect = ConnectOptions::new(&expected.domain)?.deadline(Duration::from_secs(expected.seconds));
    let mut frames = FrameClient::connect(&connect)?;
    let mut detections = Client::connect(&connect)?;
    let mut seen = Seen::default();
    while seen.judged < expected.frames {
        if Instant::now() >= deadline {
            return Err(format!("not enough in {} s: {}", expected.seconds, seen.summary()).into());
        }
        if let Some(frame) = frames.receive(Duration::from_millis(200))? {
            check_frame(&frame, &pictures, &expected, &mut seen)?;
        }
        while let Some(message) = detections.receive(Duration::ZERO)? {
            check_detections(&message, &pictures, &mut seen)?;
        }
    }
    println!("judge: {}", seen.summary());
    if frames.refused().0 > 0 { Err("frames with impossible headers".into()) } else { Ok(()) }
}

fn expected(options: &[&str]) -> Result<Expected, Failure> {
    let mut expected = Expected {
        copies: 0,
        same: 100,
        kind: "start_of_exposure".to_string(),
        domain: "tagbus".to_string(),
        frames: 30,
        seconds: 60,
    };
    for option in options.chunks(2) {
        match option {
            ["--copies", copies] => expected.copies = copies.parse()?,
            ["--same", same] => expected.same = same.parse()?,
            ["--kind", kind] => expected.kind = (*kind).to_string(),
            ["--domain", domain] => expected.domain = (*domain).to_string(),
            ["--frames", frames] => expected.frames = frames.parse()?,
            ["--seconds", seconds] => expected.seconds = seconds.parse()?,
            other => return Err(format!("unknown option {other:?}").into()),
        }
    }
    Ok(expected)
}

/// Every byte of luma must be that of the picture whose number it shows; where colours are missing in a mosaic, every second.
fn check_frame(
    frame: &Frame,
    pictures: &Pictures,
    expected: &Expected,
    seen: &mut Seen,
) -> Result<(), Failure> {
    let (header, layout, bytes) = (frame.header(), frame.layout(), frame.bytes());
    if (layout.width, layout.height) != (pictures.width, pictures.height) {
        return Err(format!("a frame of {}x{}", layout.width, layout.height).into());
    }
    let (copies, kind) = (header.copies, CaptureKind::from_code(header.capture_kind).name());
    if copies != expected.copies {
        return Err(format!("{copies} copies of a frame, and {} were expected", expected.copies).into());
    }
    if expected.kind != "any" && kind != expected.kind {
        return Err(format!("a stamp of {kind}, and one of {} was expected", expected.kind).into());
    }
    if header.capture_ns > header.dequeue_ns || header.dequeue_ns > header.publish_ns {
        return Err(format!("frame {}: stamps are not in the order of time", header.sequence).into());
    }
    seen.waits_us.push(header.publish_ns.saturating_sub(header.capture_ns) / 1000);
    seen.passes_us.push(header.publish_ns.saturating_sub(header.dequeue_ns) / 1000);
    let at = |x: usize, y: usize| bytes[layout.offset + y * layout.row_stride + x * layout.pixel_step];
    let Some(picture) = number::read(at).map(usize::from).filter(|&number| number < COUNT) else {
        // Before the loop is closed the driver shows a picture of its own.
        return Ok(());
    };
    let luma = pictures.luma(picture);
    let differ = (0..luma.len()).filter(|i| at(i % layout.width, i / layout.width) != luma[*i]).count();
    if differ * 100 > luma.len() * (100 - expected.same) {
        return Err(
            format!("frame {}: {differ} pixels are not those of picture {picture}", header.sequence).into()
        );
    }
    seen.lost_in_driver += u64::from(header.lost_in_driver);
    let format = header.format().to_string();
    if !seen.formats.contains(&format) {
        seen.formats.push(format);
    }
    seen.pictures.insert((header.epoch, header.sequence), picture);
    Ok(())
}

/// Every sure tag must be there, everything that is there must be a tag, and its corners where they are.
fn check_detections(message: &Detections, pictures: &Pictures, seen: &mut Seen) -> Result<(), Failure> {
    let header = message.header();
    let Some(&picture) = seen.pictures.get(&(header.epoch, header.sequence)) else { return Ok(()) };
    let truth = pictures.truth(picture);
    for tag in message.tags() {
        let known = truth.iter().find(|known| known.id == tag.id);
        let known = known.ok_or_else(|| format!("picture {picture}: there is no tag {}", tag.id))?;
        let error_px = corner_error_px(tag, known);
        if error_px > CORNER_TOLERANCE_PX {
            return Err(
                format!("picture {picture}: a corner of tag {} is {error_px:.2} px off", tag.id).into()
            );
        }
        seen.worst_px = seen.worst_px.max(error_px);
        seen.tags += 1;
    }
    let found = |known: &Known| message.tags().iter().any(|tag| tag.id == known.id);
    if let Some(missed) = truth.iter().find(|known| known.sure && !found(known)) {
        return Err(format!("picture {picture}: tag {} was not found", missed.id).into());
    }
    seen.judged += 1;
    Ok(())
}

fn corner_error_px(tag: &TagDetection, known: &Known) -> f64 {
    let pairs = tag.corners.iter().zip(&known.corners);
    let error = |(seen, truth): (&[f64; 2], &[f64; 2])| (seen[0] - truth[0]).hypot(seen[1] - truth[1]);
    pairs.map(error).fold(0.0, f64::max)
}

impl Seen {
    fn summary(&self) -> String {
        format!(
            "{} frames identical to a picture, {} of them with detections as they must be ({} tags, worst corner {:.3} px), {} lost in the \
             driver, {}; p50/p99 from stamp to sending {} us, from dequeue to sending {} us",
            self.pictures.len(),
            self.judged,
            self.tags,
            self.worst_px,
            self.lost_in_driver,
            self.formats.join(" "),
            quantiles(&self.waits_us),
            quantiles(&self.passes_us)
        )
    }
}

/// The middle and the 99th hundredth, as `p50/p99`.
fn quantiles(values: &[u64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    let at =
        |hundredth: usize| sorted.get((sorted.len() * hundredth / 100).min(sorted.len().saturating_sub(1)));
    format!("{}/{}", at(50).unwrap_or(&0), at(99).unwrap_or(&0))
}
