//! The way of a frame in time.

use tagbus_client::{ClockKind, Detections};

/// The hops in order, from the capture of a frame to the client that hears of it.
pub(super) const NAMES: [&str; 6] = ["publish", "receive", "start", "detect", "send", "client"];

/// How long each hop took, microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hops {
    /// In the order of [`NAMES`].
    pub(super) us: [f64; 6],
    /// From capture to client.
    pub(super) total_us: f64,
}

impl Hops {
    /// The hops of a message. The first begins when the camera process got the frame if the capture has no stamp of the
    /// clock of all others.
    pub(super) fn of(detections: &Detections) -> Self {
        let header = detections.header();
        let comparable = header.capture_clock == ClockKind::Monotonic.code() && header.capture_ns > 0;
        Self::between([
            if comparable { header.capture_ns } else { header.dequeue_ns },
            header.publish_ns,
            header.receive_ns,
            header.detect_start_ns,
            header.detect_end_ns,
            header.send_ns,
            detections.client_ns(),
        ])
    }

    fn between(stamps_ns: [u64; 7]) -> Self {
        // A capture stamp may lie ahead of the others: drivers have been seen to do that.
        let us = |from: u64, to: u64| to.wrapping_sub(from).cast_signed() as f64 / 1e3;
        Self {
            us: std::array::from_fn(|hop| us(stamps_ns[hop], stamps_ns[hop + 1])),
            total_us: us(stamps_ns[0], stamps_ns[6]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hops_add_up_to_the_whole_way_even_when_a_stamp_lies_ahead() {
        let hops = Hops::between([5_000, 1_000, 4_000, 4_500, 900_000, 901_000, 950_000]);
        assert_eq!(hops.us[0], -4.0);
        assert!((hops.us.iter().sum::<f64>() - hops.total_us).abs() < 1e-9);
        assert_eq!(hops.total_us, 945.0);
    }
}
