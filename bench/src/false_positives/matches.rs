//! How many bits have to be corrected until a quad is a tag.

/// Corrected bits that are told apart: from 0 to one less.
pub(super) const LEVELS: usize = 6;

/// The most bits that can be corrected without doubt: with more, two codes can be equally near. None beyond what is counted.
pub(super) fn most_bits(distance: u32) -> usize {
    (distance.saturating_sub(1) / 2).min(LEVELS as u32 - 1) as usize
}

/// For each number of bits the quads whose nearest code differs in exactly so many; the codes are given in all turns.
pub(super) fn histogram(quads: &[u64], turned_codes: &[u64]) -> [u32; LEVELS] {
    let mut counts = [0; LEVELS];
    for quad in quads {
        let nearest = turned_codes.iter().map(|code| (code ^ quad).count_ones()).min();
        if let Some(count) = nearest.and_then(|bits| counts.get_mut(bits as usize)) {
            *count += 1;
        }
    }
    counts
}

/// Of so many quads with random bits those that differ in exactly `bits` from one of the codes, for so few bits that no word is
/// that near to two codes: quads * codes * C(n, bits) / 2^n.
pub(super) fn expected(quads: usize, codes: usize, bit_count: u32, bits: usize) -> f64 {
    let ways: f64 = (0..bits).map(|k| (f64::from(bit_count) - k as f64) / (k as f64 + 1.0)).product();
    quads as f64 * codes as f64 * ways / f64::from(bit_count).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_code_counts_and_only_that() {
        let counts = histogram(&[0b1111, 0b0111, 0b0000, u64::MAX], &[0b1111, 0b0011]);
        assert_eq!(counts[..4], [1, 1, 1, 0]);
        assert_eq!(counts.iter().sum::<u32>(), 3);
    }

    #[test]
    fn as_many_bits_are_corrected_as_leave_no_doubt() {
        assert_eq!([7, 11, 12].map(most_bits), [3, 5, 5]);
        // Two codes 7 apart: no word is within 3 of both.
        let codes = [0, 0b111_1111];
        let is_near = |word: u64, code: u64| (word ^ code).count_ones() as usize <= most_bits(7);
        assert!((0..1 << 7).all(|word| codes.iter().filter(|&&code| is_near(word, code)).count() < 2));
    }

    #[test]
    fn random_bits_are_as_near_to_codes_in_their_turns_as_expected() {
        let layout = tagbus_family::Layout::circle(9).unwrap();
        let mut codes = tagbus_family::Family::published("tagCircle21h7").unwrap().codes()[..35].to_vec();
        for _ in 0..3 {
            let turned: Vec<u64> =
                codes[codes.len() - 35..].iter().map(|&code| layout.rotate90(code)).collect();
            codes.extend(turned);
        }
        let mut random = tagbus_scene::Stream::new(5);
        let quads: Vec<u64> = (0..200_000).map(|_| random.bits() >> 43).collect();
        for (bits, seen) in histogram(&quads, &codes)[..=3].iter().enumerate() {
            let expected = 4.0 * expected(quads.len(), 35, 21, bits);
            // Four standard deviations of a count.
            assert!(
                (f64::from(*seen) - expected).abs() < 4.0 * expected.sqrt(),
                "{bits}: {seen} of {expected}"
            );
        }
    }

    #[test]
    fn the_expected_numbers_are_those_that_the_paper_prints() {
        let of = |quads, codes, bits| [0, 1, 2, 3].map(|k| expected(quads, codes, bits, k));
        let near = |seen: [f64; 4], paper: [f64; 4]| {
            seen.iter().zip(paper).all(|(seen, paper)| (seen - paper).abs() <= 0.051)
        };
        assert!(near(of(6_090_028, 1500, 41), [0.0, 0.2, 3.4, 44.3]));
        assert!(near(of(6_128_551, 35, 21), [102.3, 2147.9, 21479.1, 136_034.0]));
    }
}
