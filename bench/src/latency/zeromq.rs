//! ZeroMQ's publisher and subscriber, where this build has libzmq.

#[cfg(feature = "zeromq")]
pub(super) use with::{Publisher, receive, version};
#[cfg(not(feature = "zeromq"))]
pub(super) use without::{Publisher, receive, version};

#[cfg(feature = "zeromq")]
mod with {
    use std::io;

    use crate::Failure;
    use crate::latency::copied::{BYTES, Label};
    use crate::latency::receiver::{Notes, Outlook};

    /// Frames that wait for a subscriber at most, as many as a subscriber of frames has on the bus.
    const QUEUE: i32 = 2;
    /// A publisher that is silent for so long has died, in milliseconds.
    const PATIENCE_MS: i32 = 30_000;

    pub(in super::super) struct Publisher {
        socket: zmq::Socket,
        _context: zmq::Context,
    }

    impl Publisher {
        pub(in super::super) fn bind(address: &str) -> Result<Self, Failure> {
            let context = zmq::Context::new();
            let socket = context.socket(zmq::PUB)?;
            socket.set_sndhwm(QUEUE)?;
            // What was not sent when it ends is not waited for.
            socket.set_linger(0)?;
            socket.bind(address)?;
            Ok(Self { socket, _context: context })
        }

        pub(in super::super) fn send(&self, frame: &[u8]) -> Result<(), Failure> {
            Ok(self.socket.send(frame, 0)?)
        }
    }

    pub(in super::super) fn receive(
        address: &str,
        tell_ready: impl Fn() -> io::Result<()>,
        notes: &mut Notes,
    ) -> Result<(), Failure> {
        let context = zmq::Context::new();
        let socket = context.socket(zmq::SUB)?;
        socket.set_rcvhwm(QUEUE)?;
        socket.set_rcvtimeo(PATIENCE_MS)?;
        socket.connect(address)?;
        socket.set_subscribe(b"")?;
        tell_ready()?;
        let mut message = zmq::Message::new();
        loop {
            socket.recv(&mut message, 0)?;
            if notes.take(Label::read(&message), &message[BYTES..]) == Outlook::Over {
                return Ok(());
            }
        }
    }

    pub(in super::super) fn version() -> String {
        let (major, minor, patch) = zmq::version();
        format!(
            "libzmq {major}.{minor}.{patch} of the crate zmq, publish-subscribe over ipc, queues of {QUEUE}"
        )
    }
}

#[cfg(not(feature = "zeromq"))]
mod without {
    use std::io;

    use crate::Failure;
    use crate::latency::receiver::Notes;

    const MISSING: &str = "there is no ZeroMQ in this build: add `--features zeromq`";

    pub(in super::super) struct Publisher;

    impl Publisher {
        pub(in super::super) fn bind(_: &str) -> Result<Self, Failure> {
            Err(MISSING.into())
        }

        pub(in super::super) fn send(&self, _: &[u8]) -> Result<(), Failure> {
            Err(MISSING.into())
        }
    }

    pub(in super::super) fn receive(
        _: &str,
        _: impl Fn() -> io::Result<()>,
        _: &mut Notes,
    ) -> Result<(), Failure> {
        Err(MISSING.into())
    }

    pub(in super::super) fn version() -> String {
        MISSING.to_owned()
    }
}
