//! What a capture stamp means: which clock, which moment.

/// Which clock a capture stamp was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ClockKind {
    /// Not known: do not compare.
    Unknown = 0,
    /// `CLOCK_MONOTONIC`, as every other stamp.
    Monotonic = 1,
    /// The wall clock, `CLOCK_REALTIME`.
    Realtime = 2,
}

impl ClockKind {
    /// The clock of a code; codes of a newer version are [`ClockKind::Unknown`].
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            1 => Self::Monotonic,
            2 => Self::Realtime,
            _ => Self::Unknown,
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }
}

/// The moment that a capture stamp marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum CaptureKind {
    /// Not known.
    Unknown = 0,
    /// The first line began to be exposed.
    StartOfExposure = 1,
    /// The last byte of the frame arrived.
    EndOfFrame = 2,
    /// No better moment is known than when the process got the frame.
    Dequeue = 3,
}

impl CaptureKind {
    /// The kind of a code; codes of a newer version are [`CaptureKind::Unknown`].
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            1 => Self::StartOfExposure,
            2 => Self::EndOfFrame,
            3 => Self::Dequeue,
            _ => Self::Unknown,
        }
    }

    /// The number in messages.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::StartOfExposure => "start_of_exposure",
            Self::EndOfFrame => "end_of_frame",
            Self::Dequeue => "dequeue",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_kinds_come_back() {
        for kind in [
            CaptureKind::Unknown,
            CaptureKind::StartOfExposure,
            CaptureKind::EndOfFrame,
            CaptureKind::Dequeue,
        ] {
            assert_eq!(CaptureKind::from_code(kind.code()), kind);
        }
        for clock in [ClockKind::Unknown, ClockKind::Monotonic, ClockKind::Realtime] {
            assert_eq!(ClockKind::from_code(clock.code()), clock);
        }
    }
}
