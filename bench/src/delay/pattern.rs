//! What tells the time in a frame: a tag whose id, or a number in the frame's corner that counts steps of `CLOCK_MONOTONIC`.

use tagbus_family::Family;

use super::interval::Span;
use crate::Failure;

/// The family that is shown: 587 tags, known to every detector.
const FAMILY: &str = "tag36h11";

/// How many numbers there are ([`tagbus_scene::number`]).
const NUMBERS: u64 = 256;

/// Which tag or number is shown when. Who shows it and who sees it need to agree on nothing but the step.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    family: Family,
    /// After so many steps all begins anew.
    count: u64,
    is_number: bool,
    step_ns: u64,
}

impl Pattern {
    /// A new tag each so many milliseconds.
    pub(crate) fn new(step_ms: u32) -> Result<Self, Failure> {
        let family = Family::published(FAMILY)?;
        let count = family.codes().len() as u64;
        Ok(Self { family, count, is_number: false, step_ns: u64::from(step_ms.max(1)) * 1_000_000 })
    }

    /// A new number each so many milliseconds.
    pub(crate) fn of_numbers(step_ms: u32) -> Result<Self, Failure> {
        Ok(Self { count: NUMBERS, is_number: true, ..Self::new(step_ms)? })
    }

    /// Whether it is a number of the frame, and no tag.
    pub(crate) fn is_number(&self) -> bool {
        self.is_number
    }

    pub(super) fn family(&self) -> &Family {
        &self.family
    }

    pub(super) fn step_ns(&self) -> u64 {
        self.step_ns
    }

    /// After so long all begins anew: what is older is taken for younger.
    pub(super) fn range_ns(&self) -> u64 {
        self.step_ns * self.count
    }

    /// The tag or number that is shown at a moment.
    pub(super) fn id_at(&self, now_ns: u64) -> u32 {
        (now_ns / self.step_ns % self.count) as u32
    }

    /// When the next tag is shown.
    pub(super) fn next_ns(&self, now_ns: u64) -> u64 {
        (now_ns / self.step_ns + 1) * self.step_ns
    }

    /// When this tag or number was last shown before it was seen; `None` when there is none such.
    pub(super) fn shown(&self, id: u32, seen_ns: u64) -> Option<Span> {
        let (now, count, id) = (seen_ns / self.step_ns, self.count, u64::from(id));
        let ago = (now % count + count - id % count) % count;
        let step = now.checked_sub(ago).filter(|_| id < count)?;
        Some(Span { first: step * self.step_ns, last: (step + 1) * self.step_ns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_tells_when_it_was_shown_however_late_it_is_seen() {
        let pattern = Pattern::new(20).unwrap();
        assert_eq!(pattern.range_ns(), 587 * 20_000_000);
        for shown_ns in [0, 1, 20_000_000, 587 * 20_000_000 - 1, 587 * 20_000_000, 123_456_789_012_345] {
            let id = pattern.id_at(shown_ns);
            for late in [0, 5_000_000, 30_000_000, pattern.range_ns() - 20_000_000] {
                let span = pattern.shown(id, shown_ns + late).unwrap();
                assert!((span.first..span.last).contains(&shown_ns), "{shown_ns} {late} {span:?}");
            }
            assert_eq!(pattern.id_at(pattern.next_ns(shown_ns)), (id + 1) % 587);
        }
        let numbers = Pattern::of_numbers(20).unwrap();
        assert_eq!((numbers.id_at(255 * 20_000_000), numbers.id_at(256 * 20_000_000)), (255, 0));
        assert_eq!((numbers.range_ns(), numbers.shown(256, 1 << 40)), (5_120_000_000, None));
        assert_eq!(pattern.shown(587, 1 << 40), None);
        assert_eq!(pattern.shown(5, 1), None, "it was never shown");
    }
}
