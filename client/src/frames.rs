//! Receiving pictures, for viewers and recorders.

use std::time::{Duration, Instant};

use tagbus_message::bus::Bus;
use tagbus_message::frame::{FrameHeader, FrameLayout, HeaderError};
use tagbus_message::{clock, qos};

use crate::error::{ConnectError, ReceiveError};
use crate::feed::{Feed, Message, Shared};
use crate::options::ConnectOptions;

/// The receiving end of one camera. Only [`ConnectOptions::camera`] counts, not its detector.
pub struct FrameClient {
    feed: Feed<u8, FrameHeader>,
    refused: u64,
    last_refusal: Option<HeaderError>,
}

/// One picture as captured, in shared memory: hold at most two at once.
#[derive(Debug)]
pub struct Frame {
    header: FrameHeader,
    layout: FrameLayout,
    client_ns: u64,
    message: Message<u8, FrameHeader>,
    /// A frame may outlive its client: then it is what leaves the bus last.
    _bus: Bus<Shared>,
}

impl FrameClient {
    /// Connects to a camera; waits for it where it does not run yet.
    pub fn connect(options: &ConnectOptions) -> Result<Self, ConnectError> {
        let camera = options.camera.clone();
        let publisher = format!("camera {camera}");
        let open = move |bus: &_, patience| Bus::open_frames(bus, &camera, qos::FRAMES.buffer, patience);
        let feed = Feed::connect(options, &publisher, qos::FRAMES.borrowed, Box::new(open))?;
        Ok(Self { feed, refused: 0, last_refusal: None })
    }

    /// The next frame that was not received yet, oldest first; sleeps until there is one.
    ///
    /// `None` when none came in time, or when [`ConnectOptions::stop`] was triggered.
    pub fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, ReceiveError> {
        let started = Instant::now();
        loop {
            let left = timeout.saturating_sub(started.elapsed());
            let Some(message) = self.feed.receive(left)? else { return Ok(None) };
            if let Some(frame) = self.check(message) {
                return Ok(Some(frame));
            }
        }
    }

    /// The newest frame that was not received yet, without waiting; older ones are skipped.
    pub fn latest(&mut self) -> Result<Option<Frame>, ReceiveError> {
        Ok(self.feed.newest()?.and_then(|message| self.check(message)))
    }

    /// Frames that were skipped because their header did not fit their bytes, and what the last of them said.
    #[must_use]
    pub fn refused(&self) -> (u64, Option<HeaderError>) {
        (self.refused, self.last_refusal)
    }

    fn check(&mut self, message: Message<u8, FrameHeader>) -> Option<Frame> {
        let client_ns = clock::monotonic_ns();
        let header = *message.user_header();
        match header.validate(message.payload().len()) {
            Ok(layout) => {
                let bus = self.feed.bus().clone();
                Some(Frame { header, layout, client_ns, message, _bus: bus })
            }
            Err(error) => {
                self.refused += 1;
                self.last_refusal = Some(error);
                None
            }
        }
    }
}

impl Frame {
    /// What the camera says about the picture; checked.
    #[must_use]
    pub fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// Where the luma lies in [`Frame::bytes`].
    #[must_use]
    pub fn layout(&self) -> &FrameLayout {
        &self.layout
    }

    /// The whole payload, where the camera wrote it.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.message.payload()
    }

    /// When this client got the frame, `CLOCK_MONOTONIC` nanoseconds.
    #[must_use]
    pub fn client_ns(&self) -> u64 {
        self.client_ns
    }
}
