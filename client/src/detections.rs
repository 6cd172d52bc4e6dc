//! Receiving what a detector found.

use std::time::{Duration, Instant};

use tagbus_message::bus::Bus;
use tagbus_message::detection::{DetectionsHeader, TagDetection};
use tagbus_message::stats::STATS_PERIOD;
use tagbus_message::{clock, qos};

use crate::error::{ConnectError, ReceiveError};
use crate::feed::{Feed, Message, Shared};
use crate::options::ConnectOptions;
use crate::recorder::Recorder;

/// The receiving end of one detector.
///
/// The detector may end and start again: the client goes on with its first message. A client that is slow loses the
/// oldest messages and never delays the detector.
pub struct Client {
    feed: Feed<TagDetection, DetectionsHeader>,
    refused: u64,
    recorder: Recorder,
    delay: Duration,
}

/// What was found in one frame. The tags lie in shared memory: hold at most two at once, and copy what you keep.
#[derive(Debug)]
pub struct Detections {
    header: DetectionsHeader,
    count: usize,
    client_ns: u64,
    message: Message<TagDetection, DetectionsHeader>,
    /// A message may outlive its client: then it is what leaves the bus last.
    _bus: Bus<Shared>,
}

impl Client {
    /// Connects to a detector; waits for it where it does not run yet.
    pub fn connect(options: &ConnectOptions) -> Result<Self, ConnectError> {
        let ConnectOptions { camera, detector, .. } = options;
        let publisher = format!("detector {detector} of camera {camera}");
        let place = (camera.clone(), detector.clone());
        let open = move |bus: &_, patience| Bus::open_detections(bus, &place.0, &place.1, patience);
        let feed = Feed::connect(options, &publisher, qos::DETECTIONS.borrowed, Box::new(open))?;
        let recorder = Recorder::new(feed.bus(), &options.name, camera, detector)
            .map_err(|error| ConnectError::Bus(error.into()))?;
        Ok(Self { feed, refused: 0, recorder, delay: options.delay })
    }

    /// The next message that was not received yet, oldest first; sleeps until there is one.
    ///
    /// `None` when none came in time, or when [`ConnectOptions::stop`] was triggered. A message arrives for every frame
    /// that was searched, also when it shows no tag.
    pub fn receive(&mut self, timeout: Duration) -> Result<Option<Detections>, ReceiveError> {
        let started = Instant::now();
        loop {
            self.recorder.look();
            let left = timeout.saturating_sub(started.elapsed());
            let Some(message) = self.feed.receive(left.min(STATS_PERIOD))? else {
                // Between two copies of what is counted nothing may have come.
                if self.feed.is_stopped() || left <= STATS_PERIOD {
                    return Ok(None);
                }
                continue;
            };
            if let Some(detections) = self.check(message) {
                return Ok(Some(detections));
            }
        }
    }

    /// The newest message that was not received yet, without waiting; older ones are skipped.
    pub fn latest(&mut self) -> Result<Option<Detections>, ReceiveError> {
        self.recorder.look();
        Ok(self.feed.newest()?.and_then(|message| self.check(message)))
    }

    /// Messages that were skipped because their header was of another version or contradicted itself.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Gives back what dead processes held; says how many there were. A silent client does this by itself.
    pub fn clean_up_dead(&self) -> u64 {
        self.feed.bus().clean_up_dead()
    }

    fn check(&mut self, message: Message<TagDetection, DetectionsHeader>) -> Option<Detections> {
        if !self.delay.is_zero() {
            std::thread::sleep(self.delay);
        }
        let client_ns = clock::monotonic_ns();
        // The header is copied out once, so that what was checked is what is used.
        let header = *message.user_header();
        match header.checked(message.payload().len()) {
            Ok(count) => {
                self.recorder.message(&header, client_ns);
                let bus = self.feed.bus().clone();
                Some(Detections { header, count, client_ns, message, _bus: bus })
            }
            Err(_) => {
                self.refused += 1;
                self.recorder.refused();
                None
            }
        }
    }
}

impl Detections {
    /// Frame, stamps, counters and parameters.
    #[must_use]
    pub fn header(&self) -> &DetectionsHeader {
        &self.header
    }

    /// The tags, where the detector wrote them.
    #[must_use]
    pub fn tags(&self) -> &[TagDetection] {
        &self.message.payload()[..self.count]
    }

    /// When this client got the message, `CLOCK_MONOTONIC` nanoseconds.
    #[must_use]
    pub fn client_ns(&self) -> u64 {
        self.client_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_and_its_messages_may_move_to_another_thread() {
        fn moves<T: Send>() {}
        moves::<Client>();
        moves::<Detections>();
    }
}
