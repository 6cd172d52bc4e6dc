//! A light that is switched at known times, and the frames in which it is seen.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use tagbus_client::{ConnectOptions, Frame, FrameClient, Stop};
use tagbus_message::clock::monotonic_ns;
use tagbus_message::frame::ClockKind;

use super::interval::{Delay, Delays, Span};
use crate::Failure;

/// Every so many pixels of every so many rows are looked at.
const STRIDE: usize = 8;
/// Grey levels that the light must change the mean of a frame by.
const LEAST_CONTRAST: f64 = 2.0;
/// The light stays as it is for this long, and up to as much again, so that steps meet frames at every phase.
const SHORTEST: Duration = Duration::from_millis(300);

/// How a light is switched.
#[derive(Clone, Debug)]
pub(crate) enum Switch {
    /// A file into which 1 and 0 are written, such as `/sys/class/leds/ACT/brightness`.
    File(PathBuf),
    /// A command that gets 1 or 0 as its last argument.
    Command(String),
}

impl Switch {
    /// Says between which moments the light changed.
    fn set(&self, is_on: bool) -> Result<Span, Failure> {
        let (first, value) = (monotonic_ns(), if is_on { "1" } else { "0" });
        match self {
            Self::File(path) => {
                fs::write(path, value).map_err(|error| format!("{}: {error}", path.display()))?;
            }
            Self::Command(command) => {
                let status = Command::new("sh").args(["-c", &format!("{command} {value}")]).status()?;
                if !status.success() {
                    return Err(format!("'{command} {value}' ended with {status}").into());
                }
            }
        }
        Ok(Span { first, last: monotonic_ns() })
    }
}

/// One change of the light.
#[derive(Clone, Copy, Debug)]
struct Step {
    is_on: bool,
    span: Span,
}

/// How bright a frame was.
#[derive(Clone, Copy, Debug)]
struct Look {
    mean: f64,
    /// `None` of another clock.
    stamp_ns: Option<u64>,
    dequeue_ns: u64,
    client_ns: u64,
}

/// What was seen of the light.
#[derive(Clone, Debug, Default)]
pub(crate) struct Light {
    pub(super) steps: usize,
    /// Grey levels from off to on.
    pub(super) contrast: f64,
    /// From the light to the stamp, the dequeue and the client of a frame.
    pub(super) delays: [Delays; 3],
}

/// Switches the light again and again for so long while frames are looked at.
pub(crate) fn light(options: &ConnectOptions, switch: &Switch, duration: Duration) -> Result<Light, Failure> {
    let stop = Stop::new()?;
    let mut client = FrameClient::connect(&options.clone().stop(stop.clone()))?;
    let (steps, looks) = thread::scope(|scope| {
        let switching = scope.spawn(|| {
            let steps = switch_for(switch, duration).map_err(|error| error.to_string());
            stop.trigger();
            steps
        });
        let mut looks = Vec::new();
        while let Some(frame) = client.receive(Duration::from_secs(10))? {
            looks.push(look(&frame));
        }
        let steps = switching.join().map_err(|_| "switching the light panicked")??;
        Ok::<_, Failure>((steps, looks))
    })?;
    judge(&steps, &looks)
}

fn switch_for(switch: &Switch, duration: Duration) -> Result<Vec<Step>, Failure> {
    let (begun, mut steps, mut is_on) = (Instant::now(), Vec::new(), false);
    while begun.elapsed() < duration {
        steps.push(Step { is_on, span: switch.set(is_on)? });
        // The golden ratio meets every phase.
        let part = (steps.len() as f64 * 0.618_034).fract();
        thread::sleep(SHORTEST + SHORTEST.mul_f64(part));
        is_on = !is_on;
    }
    switch.set(false)?;
    Ok(steps)
}

fn look(frame: &Frame) -> Look {
    let (layout, header, bytes) = (frame.layout(), frame.header(), frame.bytes());
    let (mut sum, mut count) = (0, 0_u32);
    for y in (0..layout.height).step_by(STRIDE) {
        for x in (0..layout.width).step_by(STRIDE) {
            let place = layout.offset + y * layout.row_stride + x * layout.pixel_step;
            sum += u64::from(bytes.get(place).copied().unwrap_or(0));
            count += 1;
        }
    }
    let has_stamp = header.capture_clock == ClockKind::Monotonic as u32;
    Look {
        mean: sum as f64 / f64::from(count.max(1)),
        stamp_ns: has_stamp.then_some(header.capture_ns),
        dequeue_ns: header.dequeue_ns,
        client_ns: frame.client_ns(),
    }
}

