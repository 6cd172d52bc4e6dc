//! A few lines on a terminal that are written over again and again.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use tagbus_client::{Detections, TagDetection};

use super::hops::{Hops, NAMES};
use super::late::Late;
use super::line::in_order;
use crate::output::Reader;
use crate::units::time;

/// Nobody reads faster than this.
const REFRESH: Duration = Duration::from_millis(100);
/// Tags that are listed; the others are counted.
const MOST_ROWS: usize = 16;

/// What is on the terminal.
pub(super) struct Screen {
    title: String,
    rows: usize,
    shown: Option<Instant>,
    frames: u64,
    dropped: u64,
    frames_since: u64,
    late: u64,
    last_late: Option<(u64, Late)>,
}

impl Screen {
    /// An empty screen.
    pub(super) fn new(title: String) -> Self {
        Self { title, rows: 0, shown: None, frames: 0, dropped: 0, frames_since: 0, late: 0, last_late: None }
    }

    /// Counts the message, and shows it when the last one was shown long enough.
    pub(super) fn show(
        &mut self,
        detections: &Detections,
        late: Option<Late>,
        out: &mut impl Write,
    ) -> io::Result<()> {
        if let Some(late) = late {
            self.late += 1;
            self.last_late = Some((detections.header().sequence, late));
        }
        self.frames += 1;
        self.frames_since += 1;
        self.dropped += u64::from(detections.header().skipped);
        let now = Instant::now();
        let since = self.shown.map(|shown| now - shown);
        if since.is_some_and(|since| since < REFRESH) {
            return Ok(());
        }
        let rate = since.map_or(0.0, |since| self.frames_since as f64 / since.as_secs_f64());
        let rows = self.compose(detections, rate);
        // Back to the first row of the last time, and everything below it away.
        let back = if self.rows > 0 { format!("\x1b[{}A\r\x1b[J", self.rows) } else { String::new() };
        writeln!(out, "{back}{}", rows.join("\n"))?;
        out.flush()?;
        (self.rows, self.shown, self.frames_since) = (rows.len(), Some(now), 0);
        Ok(())
    }

    fn compose(&self, detections: &Detections, rate: f64) -> Vec<String> {
        let header = detections.header();
        let hops = Hops::of(detections);
        let head = format!(
            "{}  frame {}  {}x{}  {rate:.1} frames/s  {} dropped",
            Reader::Person.bold(&self.title),
            header.sequence,
            header.width,
            header.height,
            self.dropped
        );
        let names: String = NAMES.iter().map(|name| format!("{name:>10}")).collect();
        let times: String = hops.us.iter().map(|&us| format!("{:>10}", time(us))).collect();
        let mut rows = vec![head, Reader::Person.faint(&format!("{names}{:>10}", "= total"))];
        rows.push(format!("{times}{:>10}", time(hops.total_us)));
        if let Some((frame, late)) = self.last_late {
            rows.push(format!("{} late, the last one frame {frame}: {late}", self.late));
        }
        rows.extend(in_order(detections.tags()).into_iter().take(MOST_ROWS).map(tag_row));
        if detections.tags().len() > MOST_ROWS {
            rows.push(format!("  and {} more", detections.tags().len() - MOST_ROWS));
        }
        rows
    }
}

fn tag_row(tag: &TagDetection) -> String {
    let [x, y] = tag.center;
    format!("  {:<17} {:>5}   {x:7.1} {y:7.1}   margin {:5.1}", tag.family(), tag.id, tag.margin)
}
