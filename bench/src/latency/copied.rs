//! A frame as it is copied through sockets and pipes: three numbers, then the picture.

/// What comes before the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Label {
    /// Number of the frame, or [`END`].
    pub(super) sequence: u64,
    /// When writing the frame began, `CLOCK_MONOTONIC` nanoseconds.
    pub(super) written_ns: u64,
    /// When sending it began.
    pub(super) sent_ns: u64,
}

/// Bytes of a label.
pub(super) const BYTES: usize = 24;
/// The number of a frame after which none comes.
pub(super) const END: u64 = u64::MAX;
/// Frames at the start of each line of a round that count for nothing: pages are touched, caches and queues filled.
pub(super) const WARM_UP: u64 = 20;

impl Label {
    pub(super) fn write(self, bytes: &mut [u8]) {
        let numbers = [self.sequence, self.written_ns, self.sent_ns];
        for (place, number) in bytes.chunks_exact_mut(8).zip(numbers) {
            place.copy_from_slice(&number.to_ne_bytes());
        }
    }

    /// Of a frame that is at least [`BYTES`] long.
    pub(super) fn read(bytes: &[u8]) -> Self {
        let number = |place: usize| {
            let mut number = [0; 8];
            number.copy_from_slice(&bytes[8 * place..8 * place + 8]);
            u64::from_ne_bytes(number)
        };
        Self { sequence: number(0), written_ns: number(1), sent_ns: number(2) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_is_read_back() {
        let label = Label { sequence: 7, written_ns: u64::MAX - 1, sent_ns: 3 };
        let mut bytes = [9; BYTES + 5];
        label.write(&mut bytes);
        assert_eq!(Label::read(&bytes), label);
        assert_eq!(bytes[BYTES - 1..], [0, 9, 9, 9, 9, 9]);
    }
}