/// Each step lies between the last frame without it and the first with it.
fn judge(steps: &[Step], looks: &[Look]) -> Result<Light, Failure> {
    let mut means: Vec<f64> = looks.iter().map(|look| look.mean).collect();
    means.sort_by(f64::total_cmp);
    let at = |part: usize| means.get(means.len() * part / 10).copied().unwrap_or(0.0);
    let (dark, bright) = (at(1), at(9));
    if bright - dark < LEAST_CONTRAST {
        return Err(format!(
            "in {} frames the light changed the mean by {:.1} grey levels: {LEAST_CONTRAST} are needed, so fill more of the picture with it",
            looks.len(),
            bright - dark
        )
        .into());
    }
    let middle = (dark + bright) / 2.0;
    let mut light = Light { contrast: bright - dark, ..Light::default() };
    for pair in looks.windows(2) {
        let [before, after] = [pair[0], pair[1]];
        let is_on = after.mean > middle;
        let is_step = is_on != (before.mean > middle);
        let cause = steps.iter().rev().find(|step| step.is_on == is_on && step.span.first < after.client_ns);
        if let (true, Some(step)) = (is_step, cause) {
            light.note(step.span, &before, &after);
        }
    }
    if light.steps == 0 { Err("no frame shows the light change".into()) } else { Ok(light) }
}

impl Light {
    /// With a delay d, a frame shows how it was d before its stamp: the one before not yet, the one after already.
    fn note(&mut self, step: Span, before: &Look, after: &Look) {
        self.steps += 1;
        let stamps: [fn(&Look) -> Option<u64>; 2] = [|look| look.stamp_ns, |look| Some(look.dequeue_ns)];
        for (delays, stamp) in self.delays.iter_mut().zip(stamps) {
            if let (Some(before_ns), Some(after_ns)) = (stamp(before), stamp(after)) {
                delays.add(Delay {
                    least: before_ns as i64 - step.last as i64,
                    most: after_ns as i64 - step.first as i64,
                });
            }
        }
        // What a robot waits for after something has happened, the rest of a frame's time included.
        self.delays[2].add(Delay::between(step, after.client_ns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames each 33 ms that show a light as it was 12 ms before their stamp.
    #[test]
    fn a_known_delay_is_found_from_steps_at_every_phase() {
        let steps: Vec<Step> = (0..60)
            .map(|number: u64| {
                let first = 1_000_000_000 + number * 431_300_000;
                Step { is_on: number % 2 == 1, span: Span { first, last: first + 100_000 } }
            })
            .collect();
        let is_on = |at_ns: u64| {
            steps.iter().rev().find(|step| step.span.first <= at_ns).is_some_and(|step| step.is_on)
        };
        let looks: Vec<Look> = (0..800)
            .map(|number: u64| {
                let stamp_ns = 1_000_000_000 + number * 33_100_000;
                let mean = if is_on(stamp_ns - 12_000_000) { 90.0 } else { 40.0 };
                let (dequeue_ns, client_ns) = (stamp_ns + 1_000_000, stamp_ns + 5_000_000);
                Look { mean, stamp_ns: Some(stamp_ns), dequeue_ns, client_ns }
            })
            .collect();
        let light = judge(&steps, &looks).unwrap();
        assert!(light.steps > 50 && light.contrast == 50.0);
        for (delays, known_ms) in light.delays.iter().zip([12.0, 13.0]) {
            let [least, most] = delays.common_ms().unwrap();
            assert!(least <= known_ms && known_ms <= most && most - least < 3.0, "{least} {most}");
        }
        assert!(light.delays[2].quantile_ms(0.5) > 17.0);
    }

    #[test]
    fn a_light_that_is_not_seen_is_an_error() {
        let look = Look { mean: 40.0, stamp_ns: None, dequeue_ns: 1, client_ns: 2 };
        let error = judge(&[], &[look; 30]).unwrap_err().to_string();
        assert!(error.contains("0.0 grey levels"), "{error}");
    }
}
