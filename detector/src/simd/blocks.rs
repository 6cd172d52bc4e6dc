//! A row cut into whole blocks: the last one reaches back over the one before it, rather than leave a rest that is done pixel by
//! pixel.

/// Where blocks of `SIZE` pixels begin.
pub(super) struct Blocks<const SIZE: usize> {
    next: usize,
    /// Pixels that the blocks cover: all whole units of a row that holds a block.
    pub(super) end: usize,
}

impl<const SIZE: usize> Blocks<SIZE> {
    /// Blocks begin at multiples of `unit` pixels, which divides `SIZE`.
    #[inline(always)]
    pub(super) fn of(pixels: usize, unit: usize) -> Self {
        Self { next: 0, end: if pixels >= SIZE { pixels - pixels % unit } else { 0 } }
    }

    /// The first pixel of the next block.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<usize> {
        if self.next >= self.end {
            return None;
        }
        let at = self.next.min(self.end - SIZE);
        self.next = at + SIZE;
        Some(at)
    }
}

/// The word that takes the bits of 64 pixels from pixel `at`, and how many of them are in the word before it.
#[inline(always)]
pub(super) fn word_of(at: usize) -> (usize, usize) {
    let word = at.div_ceil(64);
    (word, word * 64 - at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starts(pixels: usize, unit: usize) -> (Vec<usize>, usize) {
        let mut blocks = Blocks::<64>::of(pixels, unit);
        let starts = std::iter::from_fn(|| blocks.next()).collect();
        (starts, blocks.end)
    }

    #[test]
    fn the_last_block_reaches_back_to_a_whole_unit() {
        assert_eq!(starts(128, 4), (vec![0, 64], 128));
        assert_eq!(starts(140, 4), (vec![0, 64, 76], 140));
        assert_eq!(starts(141, 4), (vec![0, 64, 76], 140));
        assert_eq!(starts(141, 1), (vec![0, 64, 77], 141));
        assert_eq!(starts(60, 1), (vec![], 0));
        assert_eq!(word_of(64), (1, 0));
        assert_eq!(word_of(76), (2, 52));
    }
}
