//! The ways from one process to others that are compared.

/// How frames get from a sender to its receivers, each a process of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub(crate) enum Way {
    /// The frames topic, and what camera and detector wait with.
    Bus,
    /// The frames topic, waited for with iceoryx2's wait set.
    WaitSet,
    /// The frames topic, looked at again and again.
    Polling,
    /// A Unix stream socket to each receiver.
    Unix,
    /// A pipe to each receiver.
    Pipe,
    /// ZeroMQ's publisher and subscribers over Unix sockets.
    Zeromq,
}

impl Way {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bus => "tagbus",
            Self::WaitSet => "tagbus, waiting with iceoryx2's wait set",
            Self::Polling => "tagbus, polling",
            Self::Unix => "Unix stream socket",
            Self::Pipe => "pipe",
            Self::Zeromq => "ZeroMQ (libzmq)",
        }
    }

    /// Whether a receiver reads its frames from its standard input.
    pub(super) fn is_piped(self) -> bool {
        matches!(self, Self::Unix | Self::Pipe)
    }

    /// Those that this build has.
    pub(super) fn all() -> Vec<Self> {
        let mut ways = vec![Self::Bus, Self::WaitSet, Self::Polling, Self::Unix, Self::Pipe];
        if cfg!(feature = "zeromq") {
            ways.push(Self::Zeromq);
        }
        ways
    }

    /// Polling processes take whole processors, so that only a few can be measured.
    pub(super) fn is_worth_measuring(self, receivers: usize) -> bool {
        self != Self::Polling || receivers <= 4
    }
}
