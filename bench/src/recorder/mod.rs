//! What the flight recorder costs a frame: the same counts and readings of the clock as camera, detector and client make.

use std::array;
use std::hint::black_box;
use std::time::Instant;

use tagbus_message::clock::monotonic_ns;
use tagbus_message::histogram::Histogram;
use tagbus_message::stats::{CAMERA_HOPS, CLIENT_HOPS, DETECTOR_HOPS};
use tagbus_message::tally::{Tally, between};

use crate::clock::now_us;
use crate::median::median;

/// Readings of the clock that only the recorder wants: the end of each phase (the quick search: binarize, twice cluster and fit, identify)
/// and after clients were woken.
const CLOCK_READINGS: usize = 7;
/// Each role asks once a frame whether it is time to publish.
const LOOKS: usize = 3;
/// More than the caches of a core hold: what a frame's pixels do to them between two counts.
const CACHES_BYTES: usize = 16 << 20;
/// Frames of a round with emptied caches: durations are counted every 32 frames, which is part of the cost.
const COLD_FRAMES: u64 = 64;

/// What was measured, nanoseconds a frame.
pub(crate) struct Outcome {
    /// CPU time when everything lies in the caches: the quickest round and the middle one.
    pub(crate) warm: [f64; 2],
    /// Time when nothing does: the quickest round and the middle one.
    pub(crate) cold: [f64; 2],
}

/// The histograms of all three roles, and the durations that are not counted yet.
#[derive(Default)]
struct Hops {
    camera: (Tally<{ CAMERA_HOPS.len() }>, Box<[Histogram; CAMERA_HOPS.len()]>),
    detector: (Tally<{ DETECTOR_HOPS.len() }>, Box<[Histogram; DETECTOR_HOPS.len()]>),
    client: (Tally<{ CLIENT_HOPS.len() }>, Box<[Histogram; CLIENT_HOPS.len()]>),
}

impl Hops {
    /// What all roles together do for one frame, with durations that differ.
    fn frame(&mut self, number: u64) {
        for _ in 0..CLOCK_READINGS {
            black_box(monotonic_ns());
        }
        for _ in 0..LOOKS {
            black_box(Instant::now());
        }
        keep(&mut self.camera, number);
        keep(&mut self.detector, number);
        keep(&mut self.client, number);
    }
}

fn keep<const HOPS: usize>(hops: &mut (Tally<HOPS>, Box<[Histogram; HOPS]>), number: u64) {
    let duration_ns = |place: usize| 1_000 + (number.wrapping_mul(0x9e37_79b9) % 50_000) * (place as u64 + 1);
    let durations =
        array::from_fn(|place| between(black_box(number), black_box(number + duration_ns(place))));
    hops.0.frame(durations, &mut hops.1);
}

/// Measures `rounds` rounds of `frames` frames, and as many of [`COLD_FRAMES`] frames with empty caches.
pub(crate) fn run(rounds: usize, frames: u64) -> Outcome {
    let mut hops = Hops::default();
    let warm = |hops: &mut Hops| {
        let before = now_us();
        (0..frames).for_each(|number| hops.frame(number));
        (now_us() - before) * 1e3 / frames as f64
    };
    // The first round is a warm-up.
    let warm: Vec<f64> = (0..=rounds).map(|_| warm(&mut hops)).skip(1).collect();
    let mut pixels = vec![1u8; CACHES_BYTES];
    let cold: Vec<f64> =
        (0..rounds as u64).map(|round| cold_round(&mut hops, &mut pixels, round * COLD_FRAMES)).collect();
    let of = |all: Vec<f64>| [all.iter().copied().fold(f64::INFINITY, f64::min), median(all)];
    Outcome { warm: of(warm), cold: of(cold) }
}

/// Nanoseconds a frame, without emptying the caches.
fn cold_round(hops: &mut Hops, pixels: &mut [u8], first: u64) -> f64 {
    let spent = (first..first + COLD_FRAMES).map(|number| cold_frame(hops, pixels, number));
    spent.sum::<f64>() / COLD_FRAMES as f64
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
        let mut hops = Hops::default();
        (0..COLD_FRAMES).for_each(|number| hops.frame(number));
        let counts = |hops: &[Histogram]| hops.iter().all(|hop| hop.count == COLD_FRAMES && hop.is_sound());
        assert!(counts(&hops.camera.1[..]) && counts(&hops.detector.1[..]) && counts(&hops.client.1[..]));
        assert!(page(&run(3, 10)).contains("| warm |"));
    }
}
