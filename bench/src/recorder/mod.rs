//! What the flight recorder costs a frame: the same counts and readings of the clock as camera, detector and client make.

use std::hint::black_box;
use std::time::Instant;

use tagbus_message::clock::monotonic_ns;
use tagbus_message::histogram::Histogram;
use tagbus_message::stats::{CAMERA_HOPS, CLIENT_HOPS, DETECTOR_HOPS};

use crate::clock::now_us;
use crate::median::median;

/// Readings of the clock that only the recorder wants: the end of each phase (the quick search: binarize, twice cluster and fit, identify)
/// and after clients were woken.
const CLOCK_READINGS: usize = 7;
/// Each role asks once a frame whether it is time to publish.
const LOOKS: usize = 3;
/// More than the caches of a core hold: what a frame's pixels do to them between two counts.
const CACHES_BYTES: usize = 16 << 20;

/// What was measured, nanoseconds a frame.
pub(crate) struct Outcome {
    /// CPU time when everything lies in the caches: the quickest round and the middle one.
    pub(crate) warm: [f64; 2],
    /// Time when nothing does: the quickest frame and the middle one.
    pub(crate) cold: [f64; 2],
}

/// The histograms of all three roles, one after the other.
struct Hops(Vec<Histogram>);

impl Hops {
    fn new() -> Self {
        Self(vec![Histogram::default(); CAMERA_HOPS.len() + DETECTOR_HOPS.len() + CLIENT_HOPS.len()])
    }

    /// What all roles together do for one frame, with durations that differ.
    fn frame(&mut self, number: u64) {
        for _ in 0..CLOCK_READINGS {
            black_box(monotonic_ns());
        }
        for _ in 0..LOOKS {
            black_box(Instant::now());
        }
        for (place, hop) in self.0.iter_mut().enumerate() {
            let duration_ns = 1_000 + (number.wrapping_mul(0x9e37_79b9) % 50_000) * (place as u64 + 1);
            hop.record(black_box(number), black_box(number + duration_ns));
        }
    }
}

/// Measures `rounds` rounds of `frames` frames, and as many single frames as there are rounds with empty caches.
pub(crate) fn run(rounds: usize, frames: u64) -> Outcome {
    let mut hops = Hops::new();
    let warm = |hops: &mut Hops| {
        let before = now_us();
        (0..frames).for_each(|number| hops.frame(number));
        (now_us() - before) * 1e3 / frames as f64
    };
    // The first round is a warm-up.
    let warm: Vec<f64> = (0..=rounds).map(|_| warm(&mut hops)).skip(1).collect();
    let mut pixels = vec![1u8; CACHES_BYTES];
    let cold: Vec<f64> =
        (0..rounds as u64).map(|number| cold_frame(&mut hops, &mut pixels, number)).collect();
    let of = |all: Vec<f64>| [all.iter().copied().fold(f64::INFINITY, f64::min), median(all)];
    Outcome { warm: of(warm), cold: of(cold) }
}

fn cold_frame(hops: &mut Hops, pixels: &mut [u8], number: u64) -> f64 {
    pixels.iter_mut().step_by(64).for_each(|pixel| *pixel = pixel.wrapping_add(1));
    black_box(&pixels);
    let before = Instant::now();
    hops.frame(number);
    before.elapsed().as_nanos() as f64
}

/// The figures as text.
pub(crate) fn page(outcome: &Outcome) -> String {
    let Outcome { warm, cold } = outcome;
    format!(
        "Camera, detector and client together, nanoseconds a frame ({} hops counted, {CLOCK_READINGS} readings of the clock and {LOOKS} \
         looks whether to publish; asked: below 1000):\n\n\
         | caches | least | median |\n|---|--:|--:|\n| warm | {:.0} | {:.0} |\n| emptied before each frame | {:.0} | {:.0} |\n",
        CAMERA_HOPS.len() + DETECTOR_HOPS.len() + CLIENT_HOPS.len(),
        warm[0],
        warm[1],
        cold[0],
        cold[1]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_hop_counts_every_frame() {
        let mut hops = Hops::new();
        (0..10).for_each(|number| hops.frame(number));
        assert!(hops.0.iter().all(|hop| hop.count == 10 && hop.is_sound()));
        assert!(page(&run(3, 10)).contains("| warm |"));
    }
}
